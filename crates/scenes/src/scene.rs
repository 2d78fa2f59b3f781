//! What is rendered: triangles, materials with optional alpha masks, named light views and a camera.

use std::sync::Arc;

use crate::{AreaLight, Texture, Warning};

/// Largest magnitude of a world-space coordinate. Squares of differences stay finite in 32-bit floats.
pub(crate) const MAX_COORDINATE: f64 = 1e15;

/// One corner of a triangle, in world space (right-handed, y up).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// World-space position.
    pub position: [f32; 3],
    /// Unit normal in world space, or zero for that of the triangle; used for shading only, never for shadow tests.
    pub normal: [f32; 3],
    /// Texture coordinate of colour and alpha mask; (0, 0) is the first texel's outer corner. Masks repeat.
    pub uv: [f32; 2],
}

/// Coverage texture of a material whose opacity is tested: of glTF's `alphaMode` `MASK`, and of `BLEND`, whose surfaces cast
/// shadows where their opacity is at least one half.
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

fn fault_of_texels([width, height]: [u32; 2], values: usize) -> Option<String> {
    if !MASK_SIDES.contains(&width) || !MASK_SIDES.contains(&height) {
        let (least, most) = (MASK_SIDES.start(), MASK_SIDES.end());
        return Some(format!("has {width}x{height} texels, each side must lie in {least}..={most}"));
    }
    let wrong = values as u64 != u64::from(width) * u64::from(height);
    wrong.then(|| format!("has {values} values for {width}x{height} texels"))
}

impl AlphaMask {
    /// What is wrong with it: a size that is not supported, or another number of values.
    pub fn fault(&self) -> Option<String> {
        fault_of_texels([self.width, self.height], self.alpha.len())
    }

    /// Whether it has no surface anywhere.
    pub(crate) fn shows_nothing(&self) -> bool {
        self.alpha.iter().all(|&alpha| alpha < self.cutoff)
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

/// Opacity over a texture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlphaTexture {
    /// Width in texels, at least 1.
    pub width: u32,
    /// Height in texels, at least 1.
    pub height: u32,
    /// Row-major, 255 is opaque; repeating.
    pub alpha: Vec<u8>,
}

impl AlphaTexture {
    /// Alpha of a texel in \[0, 1\].
    ///
    /// # Panics
    /// If there is no such texel.
    pub fn value(&self, column: u32, row: u32) -> f64 {
        f64::from(self.alpha[row as usize * self.width as usize + column as usize]) / 255.0
    }

    /// What is wrong with it: a size that is not supported, or another number of values.
    pub fn fault(&self) -> Option<String> {
        fault_of_texels([self.width, self.height], self.alpha.len())
    }
}

/// How much light a surface takes where shadows are translucent: alpha, `factor` times the texture's times that of the vertices
/// in [`Scene::colors`], less what the covered part transmits. Shadows that know no translucency take [`Material::mask`] in its
/// place.
#[derive(Clone, Debug, PartialEq)]
pub struct Opacity {
    /// From 0, clear, to 1.
    pub factor: f32,
    /// The same everywhere without it. Its coordinates are those of the mask.
    pub texture: Option<Arc<AlphaTexture>>,
    /// Share of red, green and blue light that passes through the covered part (`KHR_materials_transmission`); 0 without.
    pub transmission: [f32; 3],
    /// Factor of the transmission over the surface, with the same coordinates.
    pub transmission_texture: Option<Arc<AlphaTexture>>,
    /// Whether [`Material::mask`] holds here too, as that of `alphaMode` `MASK` does.
    pub tested: bool,
}

impl Opacity {
    /// Alpha alone.
    pub fn blended(factor: f32, texture: Option<Arc<AlphaTexture>>) -> Self {
        Self { factor, texture, transmission: [0.0; 3], transmission_texture: None, tested: false }
    }

    /// Its textures.
    pub fn textures(&self) -> impl Iterator<Item = &AlphaTexture> {
        [&self.texture, &self.transmission_texture].into_iter().flatten().map(Arc::as_ref)
    }

    /// What it must not be: a number outside of \[0, 1\], or a broken texture.
    pub fn fault(&self) -> Option<String> {
        let [r, g, b] = self.transmission;
        let outside = [self.factor, r, g, b].into_iter().find(|value| !(0.0..=1.0).contains(value));
        let number = outside.map(|value| format!("is {value}, outside of [0, 1]"));
        number.or_else(|| self.textures().find_map(AlphaTexture::fault))
    }
}

/// Surface description; only what shadows and a plain picture need.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name, for messages.
    pub name: String,
    /// Linear RGB albedo, the mean where it varies.
    pub albedo: [f32; 3],
    /// Alpha test, where the material has one.
    pub mask: Option<Arc<AlphaMask>>,
    /// Linear RGB that the texture's and the vertices' colours are multiplied with.
    pub factor: [f32; 3],
    /// Colours.
    pub texture: Option<Texture>,
    /// Of a surface that lets light through.
    pub opacity: Option<Opacity>,
    /// Whether cameras do not see it from behind: ground that was added.
    pub one_sided: bool,
}

impl Material {
    /// Of one colour, opaque.
    pub fn plain(name: impl Into<String>, albedo: [f32; 3]) -> Self {
        Self {
            name: name.into(),
            albedo,
            mask: None,
            factor: albedo,
            texture: None,
            opacity: None,
            one_sided: false,
        }
    }
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

impl LightView {
    /// The same light where positions are relative to `origin`.
    #[must_use]
    pub fn relative_to(mut self, origin: [f64; 3]) -> Self {
        if let AreaLight::Local { centre, .. } = &mut self.light {
            *centre = [0, 1, 2].map(|k| centre[k] - origin[k]);
        }
        self
    }
}

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Eye position, world space.
    pub eye: [f32; 3],
    /// Point looked at, world space.
    pub target: [f32; 3],
    /// What is upwards in the picture, world space, any length. Where it is zero or along the view, the world's y axis is, or
    /// its negative z axis for a view along that.
    pub up: [f32; 3],
    /// Vertical field of view in radians.
    pub vertical_fov: f32,
}

impl Camera {
    /// Upright.
    pub const fn new(eye: [f32; 3], target: [f32; 3], vertical_fov: f32) -> Self {
        Self { eye, target, up: [0.0, 1.0, 0.0], vertical_fov }
    }
}

/// A camera of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedCamera {
    /// That of its node, else its own.
    pub name: String,
    /// The camera.
    pub camera: Camera,
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
    /// Linear RGB and alpha by vertex; white and opaque where there is none.
    pub colors: Vec<[f32; 4]>,
    /// Cameras of the file; the first is [`Scene::camera`].
    pub cameras: Vec<NamedCamera>,
    /// World position of this scene's origin. Not zero for a file far from it, whose positions single precision would round:
    /// all positions here, of lights and cameras too, are relative to it.
    pub origin: [f64; 3],
    /// Least and greatest coordinates of what the file shows, without added ground, relative to `origin`.
    pub bounds: [[f64; 3]; 2],
    /// Names of the file's animations, numbers where they have none.
    pub animations: Vec<String>,
    /// The one whose pose the scene has.
    pub animation: Option<String>,
    /// What the file asks for and does not get.
    pub warnings: Vec<Warning>,
}

impl Default for Scene {
    /// Nothing, seen from the side; for tests and for scenes put together piece by piece.
    fn default() -> Self {
        Self {
            name: String::new(),
            vertices: Vec::new(),
            triangles: Vec::new(),
            triangle_material: Vec::new(),
            materials: Vec::new(),
            views: Vec::new(),
            camera: Camera::new([1.0; 3], [0.0; 3], 1.0),
            degenerate_triangles: 0,
            colors: Vec::new(),
            cameras: Vec::new(),
            origin: [0.0; 3],
            bounds: [[0.0; 3]; 2],
            animations: Vec::new(),
            animation: None,
            warnings: Vec::new(),
        }
    }
}
