//! G: a filtered map shaded by its technique, or percentage-closer filtering as implementations have it.

use super::HardShadow;
use crate::application::Estimate;
use shadow_filtering::{ChannelMap, DepthMap, FilteringError, Kernel, Receiver, Technique, encode, filter};

/// A method for any view.
pub enum ShadowMethod {
    /// A filterable shadow map.
    Prefiltered(Box<Technique>),
    /// Percentage-closer filtering with a kernel of its own and without the receiver's plane.
    Comparison(Kernel),
}

/// A method prepared for one view.
pub enum PreparedShadow<'a> {
    /// With the filtered map, unrounded.
    Prefiltered(&'a Technique, ChannelMap<f64>),
    /// With the shadow map.
    Comparison(&'a Kernel, &'a DepthMap),
}

impl ShadowMethod {
    /// Encodes and filters a shadow map.
    ///
    /// # Errors
    /// [`FilteringError::NotFinite`] where a value has no number.
    pub fn prepare<'a>(
        &'a self,
        map: &'a DepthMap,
        kernel: &Kernel,
    ) -> Result<PreparedShadow<'a>, FilteringError> {
        Ok(match self {
            Self::Prefiltered(technique) => {
                PreparedShadow::Prefiltered(technique, filter(&encode(map, technique)?, kernel))
            }
            Self::Comparison(own) => PreparedShadow::Comparison(own, map),
        })
    }

    /// Whether the estimate is a lower bound of F_Z at the compared depth.
    pub fn is_bound(&self) -> bool {
        match self {
            Self::Prefiltered(technique) => technique.is_lower_bound(),
            Self::Comparison(_) => false,
        }
    }

    /// Memory of a texel in bits.
    pub fn bits_per_texel(&self) -> usize {
        match self {
            Self::Prefiltered(technique) => technique.bits_per_texel(),
            // A single-precision depth.
            Self::Comparison(_) => 32,
        }
    }
}

impl PreparedShadow<'_> {
    /// The shadow intensity at a texel, for a fragment at depth `z` in \[0, 1\].
    ///
    /// # Errors
    /// As [`Technique::shade`].
    pub fn shade(&self, x: usize, y: usize, z: f64) -> Result<f64, FilteringError> {
        match self {
            Self::Prefiltered(technique, filtered) => technique.shade(filtered.texel(x, y), z),
            Self::Comparison(kernel, map) => Ok(kernel.percentage_closer(map, x, y, z)),
        }
    }
}

impl Estimate<HardShadow<'_>> for PreparedShadow<'_> {
    fn estimate(&self, view: &HardShadow<'_>, receiver: &Receiver) -> Result<f64, FilteringError> {
        self.shade(receiver.x, receiver.y, view.compared(receiver))
    }
}
