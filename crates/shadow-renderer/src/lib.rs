//! Scenes to shadow-map stacks and frames, on the CPU and through wgpu, bit for bit the same.

mod clip;
mod error;
mod frame;
mod gpu;
mod light_frame;
mod render;
mod stack;

pub use error::RenderError;
pub use frame::{CameraView, Frame, NO_TRIANGLE, ViewRays};
pub use gpu::{
    BINDING_BYTES, ComputeChain, ComputePass, Content, DepthMap, DeviceLimits, FrameRenderer, FrameSettings,
    GpuFrame, PassTimes, Route, SUPERSAMPLE_8, Sampling, WHOLE_FRAME,
};
pub use light_frame::{FIT_MARGIN, LightFrame, LocalLightError, MAX_MAP_SIZE};
pub use render::{
    Backend, RenderReport, TranslucentStack, render_in_chunks, render_in_frame, render_stack,
    render_translucent, render_view,
};
pub use stack::file::write_array;
pub use stack::pictures;
pub use stack::stage_times::StageTimes;
pub use stack::veils::Spectrum;
pub use stack::{FacingBits, Fragment, LayerStatistics, ShadowMapStack};
