//! The CPU rasteriser behind [`Frame::render`]: coverage from the integer edges of the shadow maps, surfaces from
//! rays through the pixel centres.

use rayon::prelude::*;
use scenes::vector::{cross, dot, minus, normalize};
use scenes::{Camera, Scene, Texture};

use crate::clip::clip;
use crate::frame::NO_TRIANGLE;
use crate::light_frame::check_size;
use crate::stack::edges::for_each_span;
use crate::stack::fixed_point::Plane;
use crate::stack::prepare::{NO_MASK, PreparedTriangle, area_twice, clockwise, snap};
use crate::{Frame, RenderError};

/// Rows rasterised together.
const BAND_ROWS: u32 = 16;

/// A camera with its pixels, which are square.
#[derive(Clone, Copy, Debug)]
pub struct CameraView {
    eye: [f64; 3],
    right: [f64; 3],
    up: [f64; 3],
    forward: [f64; 3],
    /// Half the image plane's width and height at distance 1.
    half: [f64; 2],
    near: f64,
    size: [f64; 2],
}

impl CameraView {
    /// The camera for so many pixels.
    ///
    /// # Errors
    /// [`RenderError::Camera`] for a camera that cannot see.
    pub fn new(camera: &Camera, width: u32, height: u32) -> Result<Self, RenderError> {
        let (eye, target) = (camera.eye.map(f64::from), camera.target.map(f64::from));
        let fov = f64::from(camera.vertical_fov);
        if !eye.iter().chain(&target).all(|c| c.is_finite()) {
            return Err(RenderError::Camera("eye and target must be finite"));
        }
        if !(fov > 0.0 && fov < std::f64::consts::PI) {
            return Err(RenderError::Camera("the field of view must lie between 0 and pi radians"));
        }
        let direction = minus(target, eye);
        let distance = dot(direction, direction).sqrt();
        if distance == 0.0 {
            return Err(RenderError::Camera("eye and target must differ"));
        }
        /// Cosine from which two directions count as one: 2.6 degrees.
        const ALONG: f64 = 0.999;
        let forward = normalize(direction);
        let wanted = camera.up.map(f64::from);
        let wanted = if wanted == [0.0, 1.0, 0.0] { wanted } else { normalize(wanted) };
        let usable = wanted.iter().all(|c| c.is_finite()) && dot(forward, wanted).abs() <= ALONG;
        let upwards = match (usable, forward[1].abs() > ALONG) {
            (true, _) => wanted,
            (false, true) => [0.0, 0.0, -1.0],
            (false, false) => [0.0, 1.0, 0.0],
        };
        let right = normalize(cross(forward, upwards));
        let half = (0.5 * fov).tan();
        let size = [f64::from(width), f64::from(height)];
        Ok(Self {
            eye,
            right,
            up: cross(right, forward),
            forward,
            half: [half * size[0] / size[1], half],
            near: 1e-4 * distance,
            size,
        })
    }

    /// Where a world position is seen: column and row in pixels, pixel (i, j) covering \[i, i + 1) x \[j, j + 1), and its
    /// distance along the view, which is not positive behind the camera.
    pub fn project(&self, position: [f64; 3]) -> [f64; 3] {
        let [x, y, distance] = self.camera_space(position);
        let pixel = |c: f64, size: f64| 0.5 * (c / distance + 1.0) * size;
        [pixel(x, self.size[0]), pixel(y, self.size[1]), distance]
    }

    /// Pixels that a length across the view takes at distance 1, per unit.
    pub fn pixels_per_unit(&self) -> f64 {
        0.5 * self.size[1] / self.half[1]
    }

    /// Right, down and distance along the view; the visible cone has |right|, |down| <= distance.
    fn camera_space(&self, p: [f64; 3]) -> [f64; 3] {
        let d = minus(p, self.eye);
        [dot(d, self.right) / self.half[0], -dot(d, self.up) / self.half[1], dot(d, self.forward)]
    }

    /// Rows x, y, z, w of the clip coordinates of (p, 1), depth reversed from 1 at the near plane to 0 at infinity, and the eye.
    pub(crate) fn clip_rows(&self) -> [[f32; 4]; 5] {
        let row = |axis: [f64; 3], scale: f64| {
            let axis = axis.map(|c| c * scale);
            [axis[0], axis[1], axis[2], -dot(axis, self.eye)].map(|value| value as f32)
        };
        let eye = self.eye.map(|c| c as f32);
        [
            row(self.right, 1.0 / self.half[0]),
            row(self.up, 1.0 / self.half[1]),
            [0.0, 0.0, 0.0, self.near as f32],
            row(self.forward, 1.0),
            [eye[0], eye[1], eye[2], 0.0],
        ]
    }

    fn pixel(&self, c: [f64; 3]) -> [i32; 2] {
        [0, 1].map(|k| snap(0.5 * (c[k] / c[2] + 1.0) * self.size[k]))
    }

    /// World direction through a pixel's centre, of length 1 along the view.
    fn ray(&self, x: u32, y: u32) -> [f64; 3] {
        self.direction([x, y].map(|pixel| f64::from(pixel) + 0.5))
    }

    /// The same through any point in pixels.
    pub(crate) fn direction(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let across = (2.0 * x / self.size[0] - 1.0) * self.half[0];
        let down = (2.0 * y / self.size[1] - 1.0) * self.half[1];
        [0, 1, 2].map(|k| self.forward[k] + across * self.right[k] - down * self.up[k])
    }

    /// The part of a triangle in front of the near plane and within the visible cone, in camera space.
    fn clip(&self, triangle: [[f64; 3]; 3]) -> Vec<[f64; 3]> {
        let planes = [
            ([0.0, 0.0, 1.0], self.near),
            ([-1.0, 0.0, 1.0], 0.0),
            ([1.0, 0.0, 1.0], 0.0),
            ([0.0, -1.0, 1.0], 0.0),
            ([0.0, 1.0, 1.0], 0.0),
        ];
        clip(triangle.to_vec(), &planes)
    }
}

/// A piece of a clipped triangle on the pixel grid.
fn piece(corners: [[i32; 2]; 3], width: u32, height: u32) -> Option<PreparedTriangle> {
    let area = area_twice(corners);
    let [a, b, c] = corners;
    let mut bounds = [0; 4];
    for (k, size) in [width, height].into_iter().enumerate() {
        let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
        bounds[k] = low.div_euclid(256).clamp(0, size as i32) as u16;
        bounds[k + 2] = (high.div_euclid(256) + 1).clamp(0, size as i32) as u16;
    }
    (area != 0 && bounds[0] < bounds[2] && bounds[1] < bounds[3]).then_some(PreparedTriangle {
        corners: clockwise(corners, area),
        depth: Plane { base: 0, step: [0; 2] },
        depth_low: 0,
        depth_high: 0,
        bounds,
        mask: NO_MASK,
    })
}

/// Ray against the plane of a triangle, everything that does not depend on the ray computed beforehand.
struct Surface {
    normal: [f64; 3],
    along_u: [f64; 3],
    along_v: [f64; 3],
}

impl Surface {
    fn new(eye: [f64; 3], p: [[f64; 3]; 3]) -> Self {
        let (e1, e2, s) = (minus(p[1], p[0]), minus(p[2], p[0]), minus(eye, p[0]));
        Self { normal: cross(e2, e1), along_u: cross(e2, s), along_v: cross(s, e1) }
    }

    /// Weights of the corners where the ray meets the plane, which need not lie in the triangle; not finite for a ray along it.
    fn weights_on_plane(&self, ray: [f64; 3]) -> [f64; 3] {
        let across = dot(ray, self.normal);
        let (u, v) = (dot(ray, self.along_u) / across, dot(ray, self.along_v) / across);
        [1.0 - u - v, u, v]
    }

    /// Weights of the corners where the ray meets the plane, moved into the triangle.
    fn weights(&self, ray: [f64; 3]) -> Option<[f64; 3]> {
        let across = dot(ray, self.normal);
        let weight = |v: [f64; 3]| (dot(ray, v) / across).max(0.0);
        let (u, v) = (weight(self.along_u), weight(self.along_v));
        let sum = (u + v).max(1.0);
        let (u, v) = (u / sum, v / sum);
        (across != 0.0 && u.is_finite() && v.is_finite()).then_some([(1.0 - u - v).max(0.0), u, v])
    }
}

/// The unit normal of a triangle's front.
pub(crate) fn flat_normal(scene: &Scene, triangle: usize) -> [f32; 3] {
    let [a, b, c] = scene.triangles[triangle].map(|i| scene.vertices[i as usize].position.map(f64::from));
    normalize(cross(minus(b, a), minus(c, a))).map(|c| c as f32)
}

/// Whether an eye looks at the back of a triangle that has none.
pub(crate) fn is_hidden(scene: &Scene, eye: [f32; 3], triangle: usize) -> bool {
    let material = scene.triangle_material[triangle] as usize;
    if !scene.materials[material].one_sided {
        return false;
    }
    let [a, b, c] = scene.triangles[triangle].map(|i| scene.vertices[i as usize].position.map(f64::from));
    dot(cross(minus(b, a), minus(c, a)), minus(eye.map(f64::from), a)) <= 0.0
}

/// Albedo where a triangle is seen.
struct Paint<'a> {
    factor: [f32; 3],
    texture: Option<&'a Texture>,
    uv: [[f64; 2]; 3],
    tint: Option<[[f32; 4]; 3]>,
}

impl<'a> Paint<'a> {
    fn of(scene: &'a Scene, triangle: usize) -> Self {
        let material = &scene.materials[scene.triangle_material[triangle] as usize];
        let corners = scene.triangles[triangle];
        let tint = |i: u32| scene.colors.get(i as usize).copied().unwrap_or([1.0; 4]);
        Self {
            factor: material.factor,
            texture: material.texture.as_ref(),
            uv: corners.map(|i| scene.vertices[i as usize].uv.map(f64::from)),
            tint: (!scene.colors.is_empty()).then(|| corners.map(tint)),
        }
    }

    fn uv(&self, w: [f64; 3]) -> [f64; 2] {
        [0, 1].map(|k| (0..3).map(|corner| w[corner] * self.uv[corner][k]).sum())
    }

    /// By the weights of the corners at the pixel; `beside` are those at the pixels to the right and below, on the plane.
    fn albedo(&self, w: [f64; 3], beside: impl FnOnce() -> [[f64; 3]; 2]) -> [f32; 3] {
        /// Stands for no change from pixel to pixel.
        const LEAST_FOOTPRINT: f64 = 1e-9;
        let mut albedo = self.factor;
        if let Some(tint) = &self.tint {
            let mixed =
                [0, 1, 2].map(|k| (0..3).map(|corner| w[corner] as f32 * tint[corner][k]).sum::<f32>());
            (0..3).for_each(|k| albedo[k] *= mixed[k]);
        }
        if let Some(texture) = self.texture {
            let (uv, size) = (self.uv(w), texture.size().map(f64::from));
            let step = |w: [f64; 3]| {
                let next = self.uv(w);
                ((next[0] - uv[0]) * size[0]).hypot((next[1] - uv[1]) * size[1])
            };
            let [right, below] = beside().map(step);
            let footprint = right.max(below);
            // The finest level where the plane is seen from its side and ends nowhere.
            let level = if footprint.is_finite() { footprint.max(LEAST_FOOTPRINT).log2() } else { 0.0 };
            let colour = texture.sample(uv, level);
            (0..3).for_each(|k| albedo[k] *= colour[k]);
        }
        albedo
    }
}

pub(crate) fn render(
    scene: &Scene,
    camera: &Camera,
    [width, height]: [u32; 2],
) -> Result<Frame, RenderError> {
    check_size(width, height)?;
    scene.check()?;
    // Masks are checked as for stacks.
    crate::stack::fixed_point::Masks::new(scene)?;
    let view = CameraView::new(camera, width, height)?;
    let position = |i: u32| scene.vertices[i as usize].position.map(f64::from);
    let pieces: Vec<(u32, PreparedTriangle)> = scene
        .triangles
        .par_iter()
        .enumerate()
        .filter(|(index, _)| !is_hidden(scene, camera.eye, *index))
        .flat_map_iter(|(index, triangle)| {
            let polygon = view.clip(triangle.map(|i| view.camera_space(position(i))));
            let pixels: Vec<[i32; 2]> = polygon.iter().map(|&c| view.pixel(c)).collect();
            let fan = (2..pixels.len().max(2)).map(move |i| [pixels[0], pixels[i - 1], pixels[i]]);
            fan.filter_map(move |corners| Some((index as u32, piece(corners, width, height)?)))
        })
        .collect();

    let pixels = width as usize * height as usize;
    let mut frame = Frame {
        width,
        height,
        triangle: vec![NO_TRIANGLE; pixels],
        position: vec![[0.0; 3]; pixels],
        normal: vec![[0.0; 3]; pixels],
        albedo: vec![[0.0; 3]; pixels],
    };
    let band = (BAND_ROWS * width) as usize;
    let bands = frame.triangle.par_chunks_mut(band).zip(frame.position.par_chunks_mut(band));
    let bands = bands.zip(frame.normal.par_chunks_mut(band)).zip(frame.albedo.par_chunks_mut(band));
    bands.enumerate().for_each(|(index, (((triangle, position), normal), albedo))| {
        let first_row = index as u32 * BAND_ROWS;
        let rows = first_row..(first_row + BAND_ROWS).min(height);
        let mut nearest = vec![f64::INFINITY; triangle.len()];
        for &(source, ref piece) in &pieces {
            if u32::from(piece.bounds[3]) <= rows.start || u32::from(piece.bounds[1]) >= rows.end {
                continue;
            }
            let corners = scene.triangles[source as usize].map(|i| &scene.vertices[i as usize]);
            let world = corners.map(|v| v.position.map(f64::from));
            let surface = Surface::new(view.eye, world);
            let material = &scene.materials[scene.triangle_material[source as usize] as usize];
            let paint = Paint::of(scene, source as usize);
            let mix = |w: [f64; 3], v: [[f64; 3]; 3]| {
                [0, 1, 2].map(|k| w[0] * v[0][k] + w[1] * v[1][k] + w[2] * v[2][k])
            };
            for_each_span(piece, rows.clone(), |y, span| {
                for x in span {
                    let Some(w) = surface.weights(view.ray(x, y)) else { continue };
                    let p = mix(w, world);
                    let from_eye = minus(p, view.eye);
                    let distance = dot(from_eye, view.forward);
                    let pixel = ((y - first_row) * width + x) as usize;
                    // Of equal distances the first triangle stays.
                    if distance >= nearest[pixel] {
                        continue;
                    }
                    if material.mask.as_ref().is_some_and(|mask| !mask.passes(paint.uv(w))) {
                        continue;
                    }
                    nearest[pixel] = distance;
                    triangle[pixel] = source;
                    position[pixel] = p.map(|c| c as f32);
                    let beside =
                        || [(x + 1, y), (x, y + 1)].map(|(x, y)| surface.weights_on_plane(view.ray(x, y)));
                    albedo[pixel] = paint.albedo(w, beside);
                    let n = mix(w, corners.map(|v| v.normal.map(f64::from)));
                    let n = if dot(n, n) > 1e-12 { n } else { surface.normal };
                    let sign = if dot(n, from_eye) > 0.0 { -1.0 } else { 1.0 };
                    normal[pixel] = normalize(n).map(|c| (sign * c) as f32);
                }
            });
        }
    });
    Ok(frame)
}
