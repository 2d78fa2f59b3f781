//! Three moments as two depths (BHS16 Algorithm 1), so that a filtered texel can be resampled under a non-linear change
//! of depth.
//!
//! About the mean, depths are d with d^2 - (mu_3 / c_2) d - c_2 = 0, where c_2 is the variance and mu_3 the third
//! central moment; the product of the roots is -c_2, so that one lies on either side of the mean and neither cancels.

use moment_problem::arithmetic::Real;
use moment_problem::roots;

/// Two depths and their weights, which sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoDepths<R> {
    /// z_2 <= z_3. Moments of no distribution, or rounded ones, may put them anywhere.
    pub depths: [R; 2],
    /// w_2, w_3.
    pub weights: [R; 2],
}

/// The distribution of two depths that has the moments of z, z^2 and z^3. Without variance that is one depth.
pub fn two_depths<R: Real>([b1, b2, b3]: [R; 3]) -> TwoDepths<R> {
    let c2 = b2 - b1 * b1;
    let mu3 = b3 - b1 * b2 - (b1 + b1) * c2;
    let single = TwoDepths { depths: [b1; 2], weights: [R::one(), R::zero()] };
    let skew = mu3 / c2;
    // Not of NaN either.
    let has_variance = c2 > R::zero() && skew.is_finite();
    if !has_variance {
        return single;
    }
    let [near, far] = roots::quadratic(-skew, -c2);
    let apart = far - near;
    if apart > R::zero() {
        let weight = (-near / apart).clamp_unit();
        TwoDepths { depths: [b1 + near, b1 + far], weights: [R::one() - weight, weight] }
    } else {
        single
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_surfaces_and_one() {
        let (z, w) = ([0.2, 0.7], [0.3, 0.7]);
        let b = [1, 2, 3].map(|k| w[0] * f64::powi(z[0], k) + w[1] * f64::powi(z[1], k));
        let found = two_depths(b);
        for k in 0..2 {
            assert!((found.depths[k] - z[k]).abs() < 1e-14 && (found.weights[k] - w[k]).abs() < 1e-14);
        }
        let one = TwoDepths { depths: [0.5; 2], weights: [1.0, 0.0] };
        assert_eq!(two_depths([0.5, 0.25, 0.125]), one);
        assert_eq!(two_depths([0.5, 0.2, 0.125]), one);
    }
}
