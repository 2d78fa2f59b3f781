//! The exact range of a row on an interval of depths, enclosed with interval arithmetic.

use super::transform::AffineTransform;
use crate::error::QuantizationError;
use crate::interval::DepthInterval;
use moment_problem::Basis;
use moment_problem::arithmetic::{Ball, DoubleDouble, Field, Jet};

/// Cells that the interval is split into at first.
const CELLS: usize = 32;

/// A cell is done when it can exceed the largest value seen by no more than this, relative to 1 or to that value:
/// some tens of roundings.
const SETTLED: f64 = 2e-14;

/// Halvings of a cell: below that its values differ by less than they are rounded.
const MAX_DEPTH: u32 = 44;

/// Cells in all; a range that takes more is returned as wide as it is known by then.
const MAX_CELLS: usize = 400_000;

/// A range and what is proved of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Least value that is attained.
    pub min: f64,
    /// Largest value that is attained.
    pub max: f64,
    /// No value is smaller.
    pub proved_min: f64,
    /// No value is larger.
    pub proved_max: f64,
}

/// Range of c_0 + c_1 b_1(z) + ... + c_m b_m(z) over an interval.
///
/// # Panics
/// If there is not one coefficient more than the basis has functions.
pub fn range(basis: &Basis, coefficients: &[DoubleDouble], interval: DepthInterval) -> Range {
    ranges(basis, &[coefficients.to_vec()], interval)[0]
}

/// Each function of the basis stretched to \[0, 1\] by itself, by its range on the interval.
///
/// # Errors
/// [`QuantizationError::NotInvertible`] for a function that is constant on the interval.
pub fn plain(basis: &Basis, interval: DepthInterval) -> Result<AffineTransform, QuantizationError> {
    let m = basis.len();
    let alone = |i: usize| {
        let mut coefficients = vec![DoubleDouble::from(0.0); m + 1];
        coefficients[i + 1] = DoubleDouble::from(1.0);
        range(basis, &coefficients, interval)
    };
    let ranges: Vec<Range> = (0..m).map(alone).collect();
    let factors = ranges.iter().map(|range| 1.0 / (range.max - range.min)).collect();
    let offset = ranges.iter().map(|range| -range.min / (range.max - range.min)).collect();
    AffineTransform::diagonal(factors, offset)
}

/// The largest value of one function: what is known so far.
struct Maximum {
    coefficients: Vec<DoubleDouble>,
    /// Attained.
    seen: f64,
    /// Bound on the cells that are done.
    settled: f64,
}

/// Ranges of several functions over an interval, which share the costly enclosures of the basis.
pub(crate) fn ranges(basis: &Basis, rows: &[Vec<DoubleDouble>], interval: DepthInterval) -> Vec<Range> {
    let least = f64::NEG_INFINITY;
    // The minimum of a function is the maximum of its negative.
    let both = rows.iter().flat_map(|row| [row.clone(), row.iter().map(|&c| -c).collect()]);
    let mut maxima: Vec<Maximum> = both
        .map(|coefficients| {
            assert_eq!(coefficients.len(), basis.len() + 1, "coefficients over 1, b_1, ..., b_m");
            Maximum { coefficients, seen: least, settled: least }
        })
        .collect();
    for z in [interval.start(), interval.end()] {
        let functions = basis.evaluate(Jet::variable(Ball::point(DoubleDouble::from(z))));
        for maximum in &mut maxima {
            let value = combined(&maximum.coefficients, &functions).value;
            maximum.seen = maximum.seen.max(value.lower());
            maximum.settled = maximum.settled.max(value.upper());
        }
    }
    let edge = |i: usize| match i {
        CELLS => interval.end(),
        _ => interval.start() + interval.length() * i as f64 / CELLS as f64,
    };
    let all: Vec<usize> = (0..maxima.len()).collect();
    let mut cells: Vec<Cell> =
        (0..CELLS).map(|i| Cell { low: edge(i), high: edge(i + 1), depth: 0, open: all.clone() }).collect();
    let mut count = 0;
    while let Some(mut cell) = cells.pop() {
        count += 1;
        let middle = cell.low + 0.5 * (cell.high - cell.low);
        let centre = basis.evaluate(Jet::variable(Ball::point(DoubleDouble::from(middle))));
        let over = basis.evaluate(Jet::variable(Ball::interval(cell.low, cell.high)));
        let half = (middle - cell.low).max(cell.high - middle);
        let last = cell.depth == MAX_DEPTH || count >= MAX_CELLS;
        cell.open.retain(|&index| {
            let maximum = &mut maxima[index];
            if maximum.settles(&centre, &over, half, last) {
                return false;
            }
            // Where the function is concave its peak is a Newton step away.
            let here = combined(&maximum.coefficients, &centre);
            let peak = middle - here.first.lower() / here.second.lower();
            if here.second.upper() < 0.0 && cell.low < peak && peak < cell.high {
                let functions = basis.evaluate(Jet::variable(Ball::point(DoubleDouble::from(peak))));
                let value = combined(&maximum.coefficients, &functions).value;
                maximum.seen = maximum.seen.max(value.lower());
                return !maximum.settles(&centre, &over, half, last);
            }
            true
        });
        if !cell.open.is_empty() {
            let depth = cell.depth + 1;
            cells.push(Cell { low: cell.low, high: middle, depth, open: cell.open.clone() });
            cells.push(Cell { low: middle, high: cell.high, depth, open: cell.open });
        }
    }
    let range = |pair: &[Maximum]| Range {
        min: -pair[1].seen,
        max: pair[0].seen,
        proved_min: -pair[1].settled,
        proved_max: pair[0].settled,
    };
    maxima.chunks_exact(2).map(range).collect()
}

/// A part of the interval, and the functions whose values on it may still be the largest.
struct Cell {
    low: f64,
    high: f64,
    depth: u32,
    open: Vec<usize>,
}

impl Maximum {
    /// Whether the cell holds no value that matters, given the basis at its centre and over all of it.
    fn settles(&mut self, centre: &[Jet<Ball>], over: &[Jet<Ball>], half: f64, last: bool) -> bool {
        let size = |ball: Ball| ball.upper().abs().max(ball.lower().abs());
        let (centre, over) = (combined(&self.coefficients, centre), combined(&self.coefficients, over));
        self.seen = self.seen.max(centre.value.lower());
        let slope = size(centre.first);
        // Directly, and by the mean value theorem, which does not suffer where large coefficients cancel.
        let curvature = over.second.upper().min(centre.second.upper() + size(over.third) * half);
        let rise = if curvature < 0.0 {
            // Concave: no parabola through the middle with at least this curvature rises more.
            (slope * half).min(slope * slope / (-2.0 * curvature))
        } else {
            slope * half + 0.5 * curvature * half * half
        };
        let bound = (centre.value.upper() + rise).min(over.value.upper());
        let bound = if bound.is_nan() { f64::INFINITY } else { bound };
        let done = bound <= self.seen + SETTLED * self.seen.abs().max(1.0) || last;
        if done {
            self.settled = self.settled.max(bound);
        }
        done
    }
}

/// The function with the given coefficients over 1, b_1, ..., b_m.
fn combined<T: Field>(coefficients: &[DoubleDouble], functions: &[Jet<T>]) -> Jet<T> {
    let constant = Jet::from_double_double(coefficients[0]);
    let terms = functions.iter().zip(&coefficients[1..]);
    terms.fold(constant, |sum, (&f, &c)| sum + f.scale(T::from_double_double(c)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(basis: &str, coefficients: &[f64], interval: DepthInterval) -> Range {
        let coefficients: Vec<DoubleDouble> = coefficients.iter().map(|&c| DoubleDouble::from(c)).collect();
        range(&basis.parse().unwrap(), &coefficients, interval)
    }

    #[test]
    fn ranges_of_functions_that_are_known() {
        // (z - 3/8)^2 has its least value between any samples.
        let parabola = of("z,z^2", &[0.140625, -0.75, 1.0], DepthInterval::UNIT);
        assert!(parabola.min.abs() < 1e-13 && (parabola.max - 25.0 / 64.0).abs() < 1e-13, "{parabola:?}");
        assert!(parabola.proved_min <= 0.0 && parabola.proved_min > -1e-13, "{parabola:?}");
        assert!(parabola.proved_max >= 25.0 / 64.0 && parabola.proved_max < 25.0 / 64.0 + 1e-13);
        let sine = of("sin(4pi z)", &[0.5, 2.0], DepthInterval::UNIT);
        // What is seen may fall short of the extremum by SETTLED.
        assert!((sine.min + 1.5).abs() < 3.0 * SETTLED && (sine.max - 2.5).abs() < 3.0 * SETTLED, "{sine:?}");
        assert!(sine.proved_max - sine.max < 1e-13);
        // T_8, whose coefficients cancel.
        let chebyshev = [1.0, 0.0, -32.0, 0.0, 160.0, 0.0, -256.0, 0.0, 128.0];
        let eight = of("power:8", &chebyshev, DepthInterval::SIGNED);
        assert!((eight.min + 1.0).abs() < 1e-14 && (eight.max - 1.0).abs() < 1e-14);
        assert!(eight.proved_max - 1.0 < 1e-12 && eight.proved_min + 1.0 > -1e-12, "{eight:?}");
    }
}
