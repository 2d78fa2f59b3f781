//! From a name or a file to a [`Scene`].

mod accessor;
mod document;
mod glb;
mod material;
mod node;
mod obj;
mod obj_text;
mod primitive;
pub(crate) mod source;
mod texture;

use std::path::{Path, PathBuf};

use crate::arrays::SceneArrays;
use crate::error::{FileFault, SceneError};
use crate::fit::{Bounds, add_ground, area_views, fit_camera, has_ground};
use crate::{Camera, LightView, Material, Scene, procedural};
use source::{Folder, read_limited};

/// Largest accepted scene file, and largest sum of all files that a scene names, in bytes.
pub(super) const MAX_FILE_BYTES: u64 = 1 << 30;

/// Direction of the one light view of a scene that comes from a file; the view is called `default`.
pub(crate) const DEFAULT_LIGHT: [f32; 3] = [0.8, -0.6, 0.35];

/// Loads a procedural scene by name (`stairs`, `village`, `grove`, with [`procedural::DEFAULT_SEED`]) or a
/// `.glb`, `.gltf` or `.obj` file by path (extension in any case).
///
/// A file is lit by one view, `default`, along (0.8, -0.6, 0.35). If it has no ground, one is added (material
/// `ground_added`); if it has no perspective camera, one is fitted. Morph targets and skins are not applied:
/// meshes appear in the shape they are stored in. Files that a scene names must lie in its own folder.
///
/// Errors: see [`SceneError`]; a file that breaks its format, or needs an unsupported extension, never panics
/// and allocates in proportion to its size (scenes are limited to 2^24 triangles).
pub fn load_scene(spec: &str) -> Result<Scene, SceneError> {
    load_with_files(spec).map(|(scene, _)| scene)
}

/// [`load_scene`], and the files that the scene was read from: itself, then buffers, images and material libraries that
/// it names, in their order. Procedural scenes have none.
pub fn load_with_files(spec: &str) -> Result<(Scene, Vec<PathBuf>), SceneError> {
    if let Some(scene) = procedural(spec, procedural::DEFAULT_SEED) {
        return Ok((scene, Vec::new()));
    }
    let path = Path::new(spec);
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_lowercase);
    let load: fn(&[u8], &mut Folder) -> Result<Loaded, FileFault> = match extension.as_deref() {
        Some("glb" | "gltf") => document::load,
        Some("obj") => obj::load,
        _ => return Err(SceneError::UnknownScene { spec: spec.into() }),
    };
    let name = path.file_stem().map_or_else(|| spec.into(), |stem| stem.to_string_lossy().into_owned());
    let mut folder = Folder::of(path);
    let scene = read_limited(path, MAX_FILE_BYTES)
        .and_then(|bytes| load(&bytes, &mut folder))
        .and_then(|loaded| loaded.finish(name))
        .map_err(|fault| fault.in_file(spec))?;
    Ok((scene, std::iter::once(path.to_owned()).chain(folder.into_read()).collect()))
}

/// Loads a binary or textual glTF from memory; `name` is used in messages and as the scene's name.
///
/// As [`load_scene`], except that any reference to an external file is an error.
pub fn load_gltf_bytes(name: &str, bytes: &[u8]) -> Result<Scene, SceneError> {
    document::load(bytes, &mut Folder::none())
        .and_then(|loaded| loaded.finish(name.into()))
        .map_err(|fault| fault.in_file(name))
}

/// Loads a Wavefront OBJ from memory; `name` is used in messages and as the scene's name.
///
/// As [`load_scene`], except that any reference to an external file is an error.
pub fn load_obj_bytes(name: &str, bytes: &[u8]) -> Result<Scene, SceneError> {
    obj::load(bytes, &mut Folder::none())
        .and_then(|loaded| loaded.finish(name.into()))
        .map_err(|fault| fault.in_file(name))
}

/// What a file holds, before the scene gets what it lacks.
struct Loaded {
    arrays: SceneArrays,
    materials: Vec<Material>,
    camera: Option<Camera>,
}

impl Loaded {
    fn finish(mut self, name: String) -> Result<Scene, FileFault> {
        let Some(bounds) = Bounds::of(&self.arrays) else {
            return Err(FileFault::Empty { degenerate: self.arrays.degenerate_triangles });
        };
        // Of what the file shows: added ground would push the camera away.
        let camera = self.camera.unwrap_or_else(|| fit_camera(&self.arrays, &bounds));
        if !has_ground(&self.arrays, &self.materials, &bounds) {
            add_ground(&mut self.arrays, &mut self.materials, &bounds);
        }
        let mut views = vec![LightView::directional("default", DEFAULT_LIGHT)];
        views.extend(Bounds::of(&self.arrays).iter().flat_map(area_views));
        Ok(Scene {
            name,
            vertices: self.arrays.vertices,
            triangles: self.arrays.triangles,
            triangle_material: self.arrays.triangle_material,
            materials: self.materials,
            views,
            camera,
            degenerate_triangles: self.arrays.degenerate_triangles,
        })
    }
}
