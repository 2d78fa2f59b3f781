//! Experiments of kind `soft-shadows`: how far percentage-closer, variance and moment soft shadows are from the area
//! light itself (BHS16 section 3), found by shadow rays.
//!
//! The light is as large for every view of a run as the file says; a map is seen from its middle. Receivers are the
//! fragments of the stack and what a camera sees.

mod method;
mod passes;
mod picture;
mod receiver;
mod records;
mod run;
mod settings;
mod statistics;
mod sweep;
mod timing;
mod view;

pub use method::{Corners, MethodSetting, Precision};
pub(crate) use method::{PUBLISHED_BIAS, Prepared};
pub use records::{
    PassSample, ReceiverRecord, ReconstructionPoint, SearchTexel, SoftPictureRecord, SoftRecord,
    SoftViewRecord, SweepRecord,
};
pub use settings::{LightSetting, PassTiming, SoftAdvice, SoftPicture, SoftShadowsExperiment, SoftTechnique};
pub use sweep::{Sweep, SweepValues};
pub use view::Population;
pub(crate) use view::surface;
