//! Variance shadow maps: b(z) = (z, z^2) and Cantelli's inequality (MSM15 section 2, after Donnelly and Lauritzen).

use crate::error::FilteringError;
use crate::real_time::{RealTime, in_real_time};
use crate::technique::{Technique, unit};
use moment_problem::arithmetic::Real;
use moment_problem::hamburger::chebyshev;

/// Added to the variance, in units of the second moment: what rounding in two filter passes of up to 129 taps and in
/// the subtraction can take from it. Without it a kernel of depths that differ in their last bits, or a receiver at
/// exactly the one depth of its kernel, would be guessed from noise.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// The same in single precision, where it costs light leaks and is therefore no larger than what 9x9 kernels need.
const ROUNDING_SINGLE: f64 = 8.0 * f32::EPSILON as f64;

/// What is added to the variance in `R`, in units of the second moment.
pub(crate) fn rounding<R: Real>() -> f64 {
    if R::EPSILON < 1e-10 { ROUNDING } else { ROUNDING_SINGLE }
}

/// Cantelli's lower bound of the mass in front of `z_f` from mean and second moment in whatever warped depth.
pub(crate) fn cantelli<R: Real>(mean: R, second: R, z_f: R) -> R {
    chebyshev(&[mean, second + R::from_f64(rounding::<R>()) * second.abs()], z_f).lower
}

/// Variance shadow map on \[0, 1\], sharp for depths on the whole line.
#[derive(Clone, Copy, Debug, Default)]
pub struct Variance;

impl Variance {
    fn encode_in<R: Real>(&self, depth: R, out: &mut [R]) {
        let z = unit(depth);
        out.copy_from_slice(&[z, z * z]);
    }

    fn shade_in<R: Real>(&self, filtered: &[R], z_f: R) -> R {
        cantelli(filtered[0], filtered[1], unit(z_f))
    }
}

in_real_time!(Variance, |_| shaders::variance());

impl Technique for Variance {
    fn name(&self) -> String {
        "VSM".to_owned()
    }

    fn channels(&self) -> usize {
        2
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
