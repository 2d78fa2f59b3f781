//! The multi-resolution filter of a plane (SSSM15 section 7): rays are moved onto it, every sample gets its radius, and each
//! level gathers the samples that it is responsible for.

use rayon::prelude::*;
use thiserror::Error;

use super::coarser_weight;
use super::edges::edge_circles;
use super::lens_map::LensMap;
use super::level::{Level, Tiles, add};
use super::merging::reproject;
use crate::samples::PoissonTaps;
use shadow_filtering::Precision;

/// Shape of a sample's reach: that of the light.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Footprint {
    /// A disc, as published.
    Disc,
    /// The rectangle of the light, whose area is the disc's.
    Rectangle,
}

/// Where a sample reaches from.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum SampleCentre {
    /// The middle of the texel that holds it (SSSM15 section 7.3).
    Texel,
    /// Where the light's middle sees it (section 5.3).
    Projected,
}

/// How a plane is filtered.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneFilter {
    /// Shape.
    pub footprint: Footprint,
    /// Centre.
    pub centre: SampleCentre,
    /// Least rho in texels: in focus 1 / rho^2 has no limit.
    pub least_radius: f64,
    /// Taps by which the nearest occluding sample is looked for (12), 0 for none at all.
    pub edge_taps: usize,
    /// How far they reach in texels (32).
    pub edge_reach: f64,
    /// Whether the radii that they find are smoothed by a Gaussian of 2 texels.
    pub edge_smoothing: bool,
    /// R_G: how far every level gathers, in its texels (8).
    pub gather_radius: usize,
    /// Levels above the finest (2).
    pub coarse_levels: usize,
    /// Whether every second sample is left out in both directions.
    pub interleaved: bool,
    /// Whether levels are smoothed over 3x3 texels when they are put together.
    pub box_filter: bool,
}

/// Why a filter makes no sense.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{key} = {value} {reason}")]
pub struct PlaneError {
    /// The setting.
    pub key: &'static str,
    /// Its value.
    pub value: f64,
    /// What is wrong.
    pub reason: &'static str,
}

/// Largest R_G: the halo around a tile of 16 texels that a work group loads.
pub const TILE: usize = 16;

/// Most levels above the finest: 2^12 texels are a whole map.
const MOST_LEVELS: usize = 12;

impl PlaneFilter {
    /// As SSSM15 has it. It states no least radius; one texel reaches the neighbours that interleaving leaves out.
    pub fn published() -> Self {
        Self {
            footprint: Footprint::Disc,
            centre: SampleCentre::Texel,
            least_radius: 1.0,
            edge_taps: 12,
            edge_reach: 32.0,
            edge_smoothing: true,
            gather_radius: 8,
            coarse_levels: 2,
            interleaved: true,
            box_filter: true,
        }
    }

    /// Rejects what makes no sense: radii beyond a tile's halo, more levels than a map has.
    ///
    /// # Errors
    /// [`PlaneError`] with the setting and its value.
    pub fn check(&self) -> Result<(), PlaneError> {
        let fail = |key, value, reason| Err(PlaneError { key, value, reason });
        if !(1..=TILE).contains(&self.gather_radius) {
            return fail(
                "gather_radius",
                self.gather_radius as f64,
                "does not lie in 1 to 16, the texels of a tile",
            );
        }
        let (radius, most) = (self.least_radius, 0.5 * self.gather_radius as f64);
        if !(radius > 0.0 && radius <= most) {
            return fail("least_radius", radius, "does not lie in (0, gather_radius / 2]");
        }
        if !(self.edge_reach > 0.0 && self.edge_reach <= 1024.0) {
            return fail("edge_reach", self.edge_reach, "does not lie in (0, 1024]");
        }
        if self.edge_taps > 4096 {
            return fail("edge_taps", self.edge_taps as f64, "is more than 4096");
        }
        if self.coarse_levels > MOST_LEVELS {
            return fail("coarse_levels", self.coarse_levels as f64, "is more than 12");
        }
        Ok(())
    }

    /// Radius in texels of the finest level up to which the filter finds every texel that a sample reaches.
    pub fn largest_radius(&self) -> f64 {
        0.5 * self.gather_radius as f64 * (1u64 << self.coarse_levels) as f64
    }
}

/// A filtered plane: normalised values a texel, none where no sample reaches.
#[derive(Clone, Debug, PartialEq)]
pub struct FilteredPlane<R> {
    pub(super) size: [usize; 2],
    pub(super) channels: usize,
    pub(super) values: Vec<R>,
    pub(super) weights: Vec<R>,
    /// Share of tiles that were filtered on the finest level.
    pub active_tiles: f64,
    /// Share of samples that reach farther than the filter can follow.
    pub cut_off: f64,
    /// Samples a texel that was merged from, on average of those that have any.
    pub merged: f64,
}

impl<R: Precision> FilteredPlane<R> {
    /// Changes the values of every texel that has any: what a format keeps of them.
    pub fn for_each_texel(&mut self, change: impl Fn(&mut [R]) + Sync) {
        let texels = self.values.par_chunks_mut(self.channels).zip(&self.weights);
        texels.filter(|(_, weight)| **weight > R::zero()).for_each(|(values, _)| change(values));
    }

    /// Values at texel coordinates, interpolated between the texels that have any; `None` where none has.
    pub fn at(&self, position: [R; 2], out: &mut [R]) -> Option<()> {
        let [width, height] = self.size;
        let half = R::from_f64(0.5);
        let place = |t: R, size: usize| {
            let at = (t - half).max(R::zero()).min(R::from_f64((size - 1) as f64));
            let low = at.to_f64().floor();
            (low as usize, at - R::from_f64(low))
        };
        let ((left, u), (top, v)) = (place(position[0], width), place(position[1], height));
        out.fill(R::zero());
        let mut total = R::zero();
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let along = |d: usize, share: R| if d == 0 { R::one() - share } else { share };
            let share = along(dx, u) * along(dy, v);
            let (column, row) = ((left + dx).min(width - 1), (top + dy).min(height - 1));
            let texel = row * width + column;
            if share > R::zero() && self.weights[texel] > R::zero() {
                total = total + share;
                add(out, share, &self.values[texel * self.channels..(texel + 1) * self.channels]);
            }
        }
        (total > R::zero()).then(|| out.iter_mut().for_each(|out| *out = *out / total))
    }
}

/// Filters a plane at a distance. `values` holds `channels` filterable values a ray; `needed` is true for texels that
/// somebody will read, all without it. The search for edges is turned by `seed`.
pub fn filter_plane<R: Precision>(
    map: &LensMap,
    distance: f64,
    (values, channels): (&[R], usize),
    filter: &PlaneFilter,
    (taps, seed): (&PoissonTaps, u64),
    needed: Option<&[bool]>,
) -> FilteredPlane<R> {
    let (mut finest, distances, merged) = reproject(map, distance, (values, channels), filter);
    if filter.edge_taps > 0 {
        let circles = edge_circles(&finest, &distances, map, filter, (taps, seed));
        let circles = finest.radius.par_iter_mut().zip(circles);
        circles.for_each(|(radius, circle)| *radius = radius.max(circle));
    }
    let least = R::from_f64(filter.least_radius);
    finest.radius.par_iter_mut().for_each(|radius| *radius = radius.max(least));
    let largest = R::from_f64(filter.largest_radius());
    let known = finest.weight.iter().filter(|&&weight| weight > R::zero()).count().max(1) as f64;
    let cut_off = finest
        .weight
        .iter()
        .zip(&finest.radius)
        .filter(|(weight, radius)| **weight > R::zero() && **radius > largest);
    let cut_off = cut_off.count() as f64 / known;
    let tiles = Tiles::new(map.lens().size, needed);
    let active_tiles = tiles.share();
    let mut levels = vec![(finest, tiles)];
    for _ in 0..filter.coarse_levels {
        let Some((finer, tiles)) = levels.last_mut() else { break };
        if finer.size.iter().all(|&side| side == 1) {
            break;
        }
        let coarser = finer.split(|radius| coarser_weight(R::from_f64(filter.gather_radius as f64), radius));
        let tiles = tiles.coarser(coarser.size);
        levels.push((coarser, tiles));
    }
    let aspect = map.lens().aspect();
    let mut below: Option<Level<R>> = None;
    for (place, (level, tiles)) in levels.iter().enumerate().rev() {
        let scale = R::from_f64(1.0 / (1u64 << (2 * place)) as f64);
        let mut sums = level.gathered(filter, aspect, scale, tiles);
        if let Some(coarser) = below {
            sums.add_upsampled(&coarser, tiles);
        }
        below = Some(if filter.box_filter { sums.boxed(tiles) } else { sums });
    }
    let (mut values, weights) = below.map_or((Vec::new(), Vec::new()), |sums| (sums.values, sums.weight));
    values.par_chunks_mut(channels).zip(&weights).for_each(|(values, &weight)| {
        if weight > R::zero() {
            values.iter_mut().for_each(|value| *value = *value / weight);
        }
    });
    FilteredPlane { size: map.lens().size, channels, values, weights, active_tiles, cut_off, merged }
}

#[cfg(test)]
#[path = "plane_tests.rs"]
mod tests;
