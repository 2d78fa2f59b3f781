//! Soft shadows over time: one shadow map a frame from another point of the light (Scherzer et al., *Real-Time Soft
//! Shadows Using Temporal Coherence*, 2009).

mod buffer;
mod estimate;
mod frame;
mod method;
mod sampled_field;
mod shaders;
mod traced_map;

pub use buffer::{FrameSample, History, Restart};
pub use estimate::{ShadowEstimate, penumbra_width};
pub use frame::{FramePixel, Screen, Shaded, ShadowBuffer, Start};
pub use method::{FilterSource, MethodError, MovingCasters, TemporalMethod};
pub use sampled_field::SampledField;
pub use shaders::{
    buffer_words, pixel_for_shader, screen_uniform, smooth_shader, start_for_shader, update_shader,
};
pub use traced_map::{MapTexel, TracedMap};
