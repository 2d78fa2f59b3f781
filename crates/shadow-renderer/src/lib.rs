//! Scenes to shadow-map stacks and frames, on the CPU and through wgpu, bit for bit the same.

mod assemble;
mod build;
mod check_scene;
mod edges;
mod error;
mod fit;
mod fixed_point;
mod frame;
mod frame_raster;
mod glyphs;
mod gpu;
mod light_frame;
mod load;
mod memory;
pub mod pictures;
mod prepare;
pub mod procedural;
mod rasterize;
mod render;
mod render_error;
pub mod scene;
mod stack;
mod stack_file;
mod views;

pub use build::{MAX_COORDINATE, MAX_TRIANGLES};
pub use error::{FileFault, SceneError};
pub use fit::GROUND_ADDED;
pub use frame::{Frame, NO_TRIANGLE};
pub use gpu::{
    DepthMap, FrameRenderer, FrameSettings, FrameShaders, GpuFrame, PassTimes, SUPERSAMPLE_8, Sampling,
    TexelFormat, WHOLE_FRAME,
};
pub use light_frame::{FIT_MARGIN, LightFrame, MAX_MAP_SIZE};
pub use load::{DEFAULT_LIGHT, MAX_FILE_BYTES, load_gltf_bytes, load_obj_bytes, load_scene};
pub use prepare::{PreparedTriangles, SUBTEXELS};
pub use procedural::procedural;
pub use render::{
    AdapterName, BINDING_BYTES, Backend, RenderReport, StageTimes, gpu_adapter, render_in_chunks,
    render_in_frame, render_stack,
};
pub use render_error::RenderError;
pub use scene::{AlphaMask, Camera, LightView, Material, Scene, Vertex};
pub use stack::{FacingBits, Fragment, LayerStatistics, ShadowMapStack};
pub use views::read_views;
