//! An upper bound on the gain of every transform, with a proof.
//!
//! Choose m + 1 depths z_0, ..., z_m. Their images under a valid theta span a simplex in the unit box, and no simplex
//! in the unit box is larger than the largest determinant h_m of an m x m matrix of zeros and ones, over m!. Its
//! volume is also |det theta| |V| / m! with V = det(1, b(z_k)), so that log2 |det theta| <= log2(h_m / |V|). The depths
//! with the largest |V| (Fekete points) give the sharpest such bound.
//!
//! For powers these depths are the support of the D-optimal design, and Hadamard's inequality h_m <=
//! (m+1)^((m+1)/2) / 2^m turns the bound into that of the ellipsoid of least volume around the curve. The exact h_m are
//! smaller unless m + 1 is 2 or a multiple of four: 0.38 bits for m = 2, 0.66 for m = 6.

use super::chebyshev;
use super::gain::gain_bits;
use super::working_basis::WorkingBasis;
use crate::error::QuantizationError;
use crate::interval::DepthInterval;
use moment_problem::Basis;
use moment_problem::arithmetic::{Ball, DoubleDouble};
use nalgebra::DMatrix;

/// Largest determinant of an m x m matrix of zeros and ones, m = 0 to 16 (Hadamard's maximal determinant problem, OEIS
/// A003432; each value is proved).
const LARGEST_BINARY_DETERMINANT: [u32; 17] =
    [1, 1, 1, 2, 3, 5, 9, 32, 56, 144, 320, 1458, 3645, 9477, 25515, 131_072, 327_680];

/// Rounds of moving every depth to its best place. Convergence is fast; any depths give a valid bound.
const MAX_ROUNDS: usize = 200;

/// Relative growth of |V| in a round that counts as none.
const SETTLED: f64 = 1e-13;

/// log2 |det theta| of no valid theta exceeds the returned number.
///
/// # Errors
/// As the optimiser's for the basis and the interval.
pub fn bound(basis: &Basis, interval: DepthInterval) -> Result<f64, QuantizationError> {
    let working = WorkingBasis::normalised(basis, interval)?;
    let bits = bound_of(&working)?;
    // Powers on an interval are those on another times a matrix whose determinant is known.
    Ok(bits + gain_bits(basis, working.interval, 0.0) - gain_bits(basis, interval, 0.0))
}

pub(crate) fn bound_of(working: &WorkingBasis) -> Result<f64, QuantizationError> {
    let depths: Vec<f64> = fekete(working).into_iter().map(|t| working.interval.at(t)).collect();
    let largest = f64::from(LARGEST_BINARY_DETERMINANT[working.len()]);
    let volume = log2_volume(&working.basis, &depths);
    // The sums of m logarithms are rounded; the margin is a thousand times that.
    const MARGIN: f64 = 1e-11;
    let bits = largest.log2() - volume + MARGIN;
    if bits.is_finite() {
        return Ok(bits);
    }
    let name = working.basis.functions().last().map(|f| f.name().to_owned()).unwrap_or_default();
    Err(QuantizationError::Singular { name, share: 0.0, smallest: f64::MIN_POSITIVE })
}

/// t_0, ..., t_m with the largest |det(1, w(t_k))|, by moving one after the other.
fn fekete(working: &WorkingBasis) -> Vec<f64> {
    let m = working.len();
    let mut functions = vec![vec![1.0]];
    functions.extend(working.series.iter().cloned());
    let mut t: Vec<f64> = chebyshev::points(m);
    let row = |t: f64| -> Vec<f64> { functions.iter().map(|f| chebyshev::evaluate(f, t)).collect() };
    for _ in 0..MAX_ROUNDS {
        let mut growth = 1.0;
        for k in 0..=m {
            let matrix = DMatrix::from_fn(m + 1, m + 1, |i, j| row(t[i])[j]);
            let Some(inverse) = matrix.try_inverse() else {
                // Dependent by chance: leave the symmetric start.
                t.iter_mut().enumerate().for_each(|(i, t)| *t = (*t + 0.01 / (i + 2) as f64).min(1.0));
                continue;
            };
            // The Lagrange function of node k, 1 there and 0 at the other nodes: V grows by its value.
            let factors: Vec<f64> = inverse.column(k).iter().copied().collect();
            let lagrange = chebyshev::combination(&functions, &factors);
            let mut candidates = chebyshev::sign_changes(&chebyshev::derivative(&lagrange), -1.0, 1.0);
            candidates.extend([-1.0, 1.0]);
            for candidate in candidates {
                let value = chebyshev::evaluate(&lagrange, candidate).abs();
                if value > growth {
                    (growth, t[k]) = (value, candidate);
                }
            }
        }
        if growth - 1.0 < SETTLED {
            break;
        }
    }
    t
}

/// A lower bound of log2 |det(1, b(z_k))|; -infinity if it cannot be told from 0.
fn log2_volume(basis: &Basis, depths: &[f64]) -> f64 {
    let one = Ball::point(DoubleDouble::from(1.0));
    let mut rows: Vec<Vec<Ball>> = depths
        .iter()
        .map(|&z| {
            let mut row = vec![one];
            row.extend(basis.evaluate(Ball::point(DoubleDouble::from(z))));
            row
        })
        .collect();
    let mut bits = 0.0;
    let size = rows.len();
    let least = |ball: Ball| ball.lower().max(-ball.upper());
    for k in 0..size {
        let best = (k..size).max_by(|&a, &b| least(rows[a][k]).total_cmp(&least(rows[b][k])));
        rows.swap(k, best.unwrap_or(k));
        let pivot = rows[k][k];
        if least(pivot) <= 0.0 {
            return f64::NEG_INFINITY;
        }
        bits += least(pivot).log2();
        let (done, rest) = rows.split_at_mut(k + 1);
        for row in rest {
            let factor = row[k] / pivot;
            for (value, &above) in row.iter_mut().zip(&done[k]).skip(k + 1) {
                *value = *value - factor * above;
            }
        }
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest determinant of m rows out of all binary rows, by trying all sets of rows.
    fn largest_by_trial(m: usize) -> i64 {
        fn descend(rows: &mut Vec<i64>, first: i64, m: usize, best: &mut i64) {
            if rows.len() == m {
                *best = (*best).max(determinant(rows, m).abs());
                return;
            }
            for row in first..1 << m {
                rows.push(row);
                descend(rows, row + 1, m, best);
                rows.pop();
            }
        }
        let mut best = 0;
        descend(&mut Vec::new(), 1, m, &mut best);
        best
    }

    /// By cofactors along the first row, in whole numbers.
    fn determinant(rows: &[i64], m: usize) -> i64 {
        fn minor(rows: &[i64], columns: &[usize]) -> i64 {
            let [first, rest @ ..] = rows else { return 1 };
            let mut sum = 0;
            for (k, &column) in columns.iter().enumerate() {
                if first >> column & 1 == 1 {
                    let others: Vec<usize> = columns.iter().copied().filter(|&c| c != column).collect();
                    sum += if k % 2 == 0 { 1 } else { -1 } * minor(rest, &others);
                }
            }
            sum
        }
        minor(rows, &(0..m).collect::<Vec<_>>())
    }

    #[test]
    fn binary_determinants_by_exhaustion_and_hadamards_inequality() {
        for (m, &largest) in LARGEST_BINARY_DETERMINANT.iter().enumerate().take(5).skip(1) {
            assert_eq!(largest_by_trial(m), i64::from(largest), "{m}");
        }
        for (m, &h) in LARGEST_BINARY_DETERMINANT.iter().enumerate() {
            let n = (m + 1) as f64;
            let hadamard = n.powf(n / 2.0) / 2f64.powi(m as i32);
            assert!(f64::from(h) <= hadamard * (1.0 + 1e-12), "{m}");
            assert_eq!((f64::from(h) - hadamard).abs() < 1e-6 * hadamard, m < 2 || (m + 1) % 4 == 0, "{m}");
        }
    }

    #[test]
    fn order_two_is_closed_and_fekete_points_are_the_known_ones() {
        let bits = bound(&Basis::power(2), DepthInterval::UNIT).unwrap();
        assert!((2.0..2.0 + 1e-9).contains(&bits), "{bits}");
        // Fejer: the ends and the zeros of the derivative of a Legendre polynomial, +-1/sqrt(5) for four points.
        let working = WorkingBasis::new(&Basis::power(3), DepthInterval::SIGNED).unwrap();
        let mut t = fekete(&working);
        t.sort_by(f64::total_cmp);
        for (t, expected) in t.iter().zip([-1.0, -0.2f64.sqrt(), 0.2f64.sqrt(), 1.0]) {
            assert!((t - expected).abs() < 1e-6, "{t} {expected}");
        }
        // Sines and cosines: equally spaced depths, by the discrete Fourier transform det = 5^(5/2) / 4.
        let bits = bound(&Basis::trigonometric(2), DepthInterval::UNIT).unwrap();
        assert!((bits - (3.0 / (5f64.powf(2.5) / 4.0)).log2()).abs() < 1e-9, "{bits}");
    }
}
