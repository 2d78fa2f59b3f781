//! The shadow map resampled into rectified coordinates, with and without a filter (BHS16 section 2.3).

use std::convert::Infallible;
use std::f64::consts::PI;

use rayon::prelude::*;
use shadow_filtering::{ChannelMap, FilteringError, Position, Precision, Pyramid, StoredField, Technique};

use super::{LightMap, Rectification, Rectified, Resampled, TwoDepths, two_depths};

/// One texel of the rectified map: normalised depths with weights that sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RectifiedTexel {
    /// pi - theta of the occluders, normalised and clamped to \[0, 1\].
    pub depths: [f64; 2],
    /// Their shares; the second is 0 where there is one depth.
    pub weights: [f64; 2],
}

/// A rectified shadow map before a technique encodes it.
#[derive(Clone, Debug)]
pub struct RectifiedMap {
    /// Its coordinates.
    pub rectification: Rectification,
    /// Row by row.
    pub texels: Vec<RectifiedTexel>,
}

/// A moment shadow map that can be filtered while it is resampled: mip maps of power moments, without a moment bias.
pub struct FilteredDepths<'a, P = f64> {
    pub(super) technique: &'a Technique,
    pub(super) levels: Pyramid<P>,
    /// The variable of depths 0 and 1.
    pub(super) ends: [f64; 2],
}

impl<'a, P: Precision> FilteredDepths<'a, P> {
    /// The mip maps of a map that `technique` has stored, which must be one of at least three power moments.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] for other techniques.
    pub fn new(technique: &'a Technique, map: &ChannelMap<P>) -> Result<Self, FilteringError> {
        let at = |depth: f64| {
            let mut b = vec![0.0; technique.channels()];
            technique.evaluate(depth, &mut b);
            b
        };
        let (first, last, middle) = (at(0.0), at(1.0), at(0.5));
        let of_power = |b: &[f64]| (1..b.len()).all(|k| (b[k] - b[0].powi(k as i32 + 1)).abs() < 1e-12);
        if first.len() < 3 || ![&first, &last, &middle].into_iter().all(|b| of_power(b)) {
            let reason = "resampling needs at least three power moments";
            let (value, reason) = (technique.name(), reason.to_owned());
            return Err(FilteringError::Parameter { key: "bound", value, reason });
        }
        Ok(Self { technique, levels: Pyramid::new(map), ends: [first[0], last[0]] })
    }

    /// What is stored on all levels, one behind the other, as shaders read it.
    pub fn for_shader(&self) -> Vec<f32> {
        let values = self.levels.levels().iter().flat_map(ChannelMap::data);
        values.map(|value| value.to_f64() as f32).collect()
    }

    /// Two depths of a trilinear sample at a point in texels of the map, `lod` halvings up.
    fn sample(&self, [x, y]: [f64; 2], lod: f64) -> Result<TwoDepths<f64>, FilteringError> {
        let levels = self.levels.levels();
        let lod = lod.clamp(0.0, (levels.len() - 1) as f64);
        let (lower, share) = (lod.floor() as usize, lod.fract());
        let channels = self.technique.channels();
        let mut mean = vec![P::zero(); channels];
        let mut level_mean = vec![P::zero(); channels];
        for (level, weight) in [(lower, 1.0 - share), (lower + 1, share)] {
            if weight == 0.0 {
                continue;
            }
            let map = &levels[level];
            let scale = [
                map.width() as f64 / levels[0].width() as f64,
                map.height() as f64 / levels[0].height() as f64,
            ];
            map.mean(Position { x: x * scale[0], y: y * scale[1] }, &mut level_mean)?;
            let weight = P::from_f64(weight);
            mean.iter_mut().zip(&level_mean).for_each(|(sum, value)| *sum = *sum + weight * *value);
        }
        let mut b = vec![P::zero(); channels];
        self.technique.restore(&mean, &mut b);
        let two = two_depths([b[0], b[1], b[2]]);
        let [start, end] = self.ends;
        let depths = two.depths.map(|x| (x.to_f64() - start) / (end - start));
        Ok(TwoDepths { depths, weights: two.weights.map(P::to_f64) })
    }
}

impl RectifiedMap {
    /// The nearest texel of the map for each, without a filter.
    pub fn nearest(rectification: Rectification, light: &LightMap<'_>) -> Self {
        let camera = rectification.axes.direction(rectification.camera);
        let texel = |column: usize, row: usize| {
            let [x, y] = rectification.texel(column, row);
            let z = light.occluder(camera[0] + x, camera[1] + y) - camera[2];
            let flipped = if z.is_finite() { Rectified::of([x, y, z]).flipped } else { PI };
            let depth = rectification.depth(flipped).clamp(0.0, 1.0);
            Ok::<_, Infallible>(RectifiedTexel { depths: [depth; 2], weights: [1.0, 0.0] })
        };
        match Self::of(rectification, texel) {
            Ok(map) => map,
            Err(never) => match never {},
        }
    }

    /// A filtered sample of a moment shadow map for each, as wide as the texel is on it, as two depths.
    ///
    /// # Errors
    /// [`FilteringError`] of the map's field.
    pub fn filtered<P: Precision>(
        rectification: Rectification,
        light: &LightMap<'_>,
        depths: &FilteredDepths<'_, P>,
    ) -> Result<Self, FilteringError> {
        let camera = rectification.axes.direction(rectification.camera);
        let range = [light.near - camera[2], light.near + light.range - camera[2]];
        let row_angle = rectification.phi_extent / rectification.size[1] as f64;
        let texel_size = light.texel[0].max(light.texel[1]);
        let size = [light.map.width() as f64, light.map.height() as f64];
        Self::of(rectification, |column, row| {
            let [x, y] = rectification.texel(column, row);
            let r = x.hypot(y);
            let at = [0, 1].map(|k| (camera[k] + [x, y][k] - light.corner[k]) / light.texel[k]);
            let is_on_map = (0..2).all(|k| (0.0..=size[k]).contains(&at[k]));
            if !is_on_map {
                return Ok(RectifiedTexel { depths: [1.0; 2], weights: [1.0, 0.0] });
            }
            // The mean of both sides: a texel far from the axis is much wider across than along its row.
            let footprint = (rectification.column_width() * r * row_angle).sqrt() / texel_size;
            let two = depths.sample(at, footprint.log2())?;
            let resampled = Resampled::of_cleared(two, range, r, rectification.flipped);
            Ok(RectifiedTexel { depths: resampled.depths, weights: two.weights })
        })
    }

    fn of<E: Send>(
        rectification: Rectification,
        texel: impl Fn(usize, usize) -> Result<RectifiedTexel, E> + Sync,
    ) -> Result<Self, E> {
        let [columns, rows] = rectification.size;
        let texels: Result<Vec<RectifiedTexel>, E> =
            (0..columns * rows).into_par_iter().map(|i| texel(i % columns, i / columns)).collect();
        Ok(Self { rectification, texels: texels? })
    }

    /// A row.
    pub fn row(&self, row: usize) -> &[RectifiedTexel] {
        let columns = self.rectification.size[0];
        &self.texels[row * columns..(row + 1) * columns]
    }

    /// How often the first depth changes by more than `least` along a row, up to and including a column: the complexity of
    /// what a prefix holds.
    pub fn depth_steps(&self, row: usize, column: usize, least: f64) -> usize {
        let row = &self.row(row)[..=column.min(self.rectification.size[0] - 1)];
        row.windows(2).filter(|pair| (pair[0].depths[0] - pair[1].depths[0]).abs() > least).count()
    }
}
