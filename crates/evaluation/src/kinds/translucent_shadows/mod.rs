//! Experiments of kind `translucent-shadows`: shadows of surfaces that let light through (BHS16 section 4), from filterable maps
//! of transmittance and of absorption, and from what engines do without.
//!
//! The truth is the kernel's mean of 1 - prod (1 - alpha_j) over surfaces in front of the receiver's plane, tap by tap.

mod colour;
mod method;
mod picture;
mod records;
mod run;
mod settings;
mod stability;
mod timing;
mod view;

pub(crate) use run::Plan;
pub(crate) use view::View;

pub use method::{BlendOrder, TranslucentTechnique};
pub use records::{
    BlendingRecord, ColourRecord, TranslucentCost, TranslucentGroup, TranslucentPictureRecord,
    TranslucentRecord, TranslucentViewRecord,
};
pub use settings::{
    ColourSetting, TranslucentAdvice, TranslucentPicture, TranslucentShadowsExperiment, TranslucentStability,
};
