//! The GPU backend through wgpu: an A-buffer in compute shaders, fed with the same prepared triangles as the CPU.

mod abuffer;
mod cover_pass;
mod depth_map;
mod filter_chain;
mod frame_geometry;
mod frame_renderer;
mod work_items;

pub(crate) use abuffer::{ABuffer, ChunkSizes};
pub use depth_map::{DepthMap, SUPERSAMPLE_8, Sampling};
pub use frame_renderer::{
    FrameRenderer, FrameSettings, FrameShaders, GpuFrame, PassTimes, TexelFormat, WHOLE_FRAME,
};
