//! Experiments of kind `stochastic-shadows`: soft shadows from one map whose rays start all over the light (SSSM15), with any
//! filterable representation, against the area light itself.
//!
//! The light is that of a view, scaled. Receivers are what the camera sees of surfaces that face the light's middle.

mod method;
mod modulation;
mod picture;
mod records;
mod run;
mod settings;
mod shading;
mod timing;

pub use method::{StochasticSetting, StochasticTechnique};
pub use records::{
    ModulationRecord, PlaneRecord, StochasticPictureRecord, StochasticRecord, StochasticViewRecord,
};
pub use settings::{ModulationSetting, StochasticPicture, StochasticShadowsExperiment};
pub(crate) use shading::{LitFrame, Named, Traced};
