//! The scene from its camera: surfaces per pixel, and a plain shading that shadow techniques plug into.

pub(crate) mod raster;

pub use raster::CameraView;

use image::{Rgba, RgbaImage};
use rayon::prelude::*;
use scenes::vector::{dot, minus, normalize};
use scenes::{AreaLight, Camera, LightView, Scene};

use crate::{LightFrame, RenderError, ShadowMapStack};

/// Marks a pixel without surface in [`Frame::triangle`].
pub const NO_TRIANGLE: u32 = u32::MAX;

/// What the camera sees, row-major from the top left pixel; values of pixels without surface are zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Index of the scene's triangle, [`NO_TRIANGLE`] where there is none.
    pub triangle: Vec<u32>,
    /// World-space position.
    pub position: Vec<[f32; 3]>,
    /// Unit normal in world space, turned towards the camera.
    pub normal: Vec<[f32; 3]>,
    /// Linear RGB albedo.
    pub albedo: Vec<[f32; 3]>,
}

/// Share of the light that reaches a horizontal surface in shadow.
const AMBIENT: f32 = 0.25;
/// Ambient light by the surface's normal, 1 upwards: most of it without regard to the normal, and slightly more from one
/// side than from the other, so that shapes and edges stay visible in shadow.
const AMBIENT_BY_NORMAL: [f32; 3] = [-0.12, 0.35, 0.06];
/// Albedo of surfaces in pictures without colours.
const PLAIN_ALBEDO: f32 = 0.6;
/// Linear RGB of pixels without surface.
const SKY: [f32; 3] = [0.35, 0.5, 0.75];

impl Frame {
    /// Renders the scene from its camera on the CPU, at the nearest surface of each pixel's centre; alpha masks
    /// apply, both sides of triangles are visible. Independent of the number of threads.
    ///
    /// # Errors
    /// [`RenderError::MapSize`] for a size outside of 1..=[`crate::MAX_MAP_SIZE`], [`RenderError::Camera`] for a
    /// camera that cannot see, [`RenderError::Scene`] as for stacks.
    pub fn render(scene: &Scene, width: u32, height: u32) -> Result<Self, RenderError> {
        Self::render_from(scene, &scene.camera, [width, height])
    }

    /// The same from another camera.
    ///
    /// # Errors
    /// As [`Frame::render`].
    pub fn render_from(scene: &Scene, camera: &Camera, size: [u32; 2]) -> Result<Self, RenderError> {
        raster::render(scene, camera, size)
    }

    /// Gives all surfaces one grey, so that nothing but light and shadow is seen.
    pub fn paint_plain(&mut self) {
        self.albedo.fill([PLAIN_ALBEDO; 3]);
    }

    /// True where a pixel shows a surface.
    pub fn covered(&self) -> impl ExactSizeIterator<Item = bool> + '_ {
        self.triangle.iter().map(|&t| t != NO_TRIANGLE)
    }

    /// Visibility of the light by a plain test against layer 0 of `stack`: 1 lit, 0 in shadow or behind a local light, 1
    /// without surface or outside of the map.
    ///
    /// The stored surface is extended over its texel by its gradient, the visible one by that of its normal, both clamped to
    /// 0.02 in depth, plus a bias of 2e-4: the picture is for orientation, not for measurements.
    pub fn hard_shadow(&self, stack: &ShadowMapStack, frame: &LightFrame) -> Vec<f32> {
        let lit = |((position, normal), triangle): ((&[f32; 3], &[f32; 3]), &u32)| {
            let seen = frame.light_space(position.map(f64::from));
            let [x, y, depth] = frame.on_map(seen);
            if *triangle != NO_TRIANGLE && frame.eye.is_some() && seen[2] <= 0.0 {
                return 0.0;
            }
            let inside = x >= 0.0 && y >= 0.0 && x < f64::from(stack.width) && y < f64::from(stack.height);
            if *triangle == NO_TRIANGLE || !inside {
                return 1.0;
            }
            let Some(first) = stack.layers(x as u32, y as u32).next() else { return 1.0 };
            let stored = f64::from(0.5 * (first.gradient[0].abs() + first.gradient[1].abs()));
            // Where a curved surface turns away from the light its next facet may be stored, which is less steep.
            let slope = stored.max(frame.texel_slope(seen, normal.map(f64::from)));
            f32::from(depth <= f64::from(first.depth) + slope.min(0.02) + 2e-4)
        };
        self.position.par_iter().zip(&self.normal).zip(&self.triangle).map(lit).collect()
    }

    /// A picture in sRGB: albedo times ambient light, most from above, plus diffuse light from the middle of a light, scaled
    /// by `visibility` (1 lit, 0 in shadow; one value a pixel). Pixels without surface show a plain sky, opaque.
    ///
    /// # Panics
    /// If `visibility` has another number of values than the frame has pixels.
    pub fn shade(&self, light: &LightView, visibility: &[f32]) -> RgbaImage {
        self.shade_behind(light, visibility, |_, linear| linear)
    }

    /// The same behind what lets light through: `veil` is given the number of a pixel and the linear colour behind, and tells
    /// what is seen.
    ///
    /// # Panics
    /// As [`Frame::shade`].
    pub fn shade_behind(
        &self,
        light: &LightView,
        visibility: &[f32],
        veil: impl Fn(usize, [f32; 3]) -> [f32; 3],
    ) -> RgbaImage {
        assert_eq!(visibility.len(), self.triangle.len(), "one visibility a pixel");
        let distant = normalize(light.direction.map(|c| -f64::from(c)));
        RgbaImage::from_fn(self.width, self.height, |x, y| {
            let i = y as usize * self.width as usize + x as usize;
            if self.triangle[i] == NO_TRIANGLE {
                return encode(veil(i, SKY));
            }
            let normal = self.normal[i];
            let towards_light = match light.light {
                AreaLight::Sun { .. } => distant,
                AreaLight::Local { centre, .. } => normalize(minus(centre, self.position[i].map(f64::from))),
            };
            let cosine = dot(normal.map(f64::from), towards_light).max(0.0) as f32;
            let ambient =
                1.0 - AMBIENT_BY_NORMAL[1] + (0..3).map(|k| normal[k] * AMBIENT_BY_NORMAL[k]).sum::<f32>();
            let light = AMBIENT * ambient + (1.0 - AMBIENT) * cosine * visibility[i];
            encode(veil(i, self.albedo[i].map(|c| c * light)))
        })
    }
}

/// The rays through the pixels of a picture.
pub struct ViewRays(CameraView);

impl ViewRays {
    /// Of a camera and a size in pixels.
    ///
    /// # Errors
    /// [`RenderError::Camera`] for a camera that cannot see.
    pub fn new(camera: &Camera, [width, height]: [u32; 2]) -> Result<Self, RenderError> {
        Ok(Self(CameraView::new(camera, width, height)?))
    }

    /// The world direction through a point in pixels from the top left corner, of length 1 along the view; the first pixel's
    /// centre is (0.5, 0.5).
    pub fn through(&self, at: [f64; 2]) -> [f64; 3] {
        self.0.direction(at)
    }
}

/// Opaque sRGB from linear RGB.
fn encode(linear: [f32; 3]) -> Rgba<u8> {
    let [r, g, b] = linear.map(|c| {
        let c = c.clamp(0.0, 1.0);
        let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (255.0 * encoded + 0.5) as u8
    });
    Rgba([r, g, b, 255])
}
