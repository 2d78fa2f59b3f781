//! Exponential shadow maps: b(z) = e^(c z) and Markov's inequality (MSM15 section 2, after Salvi and Annen et al.),
//! without a fallback to PCF, as in MSM15's comparison.

use super::{LARGEST_EXPONENT, Parts, exponent_of};
use crate::basis::DepthBasis;
use crate::bound::ShadowBound;
use crate::error::FilteringError;
use crate::spec::TechniqueSpec;
use crate::wgsl;
use moment_problem::arithmetic::Real;
use moment_problem::markov::markov_line;

/// e^(c z).
#[derive(Clone, Copy)]
struct Exponential {
    exponent: f64,
}

impl DepthBasis for Exponential {
    fn channels(&self) -> usize {
        1
    }

    fn evaluate<R: Real>(&self, z: R, out: &mut [R]) {
        out[0] = (R::from_f64(self.exponent) * z).exp();
    }
}

impl ShadowBound for Exponential {
    fn name(&self) -> String {
        format!("ESM c = {}", self.exponent)
    }

    /// 1 - E\[e^(c z)\] e^(-c z_f), clamped to 0.
    fn shade<R: Real>(&self, b: &[R], z_f: R) -> R {
        markov_line(b[0] * (R::from_f64(-self.exponent) * z_f).exp()).lower
    }

    fn shader(&self) -> Option<String> {
        wgsl::exponential(self.exponent)
    }
}

/// `exponent` is c, per depth range.
pub(crate) fn parts(spec: &TechniqueSpec) -> Result<Parts, FilteringError> {
    let exponent = exponent_of("exponent", spec.exponent, spec.format(), LARGEST_EXPONENT)?;
    Ok(Parts::new(Exponential { exponent }, Exponential { exponent }))
}
