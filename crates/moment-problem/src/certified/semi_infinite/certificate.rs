//! Is y . a(z) <= p(z) on the whole interval? Rigorous suprema, and the places where it fails.

use super::prepared::{Cell, HALF_CELL, PreparedBasis, curvature_range};
use crate::arithmetic::{Ball, DoubleDouble, Jet};

/// The step function that the dual function must stay below.
///
/// `Lower`: p = 1 on \[0, z_f), 0 on \[z_f, 1\], whose minimal expectation is the lower bound.
/// `Upper`: p = 0 on \[0, z_f\], 1 on (z_f, 1\], whose minimal expectation is 1 minus the upper bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Step {
    Lower { z_f: f64 },
    Upper { z_f: f64 },
}

impl Step {
    pub(crate) fn at(self, z: f64) -> f64 {
        let one = match self {
            Self::Lower { z_f } => z < z_f,
            Self::Upper { z_f } => z > z_f,
        };
        f64::from(u8::from(one))
    }

    pub(crate) fn z_f(self) -> f64 {
        match self {
            Self::Lower { z_f } | Self::Upper { z_f } => z_f,
        }
    }

    /// Maximal intervals with the value of p on them; the jump belongs to the side where p is 0, so testing the
    /// closure of the other side demands nothing more.
    fn pieces(self) -> [(f64, f64, f64); 2] {
        let z_f = self.z_f();
        let (before, after) = if matches!(self, Self::Lower { .. }) { (1.0, 0.0) } else { (0.0, 1.0) };
        [(0.0, z_f, before), (z_f, 1.0, after)]
    }
}

/// Excess over p up to which a dual function counts as feasible. The proved bound is lowered by what is left, so this
/// trades time for sharpness only.
const EXCESS_TOLERANCE: f64 = 2e-11;

/// Excess from which the exchange adds a depth: half of what the proof accepts, so that the proof need not resolve
/// the difference between its bounds and the function.
pub(crate) const SEARCH_TOLERANCE: f64 = 0.5 * EXCESS_TOLERANCE;

/// Bounds this close above a value of the function are not refined.
const RESOLUTION: f64 = 0.1 * EXCESS_TOLERANCE;

/// Cells that the rigorous search may examine before it settles for what it has.
const MAX_EXAMINED: usize = 20_000;

impl PreparedBasis {
    /// A number that max(y . a(z) - p(z)) over \[0, 1\] provably does not exceed (infinite if nothing can be said).
    ///
    /// # Errors
    /// An excess that is attained somewhere and above `hopeless`: whoever asks has no use for a proof then.
    pub(crate) fn excess(&self, y: &[DoubleDouble], step: Step, hopeless: f64) -> Result<f64, f64> {
        let rounded: Vec<f64> = y.iter().map(|y| y.to_f64()).collect();
        let coefficients = self.coefficients(y);
        let mut proof = Proof { basis: self, coefficients: &coefficients, examined: 0, worst: 0.0 };
        for (low, high, p) in step.pieces() {
            if low == high && p == 1.0 {
                continue; // empty half-open piece
            }
            for cell in self.cells_between(low, high) {
                let (left, right) = (cell.centre - HALF_CELL, cell.centre + HALF_CELL);
                let whole = left >= low && right <= high;
                let bound = if whole { proof.cell_bound(cell, &rounded, p) } else { f64::INFINITY };
                if bound - p <= EXCESS_TOLERANCE {
                    proof.worst = proof.worst.max(bound - p);
                } else {
                    proof.examine((left.max(low), right.min(high)), p, hopeless)?;
                }
            }
        }
        Ok(proof.worst)
    }

    fn cells_between(&self, low: f64, high: f64) -> &[Cell] {
        let count = self.cells.len();
        let first = ((low * count as f64).floor() as usize).min(count - 1);
        let last = ((high * count as f64).ceil() as usize).clamp(first + 1, count);
        &self.cells[first..last]
    }

    /// Local maxima of y . a - p on \[0, 1\] that exceed `tolerance`, with the number of points and intervals examined for them. Not
    /// rigorous: proposes columns.
    pub(super) fn violations(&self, y: &[DoubleDouble], step: Step, tolerance: f64) -> (Vec<f64>, usize) {
        let rounded: Vec<f64> = y.iter().map(|y| y.to_f64()).collect();
        let coefficients = self.coefficients(y);
        let mut search =
            Search { basis: self, coefficients: &coefficients, tolerance, found: Vec::new(), examined: 0 };
        for (low, high, p) in step.pieces() {
            if low == high && p == 1.0 {
                continue; // empty half-open piece
            }
            for cell in self.cells_between(low, high) {
                let (left, right) = ((cell.centre - HALF_CELL).max(low), (cell.centre + HALF_CELL).min(high));
                let model = CellModel::new(cell, &rounded);
                let whole = right - left == 2.0 * HALF_CELL;
                if whole && model.bound() - p <= tolerance {
                    continue;
                }
                if model.curvature.1 < 0.0 {
                    search.consider_peak(model.vertex(cell.centre), left, right, p);
                } else {
                    search.descend((left, right), (low, high), p);
                }
            }
        }
        (search.found, search.examined)
    }

    /// Highest point found of the function in \[left, right\], by Newton's method from `start`, its value, and how many
    /// evaluations that took.
    fn peak(&self, coefficients: &[DoubleDouble], start: f64, left: f64, right: f64) -> (f64, f64, usize) {
        let mut best = (start, f64::NEG_INFINITY);
        let (mut z, mut evaluations) = (start, 0);
        while evaluations < 20 {
            evaluations += 1;
            let at = self.function(coefficients, Jet::variable(DoubleDouble::from(z)));
            let (value, slope, curvature) = (at.value.to_f64(), at.first.to_f64(), at.second.to_f64());
            if value > best.1 {
                best = (z, value);
            }
            let next = if curvature < 0.0 {
                z - slope / curvature
            } else if slope > 0.0 {
                right
            } else {
                left
            };
            let next = next.clamp(left, right);
            // A further step would raise the value by less than anything that matters.
            if next.is_nan() || (slope * (next - z)).abs() < 0.02 * SEARCH_TOLERANCE {
                break;
            }
            z = next;
        }
        (best.0, best.1, evaluations)
    }
}

/// Collects local maxima.
struct Search<'a> {
    basis: &'a PreparedBasis,
    coefficients: &'a [DoubleDouble],
    tolerance: f64,
    found: Vec<f64>,
    examined: usize,
}

impl Search<'_> {
    fn consider_peak(&mut self, start: f64, left: f64, right: f64, p: f64) {
        let start = start.clamp(left, right);
        let (z, value, evaluations) = self.basis.peak(self.coefficients, start, left, right);
        self.examined += evaluations;
        if value - p > self.tolerance {
            self.found.push(z);
        }
    }

    /// Splits an interval until the function is below p, monotone or concave on each part.
    fn descend(&mut self, interval: (f64, f64), piece: (f64, f64), p: f64) {
        let proof = Proof { basis: self.basis, coefficients: self.coefficients, examined: 0, worst: 0.0 };
        let mut stack = vec![interval];
        while let Some((low, high)) = stack.pop() {
            self.examined += 1;
            let Enclosure { bound, shape, .. } = proof.bound(low, high);
            let middle = 0.5 * (low + high);
            let divisible = middle > low && middle < high && self.examined < MAX_EXAMINED;
            match shape {
                _ if bound - p <= self.tolerance => {}
                Shape::Concave => self.consider_peak(middle, low, high, p),
                // Inside the piece the neighbour has the maximum.
                Shape::Rising if high < piece.1 => {}
                Shape::Falling if low > piece.0 => {}
                Shape::Rising => self.consider_peak(high, high, high, p),
                Shape::Falling => self.consider_peak(low, low, low, p),
                Shape::Unknown if divisible => stack.extend([(low, middle), (middle, high)]),
                Shape::Unknown => self.consider_peak(middle, low, high, p),
            }
        }
    }
}

/// What is proved of the function on an interval.
struct Enclosure {
    /// Above all values.
    bound: f64,
    /// Not above the largest value.
    value: f64,
    shape: Shape,
}

#[derive(Clone, Copy, PartialEq)]
enum Shape {
    Rising,
    Falling,
    Concave,
    Unknown,
}

/// Quadratic model of y . a on one cell from the table.
struct CellModel {
    value: f64,
    slope: f64,
    curvature: (f64, f64),
    /// Bound on the rounding of value and slope terms.
    rounding: f64,
}

impl CellModel {
    fn new(cell: &Cell, y: &[f64]) -> Self {
        let mut model = Self { value: 0.0, slope: 0.0, curvature: (0.0, 0.0), rounding: 0.0 };
        let (mut size, mut bend) = (0.0, 0.0);
        for ((&y, &(a, a1)), &(low, high)) in y.iter().zip(&cell.values).zip(&cell.curvature) {
            model.value += y * a;
            model.slope += y * a1;
            model.curvature.0 += (y * low).min(y * high);
            model.curvature.1 += (y * low).max(y * high);
            size += (y * a).abs() + (y * a1).abs() * HALF_CELL;
            bend += (y * low).abs().max((y * high).abs());
        }
        // 32 roundings cover the sums of at most 17 terms and the rounding of the table and of y.
        let relative = 32.0 * f64::EPSILON;
        model.rounding = size * relative;
        model.curvature.0 -= bend * relative;
        model.curvature.1 += bend * relative;
        model
    }

    /// Upper bound over the cell by Taylor's formula.
    fn bound(&self) -> f64 {
        self.value
            + self.slope.abs() * HALF_CELL
            + 0.5 * self.curvature.1.max(0.0) * HALF_CELL * HALF_CELL
            + self.rounding
    }

    /// Where the model is highest; not clamped to the cell.
    fn vertex(&self, centre: f64) -> f64 {
        let curvature = 0.5 * (self.curvature.0 + self.curvature.1);
        if curvature < 0.0 {
            centre - self.slope / curvature
        } else {
            centre + HALF_CELL.copysign(self.slope)
        }
    }
}

struct Proof<'a> {
    basis: &'a PreparedBasis,
    coefficients: &'a [DoubleDouble],
    examined: usize,
    worst: f64,
}

impl Proof<'_> {
    /// Upper bound of the function on a whole cell, from the table and at most one evaluation.
    fn cell_bound(&self, cell: &Cell, y: &[f64], p: f64) -> f64 {
        let model = CellModel::new(cell, y);
        let bound = model.bound();
        if bound - p <= EXCESS_TOLERANCE || model.curvature.1 >= 0.0 {
            return bound;
        }
        // Concave: expand at (nearly) the highest point, where the slope all but vanishes.
        let peak = model.vertex(cell.centre).clamp(cell.centre - HALF_CELL, cell.centre + HALF_CELL);
        let at = self.basis.function(self.coefficients, Jet::variable(Ball::point(DoubleDouble::from(peak))));
        let (value, slope) = (at.value.upper(), (at.first.lower(), at.first.upper()));
        let margin = 4.0 * f64::EPSILON * value.abs();
        let at_left_end = peak == cell.centre - HALF_CELL && slope.1 <= 0.0;
        let at_right_end = peak == cell.centre + HALF_CELL && slope.0 >= 0.0;
        if at_left_end || at_right_end {
            return value + margin;
        }
        let steepest = slope.0.abs().max(slope.1.abs());
        value + 0.5 * steepest * steepest / -model.curvature.1 * (1.0 + 1e-14) + margin
    }

    fn examine(&mut self, interval: (f64, f64), p: f64, hopeless: f64) -> Result<(), f64> {
        let mut stack = vec![interval];
        while let Some((low, high)) = stack.pop() {
            self.examined += 1;
            let Enclosure { bound, value, .. } = self.bound(low, high);
            let excess = bound - p;
            if value - p > hopeless {
                return Err(value - p);
            }
            let middle = 0.5 * (low + high);
            let divisible = middle > low && middle < high && self.examined + stack.len() < MAX_EXAMINED;
            if excess <= EXCESS_TOLERANCE || bound - value <= RESOLUTION || !divisible {
                self.worst = self.worst.max(excess);
            } else {
                stack.push((low, middle));
                stack.push((middle, high));
            }
        }
        Ok(())
    }

    /// Upper bound of the function on \[low, high\]: the best of Taylor's formula, monotonicity and concavity.
    fn bound(&self, low: f64, high: f64) -> Enclosure {
        let jet = |z: Ball| self.basis.function(self.coefficients, Jet::variable(z));
        let middle = 0.5 * (low + high);
        let half = 0.5 * (high - low) * (1.0 + 1e-15) + f64::MIN_POSITIVE;
        let at_middle = jet(Ball::point(DoubleDouble::from(middle)));
        let over = jet(Ball::interval(low, high));
        let (curvature_low, curvature_high) = curvature_range(&at_middle, &over, half);
        let (slope_low, slope_high) = (at_middle.first.lower(), at_middle.first.upper());
        let steepest = slope_low.abs().max(slope_high.abs());
        let value = at_middle.value.upper();
        let mut bound = value + steepest * half + 0.5 * curvature_high.max(0.0) * half * half;
        bound += 4.0 * f64::EPSILON * bound.abs();
        let bend = curvature_low.abs().max(curvature_high.abs()) * half;
        let mut highest = at_middle.value.lower();
        let mut end = |z: f64| {
            let value = jet(Ball::point(DoubleDouble::from(z))).value;
            highest = highest.max(value.lower());
            value.upper()
        };
        let shape = if slope_low - bend >= 0.0 {
            bound = bound.min(end(high));
            Shape::Rising
        } else if slope_high + bend <= 0.0 {
            bound = bound.min(end(low));
            Shape::Falling
        } else if curvature_high < 0.0 {
            let vertex = value + 0.5 * steepest * steepest / -curvature_high * (1.0 + 1e-14);
            bound = bound.min(vertex + 4.0 * f64::EPSILON * vertex.abs());
            Shape::Concave
        } else {
            Shape::Unknown
        };
        Enclosure { bound: if bound.is_nan() { f64::INFINITY } else { bound }, value: highest, shape }
    }
}
