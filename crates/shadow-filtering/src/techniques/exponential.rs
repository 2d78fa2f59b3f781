//! Exponential shadow maps: b(z) = e^(c z) and Markov's inequality (MSM15 section 2, after Salvi and Annen et al.).

use crate::error::FilteringError;
use crate::technique::{StorageFormat, Technique, check_exponent, unit};
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
}

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
        out[0] = (self.exponent * unit(depth)).exp();
    }

    /// 1 - E\[e^(c z)\] e^(-c z_f), clamped to 0.
    fn shade(&self, filtered: &[f64], z_f: f64) -> Result<f64, FilteringError> {
        Ok(markov_line(filtered[0] * (-self.exponent * unit(z_f)).exp()).lower)
    }

    fn is_lower_bound(&self) -> bool {
        true
    }
}
