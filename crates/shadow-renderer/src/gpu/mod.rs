//! The GPU backend through wgpu: an A-buffer in compute shaders, fed with the same prepared triangles as the CPU, and whole
//! shadowed frames in the raster pipeline.

mod abuffer;
mod bind;
mod colour;
mod compute_chain;
mod compute_frame;
mod compute_shader;
mod depth_map;
mod filter_chain;
mod frame_renderer;
mod geometry;
mod limits;
mod raster_pass;
mod work_items;

pub(crate) use abuffer::{ABuffer, ChunkSizes};
pub use compute_chain::{ComputeChain, ComputePass, Content};
pub use depth_map::{DepthMap, SUPERSAMPLE_8, Sampling};
pub use frame_renderer::{FrameRenderer, FrameSettings, GpuFrame, PassTimes, Route, WHOLE_FRAME};
pub use limits::DeviceLimits;

/// Bytes of a storage binding that every graphics adapter offers.
pub const BINDING_BYTES: u64 = 128 << 20;

const FRAGMENTS: &str = include_str!("fragments.wgsl");
const SCAN: &str = include_str!("scan.wgsl");
const SORT: &str = include_str!("sort.wgsl");
const DEPTH_MAP: &str = concat!(include_str!("mask.wgsl"), include_str!("depth_map.wgsl"));
const READ_DEPTHS: &str = include_str!("read_depths.wgsl");
const SURFACES: &str =
    concat!(include_str!("mask.wgsl"), include_str!("colour.wgsl"), include_str!("surfaces.wgsl"));

#[cfg(test)]
mod tests {
    use super::*;
    use shaders::{Module, Stage};

    #[test]
    fn every_kernel_is_valid_wgsl() {
        for (source, name) in abuffer::KERNELS.into_iter().chain(depth_map::READERS.map(|n| (READ_DEPTHS, n)))
        {
            let module = Module::new(source).unwrap_or_else(|error| panic!("{name}: {error}"));
            let entry = module.entry_point(name).unwrap();
            assert!(entry.stage == Stage::Compute && !entry.bindings.is_empty(), "{name}");
        }
    }

    /// Attributes follow each other in memory as they do in the shader.
    #[test]
    fn every_raster_pass_is_valid_wgsl_with_the_corners_that_are_uploaded() {
        for (source, bytes) in [(DEPTH_MAP, geometry::CORNER_BYTES[0]), (SURFACES, geometry::CORNER_BYTES[1])]
        {
            let module = Module::new(source).unwrap();
            assert!(module.only(Stage::Fragment).is_ok());
            let (_, stride) = raster_pass::attributes(&module.only(Stage::Vertex).unwrap().inputs);
            assert_eq!(stride, bytes as u64);
        }
    }
}
