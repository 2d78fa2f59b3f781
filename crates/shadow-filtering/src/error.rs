//! What can be wrong with a filter, a map or a technique's parameters.

use moment_problem::{BasisError, MomentError};
use quantization::QuantizationError;
use thiserror::Error;

/// Why something could not be filtered or shaded.
#[derive(Debug, Error)]
pub enum FilteringError {
    /// A parameter makes no sense.
    #[error("{key} = {value}: {reason}")]
    Parameter {
        /// Name of the parameter.
        key: &'static str,
        /// Its value.
        value: String,
        /// What it should be.
        reason: String,
    },
    /// A map has the wrong number of values.
    #[error("a map of {width}x{height} texels and {channels} channels has {got} values")]
    Length {
        /// Width in texels.
        width: usize,
        /// Height in texels.
        height: usize,
        /// Values a texel.
        channels: usize,
        /// Values found.
        got: usize,
    },
    /// A map holds NaN or, where finite numbers are needed, infinity.
    #[error("texel ({x}, {y}), channel {channel} holds {value}: a filter would smear it over its neighbours")]
    NotFinite {
        /// Column of the texel.
        x: usize,
        /// Row of the texel.
        y: usize,
        /// Channel.
        channel: usize,
        /// The value.
        value: f64,
    },
    /// The basis of a technique is at fault.
    #[error(transparent)]
    Basis(#[from] BasisError),
    /// The storage of moments is at fault.
    #[error(transparent)]
    Quantization(#[from] QuantizationError),
    /// The bound could not be computed.
    #[error(transparent)]
    Moments(#[from] MomentError),
}

impl FilteringError {
    pub(crate) fn parameter(
        key: &'static str,
        value: impl std::fmt::Display,
        reason: impl Into<String>,
    ) -> Self {
        Self::Parameter { key, value: value.to_string(), reason: reason.into() }
    }
}
