//! Is y . a(z) <= p(z) on the whole interval? Rigorous suprema, and the places where it fails.

use super::prepared::{Cell, HALF_CELL, PreparedBasis};
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
pub(crate) const EXCESS_TOLERANCE: f64 = 1e-11;

/// Cells that the rigorous search may examine before it settles for what it has.
const MAX_EXAMINED: usize = 20_000;

impl PreparedBasis {
    /// A number that max(y . a(z) - p(z)) over \[0, 1\] provably does not exceed (infinite if nothing can be said).
    pub(crate) fn excess(&self, y: &[DoubleDouble], step: Step) -> f64 {
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
                if whole {
                    let bound = cell_bound(cell, &rounded);
                    if bound - p <= EXCESS_TOLERANCE {
                        proof.worst = proof.worst.max(bound - p);
                        continue;
                    }
                }
                proof.examine(left.max(low), right.min(high), p);
            }
        }
        proof.worst
    }

    fn cells_between(&self, low: f64, high: f64) -> &[Cell] {
        let count = self.cells.len();
        let first = ((low * count as f64).floor() as usize).min(count - 1);
        let last = ((high * count as f64).ceil() as usize).clamp(first + 1, count);
        &self.cells[first..last]
    }

    /// Local maxima of y . a - p that exceed `tolerance`, as (z, excess). Not rigorous: proposes columns.
    pub(super) fn violations(&self, y: &[DoubleDouble], step: Step, tolerance: f64) -> Vec<(f64, f64)> {
        let rounded: Vec<f64> = y.iter().map(|y| y.to_f64()).collect();
        let coefficients = self.coefficients(y);
        let mut found: Vec<(f64, f64, usize)> = Vec::new();
        for (low, high, p) in step.pieces() {
            if low == high && p == 1.0 {
                continue;
            }
            let mut peaks: Vec<(f64, f64, f64)> = Vec::new();
            for cell in self.cells_between(low, high) {
                let (left, right) = ((cell.centre - HALF_CELL).max(low), (cell.centre + HALF_CELL).min(high));
                if right - left == 2.0 * HALF_CELL && cell_bound(cell, &rounded) - p <= tolerance {
                    continue;
                }
                let (z, value) = self.peak(&coefficients, left, right);
                if value - p > tolerance {
                    peaks.push((z, value - p, left));
                }
            }
            // Of neighbouring cells keep the highest: one column a peak is enough.
            for (i, &(z, excess, left)) in peaks.iter().enumerate() {
                let adjacent = |j: usize| {
                    peaks
                        .get(j)
                        .filter(|other| (other.2 - left).abs() < 3.0 * HALF_CELL)
                        .map_or(0.0, |other| other.1)
                };
                let before = if i > 0 { adjacent(i - 1) } else { 0.0 };
                if excess >= before && excess > adjacent(i + 1) {
                    found.push((z, excess, found.len()));
                }
            }
        }
        found.into_iter().map(|(z, excess, _)| (z, excess)).collect()
    }

    /// Highest point found of the function in \[left, right\].
    fn peak(&self, coefficients: &[DoubleDouble], left: f64, right: f64) -> (f64, f64) {
        let jet = |z: f64| self.function(coefficients, Jet::variable(DoubleDouble::from(z)));
        let mut best = (left, jet(left).value.to_f64());
        let mut consider = |z: f64| {
            let value = jet(z).value.to_f64();
            if value > best.1 {
                best = (z, value);
            }
        };
        consider(right);
        let mut z = 0.5 * (left + right);
        for _ in 0..6 {
            consider(z);
            let at = jet(z);
            let (slope, curvature) = (at.first.to_f64(), at.second.to_f64());
            let next = if curvature < 0.0 {
                z - slope / curvature
            } else if slope > 0.0 {
                right
            } else {
                left
            };
            let next = next.clamp(left, right);
            if next == z || next.is_nan() {
                break;
            }
            z = next;
        }
        consider(z);
        best
    }
}

/// Upper bound of y . a over the cell from its table entries, rounding included.
fn cell_bound(cell: &Cell, y: &[f64]) -> f64 {
    let (mut value, mut slope, mut curvature, mut size) = (0.0, 0.0, 0.0, 0.0);
    for ((&y, &(a, a1)), &(low, high)) in y.iter().zip(&cell.values).zip(&cell.curvature) {
        value += y * a;
        slope += y * a1;
        curvature += (y * low).max(y * high);
        size += (y * a).abs() + (y * a1).abs() * HALF_CELL;
    }
    // 32 roundings cover the sums of at most 17 terms and the rounding of the table and of y.
    value
        + slope.abs() * HALF_CELL
        + 0.5 * curvature.max(0.0) * HALF_CELL * HALF_CELL * (1.0 + 1e-12)
        + size * 32.0 * f64::EPSILON
}

struct Proof<'a> {
    basis: &'a PreparedBasis,
    coefficients: &'a [DoubleDouble],
    examined: usize,
    worst: f64,
}

impl Proof<'_> {
    fn examine(&mut self, low: f64, high: f64, p: f64) {
        let mut stack = vec![(low, high)];
        while let Some((low, high)) = stack.pop() {
            self.examined += 1;
            let excess = self.bound(low, high) - p;
            let middle = 0.5 * (low + high);
            let divisible = middle > low && middle < high && self.examined + stack.len() < MAX_EXAMINED;
            if excess <= EXCESS_TOLERANCE || !divisible {
                self.worst = self.worst.max(excess);
            } else {
                stack.push((low, middle));
                stack.push((middle, high));
            }
        }
    }

    /// Upper bound of the function on \[low, high\]: the best of Taylor's formula, monotonicity and concavity.
    fn bound(&self, low: f64, high: f64) -> f64 {
        let jet = |z: Ball| self.basis.function(self.coefficients, Jet::variable(z));
        let middle = 0.5 * (low + high);
        let half = 0.5 * (high - low) * (1.0 + 1e-15) + f64::MIN_POSITIVE;
        let at_middle = jet(Ball::point(DoubleDouble::from(middle)));
        let over = jet(Ball::interval(low, high));
        let (curvature_low, curvature_high) = (over.second.lower(), over.second.upper());
        let (slope_low, slope_high) = (at_middle.first.lower(), at_middle.first.upper());
        let steepest = slope_low.abs().max(slope_high.abs());
        let value = at_middle.value.upper();
        let mut bound = value + steepest * half + 0.5 * curvature_high.max(0.0) * half * half;
        bound += 4.0 * f64::EPSILON * bound.abs();
        let bend = curvature_low.abs().max(curvature_high.abs()) * half;
        if slope_low - bend >= 0.0 {
            bound = bound.min(jet(Ball::point(DoubleDouble::from(high))).value.upper());
        } else if slope_high + bend <= 0.0 {
            bound = bound.min(jet(Ball::point(DoubleDouble::from(low))).value.upper());
        } else if curvature_high < 0.0 {
            let vertex = value + 0.5 * steepest * steepest / -curvature_high * (1.0 + 1e-14);
            bound = bound.min(vertex + 4.0 * f64::EPSILON * vertex.abs());
        }
        if bound.is_nan() { f64::INFINITY } else { bound }
    }
}
