//! The kind `speed-accuracy`: every technique in every format and map size, its error against its cost; how many moments
//! kernels need; and the cheapest technique that meets a tolerance on a scene.

mod candidate;
mod candidates;
mod cost;
mod frames;
mod measured;
mod orders;
mod picture;
mod records;
mod run;
mod scenery;
mod settings;
mod timing;

pub(crate) use candidate::moment_operations;
pub(crate) use cost::{FETCH, FrameCost};
pub(crate) use measured::MeasuredFrames;
pub(crate) use orders::needed;
pub(crate) use scenery::{FreeParameters, SceneView, SpeedPlan};

pub use frames::COMPARED_FRAME;
pub use records::{FrameRoute, FrameSample, OrderShare, SpeedAccuracyRecord, SpeedSample};
pub use settings::{
    Blend, CandidateSetting, ComparisonSetting, EveryViewSetting, FrameSetting, FrameTiming, OrderSetting,
    PictureSetting, SpeedAccuracyExperiment, SpeedTiming,
};
