//! Polynomials in Chebyshev form on \[-1, 1\]: the proxies in which rows are evaluated and their extrema found.

use std::f64::consts::PI;

/// Chebyshev points of the second kind t_k = cos(pi k / n), k = 0..n, symmetric to the last bit.
pub(crate) fn points(n: usize) -> Vec<f64> {
    (0..=n).map(|k| (PI * (n as f64 - 2.0 * k as f64) / (2.0 * n as f64)).sin()).collect()
}

/// Coefficients of the interpolant of `values` at [`points`].
pub(crate) fn coefficients(values: &[f64]) -> Vec<f64> {
    let n = values.len() - 1;
    let half_at_ends = |k: usize| if k == 0 || k == n { 0.5 } else { 1.0 };
    (0..=n)
        .map(|j| {
            let sum: f64 = values
                .iter()
                .enumerate()
                // The angle is reduced in whole numbers, where nothing is rounded.
                .map(|(k, v)| half_at_ends(k) * v * (PI * ((j * k) % (2 * n)) as f64 / n as f64).cos())
                .sum();
            2.0 / n as f64 * half_at_ends(j) * sum
        })
        .collect()
}

/// Value at t (Clenshaw).
pub(crate) fn evaluate(coefficients: &[f64], t: f64) -> f64 {
    let (mut next, mut after) = (0.0, 0.0);
    for &c in coefficients.iter().skip(1).rev() {
        (next, after) = (c + 2.0 * t * next - after, next);
    }
    coefficients.first().copied().unwrap_or_default() + t * next - after
}

/// Series of the sum of functions times factors.
pub(crate) fn combination(functions: &[Vec<f64>], factors: &[f64]) -> Vec<f64> {
    let length = functions.iter().map(Vec::len).max().unwrap_or(1);
    let mut sum = vec![0.0; length];
    for (function, &factor) in functions.iter().zip(factors) {
        sum.iter_mut().zip(function).for_each(|(s, &c)| *s += factor * c);
    }
    sum
}

/// Coefficients of the derivative.
pub(crate) fn derivative(coefficients: &[f64]) -> Vec<f64> {
    let n = coefficients.len().saturating_sub(1);
    let mut result = vec![0.0; n.max(1)];
    for j in (0..n).rev() {
        let beyond = result.get(j + 2).copied().unwrap_or_default();
        result[j] = beyond + 2.0 * (j + 1) as f64 * coefficients[j + 1];
    }
    result[0] *= 0.5;
    result
}

/// Samples per degree among which sign changes are looked for. Two roots between neighbouring samples are missed only
/// if the polynomial hardly leaves zero between them; whoever needs a proof uses [`crate::range`].
const SAMPLES_A_DEGREE: usize = 8;

/// Bisections per root: an interval of samples shrinks below the distance of machine numbers.
const BISECTIONS: usize = 60;

/// Zeros with a change of sign in \[low, high\], ascending.
pub(crate) fn sign_changes(coefficients: &[f64], low: f64, high: f64) -> Vec<f64> {
    let count = SAMPLES_A_DEGREE * coefficients.len().max(8);
    // Dense near the ends of [-1, 1], as the zeros of polynomials are.
    let (from, to) = (low.asin(), high.asin());
    let sample = |i: usize| (from + (to - from) * i as f64 / count as f64).sin().clamp(low, high);
    let mut zeros = Vec::new();
    let mut left = (low, evaluate(coefficients, low));
    for i in 1..=count {
        let t = sample(i);
        let right = (t, evaluate(coefficients, t));
        if right.1 == 0.0 {
            zeros.push(t);
        } else if left.1 != 0.0 && (left.1 < 0.0) != (right.1 < 0.0) {
            zeros.push(bisect(coefficients, left, right));
        }
        left = right;
    }
    zeros
}

fn bisect(coefficients: &[f64], mut left: (f64, f64), right: (f64, f64)) -> f64 {
    let mut end = right.0;
    for _ in 0..BISECTIONS {
        let t = 0.5 * (left.0 + end);
        let value = evaluate(coefficients, t);
        if (value < 0.0) == (left.1 < 0.0) {
            left = (t, value);
        } else {
            end = t;
        }
    }
    0.5 * (left.0 + end)
}

/// Least and largest value on \[low, high\]: at the ends and where the derivative vanishes.
pub(crate) fn extremes(coefficients: &[f64], low: f64, high: f64) -> (f64, f64) {
    let mut candidates = sign_changes(&derivative(coefficients), low, high);
    candidates.extend([low, high]);
    let values = candidates.iter().map(|&t| evaluate(coefficients, t));
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), v| (min.min(v), max.max(v)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_known_polynomial_and_its_extrema() {
        // T_3(t) + 2 = 4 t^3 - 3 t + 2: extremes 1 and 3, at +-1/2 and the ends.
        let values: Vec<f64> = points(8).iter().map(|t| 4.0 * t * t * t - 3.0 * t + 2.0).collect();
        let c = coefficients(&values);
        for (j, &value) in c.iter().enumerate() {
            let expected = [2.0, 0.0, 0.0, 1.0].get(j).copied().unwrap_or_default();
            assert!((value - expected).abs() < 1e-14, "{j}: {value}");
        }
        let slopes = derivative(&c);
        for t in [-0.9, -0.1, 0.4, 1.0] {
            assert!((evaluate(&slopes, t) - (12.0 * t * t - 3.0)).abs() < 1e-12);
        }
        let zeros = sign_changes(&slopes, -1.0, 1.0);
        assert_eq!(zeros.len(), 2);
        assert!((zeros[0] + 0.5).abs() < 1e-12 && (zeros[1] - 0.5).abs() < 1e-12, "{zeros:?}");
        let (min, max) = extremes(&c, -1.0, 1.0);
        assert!((min - 1.0).abs() < 1e-13 && (max - 3.0).abs() < 1e-13);
        let (min, _) = extremes(&c, 0.6, 1.0);
        assert!((min - (4.0 * 0.216 - 1.8 + 2.0)).abs() < 1e-13);
    }
}
