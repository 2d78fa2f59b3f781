//! Orthographic light space: from world positions to texels and depth.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use crate::{RenderError, Scene};

/// Largest supported width and height of a shadow map in texels.
pub const MAX_MAP_SIZE: u32 = 8192;

/// Empty texels kept on every side of a fitted map of at least 45 texels, one more than the radius of a 9x9
/// kernel, so that kernels at the scene's outline see emptiness. Smaller maps keep fewer: see
/// [`LightFrame::fit`].
pub const FIT_MARGIN: u32 = 5;

/// Orthographic projection of a directional light.
///
/// Texel x grows to the right and texel y downwards as seen along the light, depth grows along the light:
/// (right, down, forward) is a right-handed orthonormal frame. Texel (i, j) covers [i, i+1) x [j, j+1), its centre
/// is (i + 0.5, j + 0.5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightFrame {
    /// World direction of growing texel x, unit length.
    pub right: [f64; 3],
    /// World direction of growing texel y, unit length.
    pub down: [f64; 3],
    /// World direction in which the light travels and depth grows, unit length.
    pub forward: [f64; 3],
    /// Texels per world unit in x and in y.
    pub texels_per_unit: [f64; 2],
    /// Texel coordinates of the world's origin.
    pub origin_texel: [f64; 2],
    /// Distance along `forward` that has depth 0.
    pub near: f64,
    /// Distance along `forward` from depth 0 to depth 1, positive.
    pub depth_range: f64,
    /// Map width in texels.
    pub width: u32,
    /// Map height in texels.
    pub height: u32,
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn normalize(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    [a[0] / length, a[1] / length, a[2] / length]
}

/// Checks a map size against [`MAX_MAP_SIZE`].
pub(crate) fn check_size(width: u32, height: u32) -> Result<(), RenderError> {
    if width == 0 || height == 0 || width > MAX_MAP_SIZE || height > MAX_MAP_SIZE {
        return Err(RenderError::MapSize { width, height });
    }
    Ok(())
}

/// Margin in texels for one side of the map: [`FIT_MARGIN`], or a ninth of small maps, so that 1 texel stays 1 texel.
fn margin(size: u32) -> f64 {
    f64::from(FIT_MARGIN.min(size / 9))
}

/// List entries read by one task.
const CHUNK: usize = 1 << 14;

/// Least and greatest coordinates, along each axis, of the vertices that triangles use.
fn extent_along(scene: &Scene, axes: [[f64; 3]; 3]) -> [[f64; 3]; 2] {
    // Marking the vertices first is cheaper than three products for every corner.
    let mut used: Vec<AtomicBool> = Vec::new();
    used.resize_with(scene.vertices.len(), || AtomicBool::new(false));
    scene.triangles.par_chunks(CHUNK).for_each(|chunk| {
        for &i in chunk.iter().flatten() {
            used[i as usize].store(true, Ordering::Relaxed);
        }
    });
    let nothing = || [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    // Minima and maxima do not depend on the order of work.
    scene
        .vertices
        .par_chunks(CHUNK)
        .zip(used.par_chunks(CHUNK))
        .map(|(vertices, used)| {
            let [mut low, mut high] = nothing();
            for (vertex, used) in vertices.iter().zip(used) {
                if !used.load(Ordering::Relaxed) {
                    continue;
                }
                let p = vertex.position.map(f64::from);
                for (k, axis) in axes.into_iter().enumerate() {
                    let t = dot(p, axis);
                    low[k] = if t < low[k] { t } else { low[k] };
                    high[k] = if t > high[k] { t } else { high[k] };
                }
            }
            [low, high]
        })
        .reduce(nothing, |a, b| {
            [[0, 1, 2].map(|k| a[0][k].min(b[0][k])), [0, 1, 2].map(|k| a[1][k].max(b[1][k]))]
        })
}

impl LightFrame {
    /// The frame's axes for a light travelling along `direction`, as (right, down, forward).
    ///
    /// Upwards on the map is the world's y axis; for lights within about 2.6 degrees of vertical it is the negative
    /// z axis, so that the choice is deterministic and well conditioned.
    ///
    /// # Errors
    /// [`RenderError::LightDirection`] if a component is not finite or all are zero.
    pub fn axes(direction: [f32; 3]) -> Result<[[f64; 3]; 3], RenderError> {
        let largest = direction.iter().fold(0.0f32, |m, c| m.max(c.abs()));
        if !direction.iter().all(|c| c.is_finite()) || largest == 0.0 {
            return Err(RenderError::LightDirection(direction));
        }
        // Dividing by the largest component first keeps denormal directions exact enough to normalise.
        let forward = normalize(direction.map(|c| f64::from(c) / f64::from(largest)));
        let up = if forward[1].abs() > 0.999 { [0.0, 0.0, -1.0] } else { [0.0, 1.0, 0.0] };
        let right = normalize(cross(forward, up));
        Ok([right, cross(forward, right), forward])
    }

    /// Fits the triangles of `scene` into a map of the given size, x and y on their own as low light would leave
    /// most of the map empty otherwise, with a margin of [`FIT_MARGIN`] texels (a ninth of the side for sides under 45
    /// texels), depth from 0 at the first to 1 at the
    /// last used vertex. A scene without extent in depth gets depth 0 throughout.
    ///
    /// # Errors
    /// [`RenderError::MapSize`], [`RenderError::LightDirection`], [`RenderError::EmptyScene`], or
    /// [`RenderError::Scene`] for dangling indices and positions that are not finite.
    pub fn fit(scene: &Scene, direction: [f32; 3], width: u32, height: u32) -> Result<Self, RenderError> {
        check_size(width, height)?;
        let [right, down, forward] = Self::axes(direction)?;
        crate::check_scene::check_scene(scene)?;
        let [low, high] = extent_along(scene, [right, down, forward]);
        let extent = |k: usize| high[k] - low[k];
        let usable = |size: u32| f64::from(size) - 2.0 * margin(size);
        let scale = [(0, width), (1, height)].map(|(k, size)| {
            let scale = usable(size) / extent(k);
            // Without extent nothing will be covered, whatever the scale.
            if scale.is_finite() && scale > 0.0 { scale } else { 1.0 }
        });
        let centre = |k: usize, size: u32| 0.5 * f64::from(size) - scale[k] * 0.5 * (low[k] + high[k]);
        Ok(Self {
            right,
            down,
            forward,
            texels_per_unit: scale,
            origin_texel: [centre(0, width), centre(1, height)],
            near: low[2],
            depth_range: if extent(2) > 0.0 { extent(2) } else { 1.0 },
            width,
            height,
        })
    }

    /// Texel coordinates and depth of a world position; depth is not clamped.
    pub fn project(&self, position: [f64; 3]) -> [f64; 3] {
        [
            dot(position, self.right) * self.texels_per_unit[0] + self.origin_texel[0],
            dot(position, self.down) * self.texels_per_unit[1] + self.origin_texel[1],
            (dot(position, self.forward) - self.near) / self.depth_range,
        ]
    }
}
