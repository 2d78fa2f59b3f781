//! The GPU backend through wgpu: an A-buffer in compute shaders, fed with the same prepared triangles as the CPU.

mod abuffer;
mod device;
mod work_items;

pub(crate) use abuffer::{ChunkSizes, extract};
pub(crate) use device::gpu;
