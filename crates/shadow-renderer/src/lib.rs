//! Scenes to shadow-map stacks and frames, on the CPU and through wgpu, bit for bit the same.

pub mod scene;

mod assemble;
mod edges;
mod fixed_point;
mod frame;
mod frame_raster;
mod glyphs;
mod gpu;
mod light_frame;
mod memory;
pub mod pictures;
mod prepare;
mod rasterize;
mod render;
mod render_error;
mod stack;
mod stack_file;

pub use frame::{Frame, NO_TRIANGLE};
pub use gpu::{DepthMap, SUPERSAMPLE_8, Sampling};
pub use light_frame::{FIT_MARGIN, LightFrame, MAX_MAP_SIZE};
pub use prepare::{PreparedTriangles, SUBTEXELS};
pub use render::{
    AdapterName, BINDING_BYTES, Backend, RenderReport, StageTimes, gpu_adapter, render_in_chunks,
    render_in_frame, render_stack,
};
pub use render_error::RenderError;
pub use scene::{AlphaMask, Camera, LightView, Material, Scene, Vertex};
pub use stack::{FacingBits, Fragment, LayerStatistics, ShadowMapStack};
