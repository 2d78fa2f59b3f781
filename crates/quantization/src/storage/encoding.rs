//! How a moment vector is stored: a transform and a number format.

use super::format::NumberFormat;
use super::transform::AffineTransform;
use crate::error::QuantizationError;

/// Transform, then format (MSM15 section 4.3).
#[derive(Clone, Debug, PartialEq)]
pub struct Encoding {
    transform: AffineTransform,
    format: NumberFormat,
}

impl Encoding {
    /// Combines the two.
    pub fn new(transform: AffineTransform, format: NumberFormat) -> Self {
        Self { transform, format }
    }

    /// The transform.
    pub fn transform(&self) -> &AffineTransform {
        &self.transform
    }

    /// The format.
    pub fn format(&self) -> NumberFormat {
        self.format
    }

    /// The stored bits of a moment vector.
    ///
    /// # Errors
    /// [`QuantizationError::Length`] for a vector of another order.
    pub fn encode(&self, b: &[f64]) -> Result<Vec<u32>, QuantizationError> {
        let mut values = vec![0.0; self.transform.order()];
        self.check(b.len())?;
        self.transform.apply(b, &mut values);
        Ok(values.into_iter().map(|value| self.format.encode(value)).collect())
    }

    /// The moment vector of stored bits.
    ///
    /// # Errors
    /// As [`Encoding::encode`].
    pub fn decode(&self, codes: &[u32]) -> Result<Vec<f64>, QuantizationError> {
        self.check(codes.len())?;
        let values: Vec<f64> = codes.iter().map(|&code| self.format.decode(code)).collect();
        let mut b = vec![0.0; values.len()];
        self.transform.invert(&values, &mut b);
        Ok(b)
    }

    fn check(&self, got: usize) -> Result<(), QuantizationError> {
        let expected = self.transform.order();
        if got == expected {
            return Ok(());
        }
        Err(QuantizationError::Length { what: "moment vector", expected, got })
    }
}
