//! Exponential shadow maps: b(z) = e^(c z) and Markov's inequality (MSM15 section 2, after Salvi and Annen et al.).

use crate::error::FilteringError;
use crate::real_time::{RealTime, in_real_time};
use crate::technique::{StorageFormat, Technique, check_exponent, unit};
use moment_problem::arithmetic::Real;
use moment_problem::markov::markov_line;

/// Exponential shadow map on \[0, 1\], without a fallback to PCF, as in MSM15's comparison.
#[derive(Clone, Copy, Debug)]
pub struct Exponential {
    exponent: f64,
    format: StorageFormat,
}

impl Exponential {
    /// c counts per depth range.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] for an exponent that is not positive or overflows the format (88 in f32).
    pub fn new(exponent: f64, format: StorageFormat) -> Result<Self, FilteringError> {
        check_exponent("exponent", exponent, format, format.largest_exponent())?;
        Ok(Self { exponent, format })
    }

    fn encode_in<R: Real>(&self, depth: R, out: &mut [R]) {
        out[0] = (R::from_f64(self.exponent) * unit(depth)).exp();
    }

    fn shade_in<R: Real>(&self, filtered: &[R], z_f: R) -> R {
        markov_line(filtered[0] * (R::from_f64(-self.exponent) * unit(z_f)).exp()).lower
    }
}

in_real_time!(Exponential, |technique| shaders::exponential(technique.exponent));

impl Technique for Exponential {
    fn name(&self) -> String {
        format!("ESM c = {}", self.exponent)
    }

    fn channels(&self) -> usize {
        1
    }

    fn bits_per_texel(&self) -> usize {
        self.format.bits()
    }

    fn encode(&self, depth: f64, out: &mut [f64]) {
        self.encode_in(depth, out);
    }

    /// 1 - E\[e^(c z)\] e^(-c z_f), clamped to 0.
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
