//! Exponential variance shadow maps: Cantelli's inequality in exponentially warped depth (MSM15 section 2, after
//! Lauritzen).
//!
//! With s = 2 z - 1 in \[-1, 1\] the warps are e^(c s) and -e^(-d s), both ascending; each gives a lower bound, and the
//! darker one is taken. It is a bound, not the sharp one of its four moments (MSM15 section 3). An exponent c in s is
//! an exponent 2 c in z: MSM15 writes e^(c z), implementations use s because it doubles what a format can hold.

use super::variance::{cantelli, rounding};
use crate::error::FilteringError;
use crate::real_time::{RealTime, in_real_time};
use crate::technique::{StorageFormat, Technique, check_exponent, unit};
use moment_problem::arithmetic::Real;

/// Exponential variance shadow map with two channels (positive warp) or four (both warps).
#[derive(Clone, Copy, Debug)]
pub struct ExponentialVariance {
    positive: f64,
    negative: Option<f64>,
    format: StorageFormat,
}

impl ExponentialVariance {
    /// Exponents per unit of s; without a negative one there are two channels.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] for exponents that are not positive or whose squares overflow the format (42 in
    /// f32, 5.54 in f16).
    pub fn new(positive: f64, negative: Option<f64>, format: StorageFormat) -> Result<Self, FilteringError> {
        let limit = format.largest_exponent_with_square();
        check_exponent("positive", positive, format, limit)?;
        if let Some(negative) = negative {
            check_exponent("negative", negative, format, limit)?;
        }
        Ok(Self { positive, negative, format })
    }

    fn encode_in<R: Real>(&self, depth: R, out: &mut [R]) {
        let s = signed(unit(depth));
        let warped = (R::from_f64(self.positive) * s).exp();
        out[..2].copy_from_slice(&[warped, warped * warped]);
        if let Some(negative) = self.negative {
            let warped = -(R::from_f64(-negative) * s).exp();
            out[2..].copy_from_slice(&[warped, warped * warped]);
        }
    }

    fn shade_in<R: Real>(&self, filtered: &[R], z_f: R) -> R {
        let s = signed(unit(z_f));
        let first = relative_cantelli(filtered[0], filtered[1], (R::from_f64(self.positive) * s).exp());
        match self.negative {
            None => first,
            Some(negative) => {
                first.max(relative_cantelli(filtered[2], filtered[3], -(R::from_f64(-negative) * s).exp()))
            }
        }
    }
}

/// [`cantelli`] with everything divided by the mean: near either end of the depth range squares of warped depths are
/// subnormal in single precision, and graphics processors may take these for 0.
fn relative_cantelli<R: Real>(mean: R, second: R, z_f: R) -> R {
    let offset = z_f - mean;
    if mean == R::zero() {
        return cantelli(mean, second, z_f);
    }
    if offset <= R::zero() {
        return R::zero();
    }
    let inverse = R::one() / mean;
    let distance = offset * inverse;
    let second = second * inverse * inverse;
    let variance = (second + R::from_f64(rounding::<R>()) * second.abs() - R::one()).abs();
    // In this form an infinite square of the distance gives 1.
    (R::one() / (R::one() + variance / (distance * distance))).clamp_unit()
}

/// s = 2 z - 1.
fn signed<R: Real>(z: R) -> R {
    z + z - R::one()
}

in_real_time!(ExponentialVariance, |technique| {
    shaders::exponential_variance(technique.positive, technique.negative)
});

impl Technique for ExponentialVariance {
    fn name(&self) -> String {
        match self.negative {
            None => format!("EVSM 2, c = {}", self.positive),
            Some(negative) => format!("EVSM 4, c = {} and {negative}", self.positive),
        }
    }

    fn channels(&self) -> usize {
        if self.negative.is_some() { 4 } else { 2 }
    }

    fn bits_per_texel(&self) -> usize {
        self.channels() * self.format.bits()
    }

    fn encode(&self, depth: f64, out: &mut [f64]) {
        self.encode_in(depth, out);
    }

    fn shade(&self, filtered: &[f64], z_f: f64) -> Result<f64, FilteringError> {
        Ok(self.shade_in(filtered, z_f))
    }

    fn real_time(&self) -> Option<&dyn RealTime> {
        Some(self)
    }

    fn is_lower_bound(&self) -> bool {
        true
    }
}
