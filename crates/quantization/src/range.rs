//! The exact range of a row on an interval of depths, enclosed with interval arithmetic.

use crate::interval::DepthInterval;
use moment_problem::Basis;
use moment_problem::arithmetic::{Ball, DoubleDouble, Field, Jet};

/// Cells that the interval is split into at first.
const CELLS: usize = 64;

/// A cell is done when it can exceed the largest value seen by no more than this.
const SETTLED: f64 = 1e-14;

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
    assert_eq!(coefficients.len(), basis.len() + 1, "coefficients of a row over 1, b_1, ..., b_m");
    let negative: Vec<DoubleDouble> = coefficients.iter().map(|&c| -c).collect();
    let (max, proved_max) = largest(basis, coefficients, interval);
    let (min, proved_min) = largest(basis, &negative, interval);
    Range { min: -min, max, proved_min: -proved_min, proved_max }
}

/// Largest value seen and the bound that no value exceeds.
fn largest(basis: &Basis, coefficients: &[DoubleDouble], interval: DepthInterval) -> (f64, f64) {
    let (start, end) = (interval.start(), interval.end());
    let value = |z: f64| function(basis, coefficients, Jet::variable(DoubleDouble::from(z))).value.to_f64();
    let mut seen = value(start).max(value(end));
    let mut settled = seen;
    let edge = |i: usize| if i == CELLS { end } else { start + interval.length() * i as f64 / CELLS as f64 };
    let mut cells: Vec<(f64, f64, u32)> = (0..CELLS).map(|i| (edge(i), edge(i + 1), 0)).collect();
    let mut count = 0;
    while let Some((low, high, depth)) = cells.pop() {
        count += 1;
        let middle = low + 0.5 * (high - low);
        let half = (middle - low).max(high - middle);
        let centre = function(basis, coefficients, Jet::variable(Ball::point(DoubleDouble::from(middle))));
        let over = function(basis, coefficients, Jet::variable(Ball::interval(low, high)));
        let slope = centre.first.upper().abs().max(centre.first.lower().abs());
        // Directly, and by the mean value theorem, which does not suffer where large coefficients cancel.
        let bend = over.third.lower().abs().max(over.third.upper().abs()) * half;
        let curvature = over.second.upper().min(centre.second.upper() + bend);
        seen = seen.max(value(middle));
        if curvature < 0.0 {
            let peak = middle - centre.first.lower() / centre.second.lower();
            seen = seen.max(value(peak.clamp(low, high)));
        }
        let rise = if curvature < 0.0 {
            // Concave: no parabola through the middle with at least this curvature rises more.
            (slope * half).min(slope * slope / (-2.0 * curvature))
        } else {
            slope * half + 0.5 * curvature * half * half
        };
        let bound = (centre.value.upper() + rise).min(over.value.upper());
        if bound <= seen + SETTLED || depth == MAX_DEPTH || count >= MAX_CELLS {
            settled = settled.max(bound);
        } else {
            cells.extend([(low, middle, depth + 1), (middle, high, depth + 1)]);
        }
    }
    // The ends were seen in double-double: half a unit in the last place.
    let rounding = f64::EPSILON * seen.abs().max(1.0);
    (seen, if settled.is_nan() { f64::INFINITY } else { settled.max(seen) + rounding })
}

fn function<T: Field>(basis: &Basis, coefficients: &[DoubleDouble], z: Jet<T>) -> Jet<T> {
    let constant = Jet::from_double_double(coefficients[0]);
    let terms = basis.functions().iter().zip(&coefficients[1..]);
    terms.fold(constant, |sum, (f, &c)| sum + f.evaluate(z).scale(T::from_double_double(c)))
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
        // (z - 1/3)^2 has its least value between any samples.
        let parabola = of("z,z^2", &[1.0 / 9.0, -2.0 / 3.0, 1.0], DepthInterval::UNIT);
        assert!(parabola.min.abs() < 1e-15 && (parabola.max - 4.0 / 9.0).abs() < 1e-15, "{parabola:?}");
        assert!(parabola.proved_min <= 0.0 && parabola.proved_min > -1e-13, "{parabola:?}");
        assert!(parabola.proved_max >= 4.0 / 9.0 && parabola.proved_max < 4.0 / 9.0 + 1e-13);
        let sine = of("sin(4pi z)", &[0.5, 2.0], DepthInterval::UNIT);
        assert!((sine.min + 1.5).abs() < 1e-14 && (sine.max - 2.5).abs() < 1e-14, "{sine:?}");
        assert!(sine.proved_max - sine.max < 1e-13);
        // T_8, whose coefficients cancel.
        let chebyshev = [1.0, 0.0, -32.0, 0.0, 160.0, 0.0, -256.0, 0.0, 128.0];
        let eight = of("power:8", &chebyshev, DepthInterval::SIGNED);
        assert!((eight.min + 1.0).abs() < 1e-14 && (eight.max - 1.0).abs() < 1e-14);
        assert!(eight.proved_max - 1.0 < 1e-12 && eight.proved_min + 1.0 > -1e-12, "{eight:?}");
    }
}
