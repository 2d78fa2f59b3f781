//! Exponential variance shadow maps: Cantelli's inequality in exponentially warped depth (MSM15 section 2, after
//! Lauritzen).
//!
//! With s = 2 z - 1 in \[-1, 1\] the warps are e^(c s) and -e^(-d s), both ascending; each gives a lower bound, and the
//! darker one is taken. It is a bound, not the sharp one of its four moments (MSM15 section 3). An exponent c in s is
//! an exponent 2 c in z: MSM15 writes e^(c z), implementations use s because it doubles what a format can hold.

use super::variance::{cantelli, rounding};
use super::{LARGEST_EXPONENT_WITH_SQUARE, Parts, exponent_of};
use crate::basis::{DepthBasis, signed};
use crate::bound::ShadowBound;
use crate::error::FilteringError;
use crate::spec::TechniqueSpec;
use crate::wgsl;
use moment_problem::arithmetic::Real;

/// Warps and their squares: two values with the ascending warp e^(c s), four with both.
#[derive(Clone, Copy)]
struct Warps {
    positive: f64,
    negative: Option<f64>,
}

impl DepthBasis for Warps {
    fn channels(&self) -> usize {
        if self.negative.is_some() { 4 } else { 2 }
    }

    fn evaluate<R: Real>(&self, z: R, out: &mut [R]) {
        let s = signed(z);
        let warped = (R::from_f64(self.positive) * s).exp();
        out[..2].copy_from_slice(&[warped, warped * warped]);
        if let Some(negative) = self.negative {
            let warped = -(R::from_f64(-negative) * s).exp();
            out[2..].copy_from_slice(&[warped, warped * warped]);
        }
    }
}

impl ShadowBound for Warps {
    fn name(&self) -> String {
        match self.negative {
            None => format!("EVSM 2, c = {}", self.positive),
            Some(negative) => format!("EVSM 4, c = {} and {negative}", self.positive),
        }
    }

    fn shade<R: Real>(&self, b: &[R], z_f: R) -> R {
        let s = signed(z_f);
        let first = relative_cantelli(b[0], b[1], (R::from_f64(self.positive) * s).exp());
        match self.negative {
            None => first,
            Some(negative) => first.max(relative_cantelli(b[2], b[3], -(R::from_f64(-negative) * s).exp())),
        }
    }

    fn shader(&self) -> Option<String> {
        wgsl::exponential_variance(self.positive, self.negative)
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

/// `exponent` is c, `negative_exponent` d, per unit of s; without d there are two channels.
pub(crate) fn parts(spec: &TechniqueSpec) -> Result<Parts, FilteringError> {
    let checked = |key, value| exponent_of(key, value, spec.format(), LARGEST_EXPONENT_WITH_SQUARE);
    let positive = checked("exponent", spec.exponent)?;
    let negative = spec.negative_exponent.map(|d| checked("negative_exponent", Some(d))).transpose()?;
    Ok(Parts::new(Warps { positive, negative }, Warps { positive, negative }))
}
