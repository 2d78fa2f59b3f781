//! Soft shadows over time: one shadow map a frame from another point of the light (Scherzer et al., *Real-Time Soft
//! Shadows Using Temporal Coherence*, 2009).

mod buffer;
mod estimate;

pub use buffer::{FrameSample, History, Restart};
pub use estimate::{ShadowEstimate, penumbra_width};
