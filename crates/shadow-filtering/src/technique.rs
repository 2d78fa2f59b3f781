//! The interface of all filterable shadow maps (MSM15 section 3).

use crate::error::FilteringError;
use crate::real_time::RealTime;
use moment_problem::arithmetic::Real;
use serde::{Deserialize, Serialize};

/// A filterable shadow map: b(z) is stored a texel, filtered linearly, and G(b, z_f) shades.
///
/// Computation is in `f64`; what a shader computes is [`RealTime`], what a texture stores
/// [`StoredTechnique`](crate::StoredTechnique).
pub trait Technique: Send + Sync {
    /// The technique with its parameters.
    fn name(&self) -> String;

    /// Number m of stored values.
    fn channels(&self) -> usize;

    /// Memory at the technique's storage format.
    fn bits_per_texel(&self) -> usize {
        self.channels() * StorageFormat::F32.bits()
    }

    /// b(z) for a depth in \[0, 1\]; depths outside are clamped. `out` has [`Technique::channels`] values.
    fn encode(&self, depth: f64, out: &mut [f64]);

    /// G(b, z_f) in \[0, 1\]: the approximate share of the kernel in front of z_f. z_f is clamped to \[0, 1\].
    ///
    /// # Errors
    /// Only techniques that solve a linear program fail; closed forms always have an answer.
    fn shade(&self, filtered: &[f64], z_f: f64) -> Result<f64, FilteringError>;

    /// Whether G <= F_Z(z_f) is a theorem about this technique.
    fn is_lower_bound(&self) -> bool;

    /// The technique as a shader computes it; `None` where a linear program is solved.
    fn real_time(&self) -> Option<&dyn RealTime> {
        None
    }
}

/// How channels are stored; exponential warps must not overflow it.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum StorageFormat {
    /// Half floats.
    F16,
    /// Single floats.
    #[default]
    F32,
}

impl StorageFormat {
    /// Bits of one value.
    pub fn bits(self) -> usize {
        match self {
            Self::F16 => 16,
            Self::F32 => 32,
        }
    }

    /// Name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::F16 => "f16",
            Self::F32 => "f32",
        }
    }

    /// Largest exponent c such that e^(c z) on \[0, 1\] is stored without overflow, rounded down to what is in use.
    pub fn largest_exponent(self) -> f64 {
        match self {
            Self::F16 => 11.08,
            Self::F32 => 88.0,
        }
    }

    /// The same where the square is stored too. Single floats keep a margin for sums of many texels.
    pub fn largest_exponent_with_square(self) -> f64 {
        match self {
            Self::F16 => 5.54,
            Self::F32 => 42.0,
        }
    }
}

/// Rejects exponents that are not positive or overflow the format.
pub(crate) fn check_exponent(
    key: &'static str,
    exponent: f64,
    format: StorageFormat,
    limit: f64,
) -> Result<(), FilteringError> {
    if !(exponent.is_finite() && exponent > 0.0) {
        return Err(FilteringError::parameter(key, exponent, "must be positive and finite"));
    }
    if exponent > limit {
        let reason = format!("overflows {}, which holds exponents up to {limit} here", format.name());
        return Err(FilteringError::parameter(key, exponent, reason));
    }
    Ok(())
}

/// Depth clamped to \[0, 1\]; NaN becomes 1, the far plane.
pub(crate) fn unit<R: Real>(depth: R) -> R {
    let (zero, one) = (R::zero(), R::one());
    if depth < zero {
        zero
    } else if depth < one {
        depth
    } else {
        one
    }
}
