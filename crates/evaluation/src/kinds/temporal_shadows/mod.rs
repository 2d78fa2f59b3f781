//! Experiments of kind `temporal-shadows`: soft shadows gathered over frames (TC09) along paths of the camera, against the
//! area light itself.
//!
//! The light is that of a view, scaled; a frame's map is seen from the next point of Halton's sequence on it. Maps are traced
//! where they are read, which gives the depths of a map that is drawn whole.

mod animation;
mod counting;
mod judge;
mod method;
mod outcome;
mod picture;
mod records;
mod run;
mod settings;
mod timing;

pub use animation::TemporalAnimation;
pub use method::{GatherSetting, MethodChoice, TemporalTechnique};
pub use records::{CountRecord, TemporalPictureRecord, TemporalRecord, TemporalViewRecord};
pub use settings::{CountingSetting, PathSetting, TemporalPicture, TemporalShadowsExperiment};
