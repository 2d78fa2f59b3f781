//! The kind `speed-accuracy`: every technique in every format and map size, its error against its cost; how many moments
//! kernels need; and the cheapest technique that meets a tolerance on a scene.

mod advise;
mod candidate;
mod candidates;
mod cost;
mod frames;
mod orders;
mod picture;
mod race;
mod records;
mod run;
mod scenery;
mod settings;
mod timing;

pub(crate) use cost::{FETCH, FrameCost};

pub use advise::{Advice, AdviceOptions, Choice, Nothing};
pub use frames::COMPARED_FRAME;
pub use records::{FrameRoute, FrameSample, OrderShare, SpeedAccuracyRecord, SpeedSample};
pub use settings::{
    Blend, CandidateSetting, ComparisonSetting, EveryViewSetting, FrameSetting, FrameTiming, OrderSetting,
    PictureSetting, SpeedAccuracyExperiment, SpeedTiming,
};
