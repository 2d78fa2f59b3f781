//! What is rendered: triangles with materials, alpha masks, light views and a camera, made by a procedure or read from
//! glTF and OBJ files. Nothing here renders.

mod area_light;
mod arrays;
mod check;
mod colour;
mod error;
mod fit;
mod interior;
mod load;
mod motion;
mod path;
pub mod procedural;
mod scene;
pub mod vector;
mod views;

pub use area_light::{AreaLight, LightError, Outline, SUN_DEGREES};
pub use colour::{MipLevel, Texture, Wrap};
pub use error::{FileFault, InvalidScene, SceneError};
pub use load::{
    LoadOptions, PoseChoice, Warning, WarningKind, load_gltf_bytes, load_obj_bytes, load_scene,
    load_with_files,
};
pub use motion::{MovingScene, Pose};
pub use path::{CameraPath, Movement};
pub use procedural::procedural;
pub use scene::{AlphaMask, AlphaTexture, Camera, LightView, Material, NamedCamera, Opacity, Scene, Vertex};
pub use views::{ViewError, find_view, lit_by, read_views};
