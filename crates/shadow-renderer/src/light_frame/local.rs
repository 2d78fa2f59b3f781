//! The light frame of a local light: a perspective view from its centre.

use rayon::prelude::*;
use scenes::vector::{cross, dot, normalize};
use scenes::{AreaLight, Outline, Scene};

use super::fit::margin;
use super::{LightFrame, check_size};
use crate::RenderError;
use crate::clip::{HalfSpace, clip};

/// Largest slope against the light's axis that a map covers, 63 degrees: beyond, texels on the axis would be few.
const STEEPEST: f64 = 2.0;

/// The nearest surface that a map can show, as a share of the distance of the farthest vertex. Perspective depths far away
/// lose as many bits as this has.
const NEAREST: f64 = 1.0 / 1024.0;

/// What lies so near to the light's plane, as a share of the distance of the farthest vertex, counts as lying in it: a
/// ceiling around a lamp. It is 16 times the rounding of positions in single precision.
const IN_PLANE: f64 = 1e-6;

/// Triangles looked at by one task.
const CHUNK: usize = 1 << 12;

/// Why a local light has no view of a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LocalLightError {
    /// It looks into emptiness.
    #[error(
        "light `{light}` lies behind the scene: nothing is within 63 degrees of the way it shines, {front:?}"
    )]
    Behind {
        /// The light.
        light: AreaLight,
        /// The direction U x V.
        front: [f64; 3],
    },
    /// A surface runs through it, or so close in front of its centre that a map cannot show it.
    #[error(
        "light `{light}` lies inside the scene: triangle {triangle} is {distance:.2e} in front of its centre or cuts it, \
         surfaces must keep a distance of {least:.2e}"
    )]
    Inside {
        /// The light.
        light: AreaLight,
        /// Which triangle.
        triangle: usize,
        /// Its distance from the light's plane, 0 where it cuts the light.
        distance: f64,
        /// Least distance.
        least: f64,
    },
}

impl LightFrame {
    /// The frame of a local light, see [`LightFrame::of_view`].
    pub(super) fn fit_local(
        scene: &Scene,
        (outline, centre, half_axes): (Outline, [f64; 3], [[f64; 3]; 2]),
        [width, height]: [u32; 2],
    ) -> Result<Self, RenderError> {
        check_size(width, height)?;
        scene.check()?;
        let light = AreaLight::Local { outline, centre, half_axes };
        let right = normalize(half_axes[0]);
        let forward = normalize(cross(right, normalize(half_axes[1])));
        let down = cross(forward, right);
        // Texels and depths come below.
        let eye = Self {
            right,
            down,
            forward,
            eye: Some(centre),
            texels_per_unit: [1.0; 2],
            origin_texel: [0.0; 2],
            near: 1.0,
            depth_range: 1.0,
            width,
            height,
        };
        let farthest = farthest(scene, &eye);
        let behind = || LocalLightError::Behind { light, front: forward };
        if farthest <= 0.0 {
            return Err(behind().into());
        }
        let least = NEAREST * farthest;
        let plane = IN_PLANE * farthest;
        let inside = |(triangle, distance)| LocalLightError::Inside { light, triangle, distance, least };
        if let Some(triangle) = first_cut(scene, &eye, outline, half_axes, plane) {
            return Err(inside((triangle, 0.0)).into());
        }
        let seen = seen(scene, &eye, plane);
        if let Some(near) = seen.nearest.filter(|nearest| nearest.1 < least) {
            return Err(inside(near).into());
        }
        let Some((_, near)) = seen.nearest else { return Err(behind().into()) };
        let usable = |size: u32| f64::from(size) - 2.0 * margin(size);
        let extent = |k: usize| seen.high[k] - seen.low[k];
        let scale = [(0, width), (1, height)].map(|(k, size)| {
            let scale = usable(size) / (extent(k) * near);
            // Without extent nothing will be covered, whatever the scale.
            if scale.is_finite() && scale > 0.0 { scale } else { 1.0 / near }
        });
        let middle = |k: usize, size: u32| {
            0.5 * f64::from(size) - scale[k] * near * 0.5 * (seen.low[k] + seen.high[k])
        };
        Ok(Self {
            texels_per_unit: scale,
            origin_texel: [middle(0, width), middle(1, height)],
            near,
            depth_range: if extent(2) > 0.0 { extent(2) } else { near },
            ..eye
        })
    }
}

fn light_space(scene: &Scene, eye: &LightFrame, triangle: &[u32; 3]) -> [[f64; 3]; 3] {
    triangle.map(|i| eye.light_space(scene.vertices[i as usize].position.map(f64::from)))
}

/// Largest distance of a used vertex in front of the light's plane.
fn farthest(scene: &Scene, eye: &LightFrame) -> f64 {
    let of = |triangle| light_space(scene, eye, triangle).iter().fold(0.0, |far: f64, p| far.max(p[2]));
    scene.triangles.par_iter().with_min_len(CHUNK).map(of).reduce(|| 0.0, f64::max)
}

/// The first triangle that crosses the light's plane within its outline.
fn first_cut(
    scene: &Scene,
    eye: &LightFrame,
    outline: Outline,
    half_axes: [[f64; 3]; 2],
    plane: f64,
) -> Option<usize> {
    // In the light's plane p = a U + b V.
    let [u, v] = half_axes.map(|axis| [dot(axis, eye.right), dot(axis, eye.down)]);
    let area = u[0] * v[1] - u[1] * v[0];
    let on_light = |p: [f64; 2]| [(p[0] * v[1] - p[1] * v[0]) / area, (u[0] * p[1] - u[1] * p[0]) / area];
    let cuts = |triangle: &[u32; 3]| {
        let corners = light_space(scene, eye, triangle);
        let mut crossings = Vec::new();
        for i in 0..3 {
            let (p, q) = (corners[i], corners[(i + 1) % 3]);
            if (p[2] < -plane && q[2] > plane) || (q[2] < -plane && p[2] > plane) {
                let t = p[2] / (p[2] - q[2]);
                crossings.push(on_light([0, 1].map(|k| p[k] + t * (q[k] - p[k]))));
            } else if p[2].abs() <= plane {
                crossings.push(on_light([p[0], p[1]]));
            }
        }
        let in_plane = corners.iter().all(|p| p[2].abs() <= plane);
        !in_plane && matches!(crossings[..], [a, b] if meets(outline, a, b))
    };
    scene.triangles.par_iter().position_first(cuts)
}

/// Whether a segment comes inside of the unit square or disc.
fn meets(outline: Outline, a: [f64; 2], b: [f64; 2]) -> bool {
    let step = [b[0] - a[0], b[1] - a[1]];
    match outline {
        Outline::Disc => {
            let length = step[0] * step[0] + step[1] * step[1];
            let t = if length > 0.0 {
                (-(a[0] * step[0] + a[1] * step[1]) / length).clamp(0.0, 1.0)
            } else {
                0.0
            };
            [0, 1].map(|k| a[k] + t * step[k]).iter().map(|c| c * c).sum::<f64>() < 1.0
        }
        Outline::Rectangle => {
            // Where along the segment each coordinate lies within (-1, 1).
            let (mut from, mut to) = (0.0f64, 1.0f64);
            for k in 0..2 {
                if step[k] == 0.0 {
                    if a[k].abs() >= 1.0 {
                        return false;
                    }
                    continue;
                }
                let ends = [(-1.0 - a[k]) / step[k], (1.0 - a[k]) / step[k]];
                (from, to) = (from.max(ends[0].min(ends[1])), to.min(ends[0].max(ends[1])));
            }
            from < to || (a == b && from <= to)
        }
    }
}

/// What a light sees.
struct Seen {
    /// Least slopes in x and y, and least distance.
    low: [f64; 3],
    /// Greatest ones.
    high: [f64; 3],
    /// Triangle and distance of the nearest surface.
    nearest: Option<(usize, f64)>,
}

impl Seen {
    const NOTHING: Self = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3], nearest: None };

    /// Does not depend on the order: of equally near triangles the first counts.
    fn join(self, other: Self) -> Self {
        let nearer = |a: (usize, f64), b: (usize, f64)| if (b.1, b.0) < (a.1, a.0) { b } else { a };
        Self {
            low: [0, 1, 2].map(|k| self.low[k].min(other.low[k])),
            high: [0, 1, 2].map(|k| self.high[k].max(other.high[k])),
            nearest: match (self.nearest, other.nearest) {
                (Some(a), Some(b)) => Some(nearer(a, b)),
                (a, b) => a.or(b),
            },
        }
    }
}

fn seen(scene: &Scene, eye: &LightFrame, plane: f64) -> Seen {
    let field: [HalfSpace; 5] = [
        ([0.0, 0.0, 1.0], plane),
        ([1.0, 0.0, STEEPEST], 0.0),
        ([-1.0, 0.0, STEEPEST], 0.0),
        ([0.0, 1.0, STEEPEST], 0.0),
        ([0.0, -1.0, STEEPEST], 0.0),
    ];
    let of = |(triangle, corners): (usize, &[u32; 3])| {
        let polygon = clip(light_space(scene, eye, corners).to_vec(), &field);
        polygon.into_iter().fold(Seen::NOTHING, |seen, [x, y, z]| {
            let point = [x / z, y / z, z];
            seen.join(Seen { low: point, high: point, nearest: Some((triangle, z)) })
        })
    };
    let triangles = scene.triangles.par_iter().enumerate().with_min_len(CHUNK);
    triangles.map(of).reduce(|| Seen::NOTHING, Seen::join)
}
