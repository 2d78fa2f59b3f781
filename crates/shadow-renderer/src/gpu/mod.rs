//! The GPU backend through wgpu: an A-buffer in compute shaders, fed with the same prepared triangles as the CPU.

mod abuffer;
mod depth_map;
mod device;
mod frame_geometry;
mod frame_renderer;
mod work_items;

pub(crate) use abuffer::{ChunkSizes, extract};
pub use depth_map::{DepthMap, SUPERSAMPLE_8, Sampling};
pub(crate) use device::gpu;
pub use frame_renderer::{FrameRenderer, FrameSettings, FrameShaders, GpuFrame, PassTimes, TexelFormat};
