//! Variance shadow maps: b(z) = (z, z^2) and Cantelli's inequality (MSM15 section 2, after Donnelly and Lauritzen).

use super::Parts;
use crate::basis::Powers;
use crate::bound::ShadowBound;
use crate::error::FilteringError;
use crate::spec::TechniqueSpec;
use crate::wgsl;
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

/// Sharp for depths on the whole line.
struct Cantelli;

impl ShadowBound for Cantelli {
    fn name(&self) -> String {
        "VSM".to_owned()
    }

    fn shade<R: Real>(&self, b: &[R], z_f: R) -> R {
        cantelli(b[0], b[1], z_f)
    }

    fn shader(&self) -> Option<String> {
        wgsl::variance()
    }
}

/// Without parameters.
pub(crate) fn parts(_: &TechniqueSpec) -> Result<Parts, FilteringError> {
    Ok(Parts::new(Powers { order: 2, signed: false }, Cantelli))
}
