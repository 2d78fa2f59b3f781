//! Scenes to shadow-map stacks and frames, on the CPU and through wgpu, bit for bit the same.

mod build;
mod error;
mod fit;
mod load;
pub mod procedural;
pub mod scene;
mod views;

pub use build::{MAX_COORDINATE, MAX_TRIANGLES};
pub use error::{FileFault, SceneError};
pub use fit::GROUND_ADDED;
pub use load::{DEFAULT_LIGHT, MAX_FILE_BYTES, load_gltf_bytes, load_obj_bytes, load_scene};
pub use procedural::procedural;
pub use scene::{AlphaMask, Camera, LightView, Material, Scene, Vertex};
pub use views::read_views;
