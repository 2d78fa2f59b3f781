//! Experiments of kind `single-scattering`: how far prefiltered single scattering and ray marching are from the light that a
//! medium scatters towards a camera (BHS16 section 2).
//!
//! View rays are pixels of a camera; what is asked of each is the lit share of the light that it could scatter. The truth is
//! that of the shadow map, walked texel by texel; beside it stands that of the geometry, by shadow rays.

mod aliasing;
mod cost;
mod edges;
mod method;
mod passes;
mod picture;
mod rays;
mod records;
mod run;
mod settings;
mod shot;
pub(crate) mod stability;
mod standpoint;
mod statistics;
mod timing;
mod view;

pub(crate) use rays::{RayMethod, Rays};

pub use method::ScatteringMethod;
pub use records::{
    AliasingRecord, EdgeRecord, ScatteringCost, ScatteringPictureRecord, ScatteringRecord,
    ScatteringViewRecord, StoredBiasRecord,
};
pub use settings::{
    AliasingSetting, MediumSetting, ScatteringPasses, ScatteringPicture, ScatteringStability,
    ScatteringTechnique, ScatteringTiming, SingleScatteringExperiment,
};
pub use standpoint::{Standpoint, StandpointSetting};
