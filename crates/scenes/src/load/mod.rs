//! From a name or a file to a [`Scene`].

pub(crate) mod alpha;
mod cut;
mod gltf;
mod lights;
mod obj;
pub(crate) mod source;
mod text;
mod texture;
mod warnings;

use std::path::{Path, PathBuf};

use crate::arrays::SceneArrays;
use crate::error::{FileFault, SceneError};
use crate::fit::{Bounds, add_ground, fit_camera, has_ground, scene_of};
use crate::interior::camera_inside;
use crate::vector::normalize;
use crate::{Camera, LightView, Material, NamedCamera, Scene, procedural};
use source::{Folder, read_limited};
use warnings::Warnings;
pub use warnings::{Warning, WarningKind};

/// Largest accepted scene file, and largest sum of all files that a scene names, in bytes.
pub(super) const MAX_FILE_BYTES: u64 = 1 << 30;

/// Direction of the light view `default` of a scene that comes from a file.
pub(crate) const DEFAULT_LIGHT: [f32; 3] = [0.8, -0.6, 0.35];

/// How a file is loaded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// The pose of what moves.
    pub pose: PoseChoice,
    /// Whether a warning is an error.
    pub strict: bool,
}

/// Which moment of which animation is shown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseChoice {
    /// Name or number of an animation, or `none`. Without this a file's only animation is shown; of several none is, as they
    /// are clips to choose from, unless there is a time, which is that of the first.
    pub animation: Option<String>,
    /// Seconds, clamped to the keys of each channel; 0 without this.
    pub time: Option<f64>,
}

/// Loads a procedural scene by name (`stairs`, `village`, `grove`, `hall`, with [`procedural::DEFAULT_SEED`]) or a
/// `.glb`, `.gltf` or `.obj` file by path (extension in any case), as the default [`LoadOptions`] say.
///
/// The first view, `default`, lights a file along (0.8, -0.6, 0.35); the file's own lights follow by name. If it has no ground,
/// one is added (material `ground_added`); if it has no perspective camera, one is fitted. What moves is shown at the first
/// frame of the file's animation, see [`PoseChoice`]. Files that a scene names must lie in its own folder.
///
/// What changes shadows is strict: positions, indices, transforms, alpha. What does not is lenient, and told by
/// [`Scene::warnings`].
///
/// Errors: see [`SceneError`]; a file that breaks its format, or needs an unsupported extension, never panics
/// and allocates in proportion to its size (scenes are limited to 2^24 triangles).
pub fn load_scene(spec: &str) -> Result<Scene, SceneError> {
    load_with_files(spec, &LoadOptions::default()).map(|(scene, _)| scene)
}

/// As [`load_scene`] with options, and the files that the scene was read from: itself, then buffers, images and material
/// libraries that it names, in their order. Procedural scenes have none.
pub fn load_with_files(spec: &str, options: &LoadOptions) -> Result<(Scene, Vec<PathBuf>), SceneError> {
    if let Some(scene) = procedural(spec, procedural::DEFAULT_SEED) {
        return Ok((scene, Vec::new()));
    }
    let path = Path::new(spec);
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_lowercase);
    let format = match extension.as_deref() {
        Some("glb" | "gltf") => Format::Gltf,
        Some("obj") => Format::Obj,
        _ => return Err(SceneError::UnknownScene { spec: spec.into() }),
    };
    let name = path.file_stem().map_or_else(|| spec.into(), |stem| stem.to_string_lossy().into_owned());
    let mut folder = Folder::of(path);
    let scene = read_limited(path, MAX_FILE_BYTES)
        .and_then(|bytes| load(format, name, &bytes, &mut folder, options))
        .map_err(|fault| fault.in_file(spec))?;
    Ok((scene, std::iter::once(path.to_owned()).chain(folder.into_read()).collect()))
}

/// Loads a binary or textual glTF from memory; `name` is used in messages and as the scene's name.
///
/// As [`load_scene`], except that external files cannot be read.
pub fn load_gltf_bytes(name: &str, bytes: &[u8]) -> Result<Scene, SceneError> {
    load(Format::Gltf, name.into(), bytes, &mut Folder::none(), &LoadOptions::default())
        .map_err(|fault| fault.in_file(name))
}

/// Loads a Wavefront OBJ from memory; `name` is used in messages and as the scene's name.
///
/// As [`load_scene`], except that external files cannot be read.
pub fn load_obj_bytes(name: &str, bytes: &[u8]) -> Result<Scene, SceneError> {
    load(Format::Obj, name.into(), bytes, &mut Folder::none(), &LoadOptions::default())
        .map_err(|fault| fault.in_file(name))
}

#[derive(Clone, Copy)]
enum Format {
    Gltf,
    Obj,
}

fn load(
    format: Format,
    name: String,
    bytes: &[u8],
    folder: &mut Folder,
    options: &LoadOptions,
) -> Result<Scene, FileFault> {
    let mut warnings = Warnings::default();
    if let (Format::Obj, Some(wanted)) =
        (format, options.pose.animation.as_deref().filter(|name| *name != "none"))
    {
        return Err(FileFault::invalid("animations", format!("an OBJ file has none, and no `{wanted}`")));
    }
    let loaded = match format {
        Format::Gltf => gltf::load(bytes, folder, &options.pose, &mut warnings)?,
        Format::Obj => obj::load(bytes, folder, &mut warnings)?,
    };
    let scene = loaded.finish(name, warnings)?;
    match scene.warnings.first().filter(|_| options.strict) {
        Some(first) => Err(FileFault::Strict { first: first.to_string(), count: scene.warnings.len() }),
        None => Ok(scene),
    }
}

/// Largest coordinate over largest extent of a scene whose positions may be rounded to single precision as they are: the
/// rounding, 2^-25 of a coordinate, is below half a millionth of the extent.
const FAR: f64 = 16.0;

/// Triangles around the origin, and again around a nearer one where that is far away from all of them; with the origin.
fn recentred(
    warnings: &mut Warnings,
    mut build: impl FnMut([f64; 3], &mut Warnings) -> Result<SceneArrays, FileFault>,
) -> Result<(SceneArrays, [f64; 3]), FileFault> {
    let arrays = build([0.0; 3], warnings)?;
    let Some([low, high]) = arrays.extent() else { return Ok((arrays, [0.0; 3])) };
    let extent = (0..3).fold(0.0_f64, |most, k| most.max(high[k] - low[k]));
    let largest = (0..3).fold(0.0_f64, |most, k| most.max(low[k].abs()).max(high[k].abs()));
    if largest <= FAR * extent {
        return Ok((arrays, [0.0; 3]));
    }
    drop(arrays);
    // Few digits, so that the place can be written down: multiples of the power of two at or below the extent.
    let step = f64::from_bits(extent.to_bits() & (0x7ff << 52));
    let rounded = |value: f64| if step > 0.0 { (value / step).round() * step } else { value };
    let origin = [0, 1, 2].map(|k| rounded(0.5 * (low[k] + high[k])));
    // All has been said the first time.
    Ok((build(origin, &mut Warnings::default())?, origin))
}

/// A camera as the file has it.
struct FileCamera {
    name: String,
    eye: [f64; 3],
    forward: [f64; 3],
    up: [f64; 3],
    vertical_fov: f64,
}

/// A light as the file has it.
struct FileLight {
    name: String,
    /// `directional`, `spot` or `point`.
    kind: String,
    position: [f64; 3],
    direction: [f64; 3],
}

/// What a file holds, before the scene gets what it lacks.
struct Loaded {
    arrays: SceneArrays,
    materials: Vec<Material>,
    cameras: Vec<FileCamera>,
    lights: Vec<FileLight>,
    /// What positions are relative to.
    origin: [f64; 3],
    /// What the file shows beside triangles.
    holds: Vec<&'static str>,
    /// Names of animations, and which of them is shown.
    animations: (Vec<String>, Option<usize>),
}

impl Loaded {
    fn finish(mut self, name: String, mut warnings: Warnings) -> Result<Scene, FileFault> {
        let Some(bounds) = Bounds::of(&self.arrays) else {
            let degenerate = self.arrays.degenerate_triangles;
            return Err(FileFault::Empty { degenerate, holds: self.holds.join(", ") });
        };
        let cameras: Vec<NamedCamera> =
            self.cameras.iter().filter_map(|camera| named_camera(camera, self.origin, &bounds)).collect();
        // Of what the file shows: added ground would push the camera away.
        let camera = match cameras.first() {
            Some(first) => first.camera,
            None => camera_inside(&self.arrays, &bounds).unwrap_or_else(|| fit_camera(&self.arrays, &bounds)),
        };
        if !has_ground(&self.arrays, &self.materials, &bounds) {
            add_ground(&mut self.arrays, &mut self.materials, &bounds);
        }
        let mut views = vec![LightView::directional("default", DEFAULT_LIGHT)];
        lights::add_views(&mut views, &self.lights, self.origin, &bounds, &mut warnings);
        let mut scene = scene_of(self.arrays, name, self.materials, views, camera);
        scene.cameras = cameras;
        scene.origin = self.origin;
        scene.warnings = warnings.into_list();
        scene.bounds = bounds.as_array();
        let (animations, shown) = self.animations;
        scene.animation = shown.and_then(|shown| animations.get(shown).cloned());
        scene.animations = animations;
        Ok(scene)
    }
}

/// In the scene's coordinates; `None` where single precision has none for it.
fn named_camera(camera: &FileCamera, origin: [f64; 3], bounds: &Bounds) -> Option<NamedCamera> {
    let eye = [0, 1, 2].map(|k| camera.eye[k] - origin[k]);
    let forward = normalize(camera.forward);
    // Far enough for single precision to tell eye and target apart.
    let distance = eye.iter().fold(bounds.radius(), |most, c| most.max(c.abs()));
    let target = [0, 1, 2].map(|k| (eye[k] + distance * forward[k]) as f32);
    let up = normalize(camera.up).map(|c| c as f32);
    let eye = eye.map(|c| c as f32);
    let usable = eye.iter().chain(&target).chain(&up).all(|c| c.is_finite()) && eye != target;
    let (name, vertical_fov) = (camera.name.clone(), camera.vertical_fov as f32);
    usable.then_some(NamedCamera { name, camera: Camera { eye, target, up, vertical_fov } })
}
