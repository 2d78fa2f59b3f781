//! A light frame around the triangles of a scene.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use scenes::Scene;
use scenes::vector::dot;

use super::{FIT_MARGIN, LightFrame, check_size};
use crate::RenderError;

/// Margin in texels for one side of the map: [`FIT_MARGIN`], or a ninth of small maps, so that 1 texel stays 1 texel.
pub(super) fn margin(size: u32) -> f64 {
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
    /// Fits the triangles of `scene` into a map of the given size, x and y on their own as low light would leave
    /// most of the map empty otherwise, with a margin of [`FIT_MARGIN`] texels (a ninth of the side for sides under 45
    /// texels), depth from 0 at the first to 1 at the
    /// last used vertex. A scene without extent in depth gets depth 0 throughout.
    ///
    /// # Errors
    /// [`RenderError::MapSize`], [`RenderError::LightDirection`], or
    /// [`RenderError::Scene`] without triangles, for dangling indices and positions that are not finite.
    pub fn fit(scene: &Scene, direction: [f32; 3], width: u32, height: u32) -> Result<Self, RenderError> {
        check_size(width, height)?;
        let [right, down, forward] = Self::axes(direction)?;
        scene.check()?;
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
            eye: None,
            texels_per_unit: scale,
            origin_texel: [centre(0, width), centre(1, height)],
            near: low[2],
            depth_range: if extent(2) > 0.0 { extent(2) } else { 1.0 },
            width,
            height,
        })
    }
}
