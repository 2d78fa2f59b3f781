//! What is rendered: triangles, materials with optional alpha masks, named light views and a camera.

use std::sync::Arc;

use crate::AreaLight;

/// Largest magnitude of a world-space coordinate. Squares of differences stay finite in 32-bit floats.
pub(crate) const MAX_COORDINATE: f64 = 1e15;

/// One corner of a triangle, in world space (right-handed, y up).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// World-space position.
    pub position: [f32; 3],
    /// Unit normal in world space; used for shading only, never for shadow tests.
    pub normal: [f32; 3],
    /// Texture coordinate for the alpha mask; (0, 0) is the first texel, wrapping by repetition.
    pub uv: [f32; 2],
}

/// Coverage texture of an alpha-tested material (glTF `alphaMode: MASK`).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlphaMask {
    /// Width in texels, at least 1.
    pub width: u32,
    /// Height in texels, at least 1.
    pub height: u32,
    /// Row-major alpha, 8 bits a texel.
    pub alpha: Vec<u8>,
    /// A fragment exists where the nearest texel's alpha is at least this value.
    pub cutoff: u8,
}

/// Sides of alpha masks, in texels, that the fixed point of shadow maps has bits for.
const MASK_SIDES: std::ops::RangeInclusive<u32> = 1..=65_535;

impl AlphaMask {
    /// What is wrong with it: a size that is not supported, or another number of values.
    pub fn fault(&self) -> Option<String> {
        let Self { width, height, ref alpha, .. } = *self;
        if !MASK_SIDES.contains(&width) || !MASK_SIDES.contains(&height) {
            let (least, most) = (MASK_SIDES.start(), MASK_SIDES.end());
            return Some(format!("has {width}x{height} texels, each side must lie in {least}..={most}"));
        }
        let wrong = alpha.len() as u64 != u64::from(width) * u64::from(height);
        wrong.then(|| format!("has {} values for {width}x{height} texels", alpha.len()))
    }

    /// Whether there is a surface at texture coordinates, which must be finite: the alpha test of the nearest texel,
    /// repeating.
    ///
    /// # Panics
    /// If the mask has fewer alpha values than texels.
    pub fn passes(&self, uv: [f64; 2]) -> bool {
        let texel =
            |t: f64, size: u32| ((t.rem_euclid(1.0) * f64::from(size)) as usize).min(size as usize - 1);
        let index = texel(uv[1], self.height) * self.width as usize + texel(uv[0], self.width);
        self.alpha[index] >= self.cutoff
    }
}

/// Surface description; only what shadows and a plain picture need.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name, for messages.
    pub name: String,
    /// Linear RGB albedo.
    pub albedo: [f32; 3],
    /// Alpha test, where the material has one.
    pub mask: Option<Arc<AlphaMask>>,
}

/// A light with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct LightView {
    /// Name, unique within the scene.
    pub name: String,
    /// Direction in which the light travels, world space, need not be normalised, never zero. That of a local light is
    /// the one in which it shines.
    pub direction: [f32; 3],
    /// Size and place; without extent for hard shadows.
    pub light: AreaLight,
}

impl LightView {
    /// A directional light without extent.
    pub fn directional(name: impl Into<String>, direction: [f32; 3]) -> Self {
        Self { name: name.into(), direction, light: AreaLight::DISTANT_POINT }
    }

    /// A light of some size. `direction` is for the sun; a local light shines along its own U x V.
    pub fn new(name: impl Into<String>, light: AreaLight, direction: [f32; 3]) -> Self {
        let direction = light.front().map_or(direction, |front| front.map(|c| c as f32));
        Self { name: name.into(), direction, light }
    }
}

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Eye position, world space.
    pub eye: [f32; 3],
    /// Point looked at, world space.
    pub target: [f32; 3],
    /// Vertical field of view in radians.
    pub vertical_fov: f32,
}

/// Triangles with materials, the light views to evaluate, and a camera that shows the scene.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name used in records and file names.
    pub name: String,
    /// All corners.
    pub vertices: Vec<Vertex>,
    /// Indices into `vertices`, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// One index into `materials` per triangle.
    pub triangle_material: Vec<u32>,
    /// At least one.
    pub materials: Vec<Material>,
    /// Light views; at least one.
    pub views: Vec<LightView>,
    /// Camera for pictures of the scene.
    pub camera: Camera,
    /// Triangles dropped on loading because they have no area.
    pub degenerate_triangles: usize,
}
