//! Scenes to shadow-map stacks and frames, on the CPU and through wgpu, bit for bit the same.

mod error;
mod frame;
mod gpu;
mod light_frame;
mod stack;

pub use error::RenderError;
pub use frame::{Frame, NO_TRIANGLE};
pub use gpu::{
    DepthMap, FrameRenderer, FrameSettings, FrameShaders, GpuFrame, PassTimes, SUPERSAMPLE_8, Sampling,
    TexelFormat, WHOLE_FRAME,
};
pub use light_frame::{FIT_MARGIN, LightFrame, MAX_MAP_SIZE};
pub use stack::pictures;
pub use stack::prepare::{PreparedTriangles, SUBTEXELS};
pub use stack::render::{
    BINDING_BYTES, Backend, RenderReport, StageTimes, render_in_chunks, render_in_frame, render_stack,
};
pub use stack::{FacingBits, Fragment, LayerStatistics, ShadowMapStack};
