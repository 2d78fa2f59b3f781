//! Techniques as written in an experiment.

use crate::error::FilteringError;
use crate::technique::{StorageFormat, Technique};
use crate::techniques::{
    Certified, Convolution, Exponential, ExponentialVariance, LayeredVariance, MomentBound, Moments, Variance,
};
use serde::{Deserialize, Serialize};

/// Options of the closed-form moment techniques.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct MomentOptions {
    /// Moment bias (MSM15 section 4.2); without it the least that double precision needs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alpha: Option<f64>,
    /// 0 the lower bound, 1 the upper, between them BHS16's blend.
    #[serde(default)]
    pub beta: f64,
}

/// A filterable technique with its parameters, by its name in TOML (`kind = "..."`).
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum TechniqueSpec {
    /// Variance shadow map.
    Vsm {},
    /// Exponential shadow map.
    Esm {
        /// c per depth range.
        exponent: f64,
        /// Storage; limits the exponent.
        #[serde(default)]
        format: StorageFormat,
    },
    /// Exponential variance shadow map.
    Evsm {
        /// Exponent of the ascending warp, per half depth range.
        positive: f64,
        /// Exponent of the descending warp; without it there are two channels.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        negative: Option<f64>,
        /// Storage; limits the exponents.
        #[serde(default)]
        format: StorageFormat,
    },
    /// Layered variance shadow map.
    Lvsm {
        /// Layers of equal size.
        layers: usize,
    },
    /// Convolution shadow map.
    Csm {
        /// M, two channels each.
        coefficients: usize,
    },
    /// Variance shadow map with moment bias: Cantelli's inequality on biased moments of 2 z - 1.
    Hamburger2(MomentOptions),
    /// Hamburger 4MSM.
    Hamburger4(MomentOptions),
    /// Six power moments.
    Hamburger6(MomentOptions),
    /// Eight power moments.
    Hamburger8(MomentOptions),
    /// Hausdorff 4MSM.
    Hausdorff4(MomentOptions),
    /// TMSM.
    Trigonometric4(MomentOptions),
    /// Any basis through the certified linear program.
    Certified {
        /// The basis as on the command line.
        basis: String,
    },
}

impl TechniqueSpec {
    /// The technique.
    ///
    /// # Errors
    /// [`FilteringError`] naming the parameter and its value.
    pub fn build(&self) -> Result<Box<dyn Technique>, FilteringError> {
        Ok(match *self {
            Self::Vsm {} => Box::new(Variance),
            Self::Esm { exponent, format } => Box::new(Exponential::new(exponent, format)?),
            Self::Evsm { positive, negative, format } => {
                Box::new(ExponentialVariance::new(positive, negative, format)?)
            }
            Self::Lvsm { layers } => Box::new(LayeredVariance::new(layers)?),
            Self::Csm { coefficients } => Box::new(Convolution::new(coefficients)?),
            Self::Certified { ref basis } => Box::new(Certified::new(basis)?),
            Self::Hamburger2(options) => Box::new(Moments::new(MomentBound::Hamburger2, options)?),
            Self::Hamburger4(options) => Box::new(Moments::new(MomentBound::Hamburger4, options)?),
            Self::Hamburger6(options) => Box::new(Moments::new(MomentBound::Hamburger6, options)?),
            Self::Hamburger8(options) => Box::new(Moments::new(MomentBound::Hamburger8, options)?),
            Self::Hausdorff4(options) => Box::new(Moments::new(MomentBound::Hausdorff4, options)?),
            Self::Trigonometric4(options) => Box::new(Moments::new(MomentBound::Trigonometric4, options)?),
        })
    }
}
