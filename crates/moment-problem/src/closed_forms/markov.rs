//! One monotone moment: exponential shadow maps (Markov's inequality) and BHS16's two-depth reconstruction.

use super::hamburger::Pair;
use crate::arithmetic::Real;

/// Bounds from E\[e^(c z)\], c > 0, for depths on the whole line: exponential shadow maps (MSM15 section 2).
///
/// Markov's inequality bounds the mass from z_f on by E\[e^(c z)\] / e^(c z_f); the upper bound is trivial. The
/// argument is E\[e^(c z)\] e^(-c z_f), formed by the caller in whatever way does not overflow.
#[inline(always)]
pub fn markov_line<R: Real>(ratio: R) -> Pair<R> {
    Pair::clamped(R::one() - ratio, R::one())
}

/// The two depths and weights with the given first three power moments (BHS16 Algorithm 1): `[(z2, w2), (z3, w3)]`
/// with z2 <= z3.
///
/// Where the variance is not positive, both depths are the mean and the first weight is 1 (BHS16's rule).
pub fn two_depths<R: Real>(moments: &[R; 3]) -> [(R, R); 2] {
    let [b1, b2, b3] = *moments;
    let variance = b2 - b1 * b1;
    let positive = variance > R::from_f64(R::TINY); // false for NaN, too
    if !positive {
        return [(b1, R::one()), (b1, R::zero())];
    }
    // About the mean: u^2 - (mu_3 / variance) u - variance = 0. The product of the roots is -variance, so they
    // straddle the mean and neither cancels.
    let skew = (b3 - b1 * (b2 + b2 + b2 - (b1 * b1 + b1 * b1))) / variance;
    let [low, high] = super::roots::quadratic(-skew, -variance);
    let width = high - low;
    let weight = if width > R::zero() { (-(low / width)).clamp_unit() } else { R::zero() };
    [(b1 + low, R::one() - weight), (b1 + high, weight)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_depths_are_recovered_exactly() {
        let (z, w) = ([0.2f64, 0.9], [0.75, 0.25]);
        let b = [1, 2, 3].map(|k| w[0] * z[0].powi(k) + w[1] * z[1].powi(k));
        let [(z2, w2), (z3, w3)] = two_depths(&b);
        for (found, exact) in [(z2, z[0]), (z3, z[1]), (w2, w[0]), (w3, w[1])] {
            assert!((found - exact).abs() < 1e-14);
        }
        assert_eq!(two_depths(&[0.3f64, 0.09, 0.027]), [(0.3, 1.0), (0.3, 0.0)]);
        assert_eq!(two_depths(&[0.3f64, f64::NAN, 0.027])[0].1, 1.0);
    }

    #[test]
    fn markov_never_exceeds_the_mass_in_front() {
        let c = 5.0f64;
        let (front, z_f) = (0.3, 0.6);
        let at_zero = (c * (0.0 - z_f)).exp();
        assert!(markov_line(front * at_zero + (1.0 - front)).lower <= front);
    }
}
