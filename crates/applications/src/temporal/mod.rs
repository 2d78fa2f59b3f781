//! Soft shadows over time: one shadow map a frame from another point of the light (Scherzer et al., *Real-Time Soft
//! Shadows Using Temporal Coherence*, 2009).

mod estimate;

pub use estimate::{ShadowEstimate, penumbra_width};
