//! The multi-resolution filter of a plane (SSSM15 section 7): rays are moved onto it, every sample gets its radius, and each
//! level gathers the samples that it is responsible for.

use rayon::prelude::*;
use thiserror::Error;

use super::coarser_weight;
use super::lens_map::LensMap;
use super::level::{Level, Tiles};
use crate::samples::PoissonTaps;

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
pub struct FilteredPlane {
    pub(super) size: [usize; 2],
    pub(super) channels: usize,
    pub(super) values: Vec<f32>,
    pub(super) weights: Vec<f32>,
    /// Share of tiles that were filtered on the finest level.
    pub active_tiles: f64,
    /// Share of samples that reach farther than the filter can follow.
    pub cut_off: f64,
    /// Samples a texel that was merged from, on average of those that have any.
    pub merged: f64,
}

impl FilteredPlane {
    /// Changes the values of every texel that has any: what a format keeps of them.
    pub fn for_each_texel(&mut self, change: impl Fn(&mut [f32]) + Sync) {
        let texels = self.values.par_chunks_mut(self.channels).zip(&self.weights);
        texels.filter(|(_, weight)| **weight > 0.0).for_each(|(values, _)| change(values));
    }

    /// Values at texel coordinates, interpolated between the texels that have any; `None` where none has.
    pub fn at(&self, [x, y]: [f64; 2], out: &mut [f32]) -> Option<()> {
        let [width, height] = self.size;
        let clamped = |t: f64, size: usize| (t - 0.5).clamp(0.0, (size - 1) as f64);
        let (x, y) = (clamped(x, width), clamped(y, height));
        let (left, top) = (x.floor(), y.floor());
        out.fill(0.0);
        let mut total = 0.0f32;
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let share = (1.0 - (x - left - dx as f64).abs()) * (1.0 - (y - top - dy as f64).abs());
            let (column, row) = ((left as usize + dx).min(width - 1), (top as usize + dy).min(height - 1));
            let texel = row * width + column;
            if share > 0.0 && self.weights[texel] > 0.0 {
                let share = share as f32;
                total += share;
                let values = &self.values[texel * self.channels..(texel + 1) * self.channels];
                out.iter_mut().zip(values).for_each(|(out, value)| *out += share * value);
            }
        }
        (total > 0.0).then(|| out.iter_mut().for_each(|out| *out /= total))
    }
}

/// Filters a plane at a distance. `values` holds `channels` filterable values a ray; `needed` is true for texels that
/// somebody will read, all without it. The search for edges is turned by `seed`.
pub fn filter_plane(
    map: &LensMap,
    distance: f64,
    (values, channels): (&[f32], usize),
    filter: &PlaneFilter,
    (taps, seed): (&PoissonTaps, u64),
    needed: Option<&[bool]>,
) -> FilteredPlane {
    let (mut finest, distances, merged) = reproject(map, distance, (values, channels), filter);
    if filter.edge_taps > 0 {
        let circles = edge_circles(&finest, &distances, map, filter, (taps, seed));
        finest.radius.par_iter_mut().zip(circles).for_each(|(radius, circle)| *radius = radius.max(circle));
    }
    finest.radius.par_iter_mut().for_each(|radius| *radius = radius.max(filter.least_radius as f32));
    let largest = filter.largest_radius() as f32;
    let known = finest.weight.iter().filter(|&&weight| weight > 0.0).count().max(1) as f64;
    let cut_off = finest
        .weight
        .iter()
        .zip(&finest.radius)
        .filter(|(weight, radius)| **weight > 0.0 && **radius > largest);
    let cut_off = cut_off.count() as f64 / known;
    let tiles = Tiles::new(map.lens().size, needed);
    let active_tiles = tiles.share();
    let mut levels = vec![(finest, tiles)];
    for _ in 0..filter.coarse_levels {
        let Some((finer, tiles)) = levels.last_mut() else { break };
        if finer.size.iter().all(|&side| side == 1) {
            break;
        }
        let coarser = finer.split(|radius| coarser_weight(filter.gather_radius as f32, radius));
        let tiles = tiles.coarser(coarser.size);
        levels.push((coarser, tiles));
    }
    let aspect = map.lens().aspect();
    let mut below: Option<Level> = None;
    for (place, (level, tiles)) in levels.iter().enumerate().rev() {
        let scale = 1.0 / (1u64 << (2 * place)) as f32;
        let mut sums = level.gathered(filter, aspect, scale, tiles);
        if let Some(coarser) = below {
            sums.add_upsampled(&coarser, tiles);
        }
        below = Some(if filter.box_filter { sums.boxed(tiles) } else { sums });
    }
    let (mut values, weights) = below.map_or((Vec::new(), Vec::new()), |sums| (sums.values, sums.weight));
    values.par_chunks_mut(channels).zip(&weights).for_each(|(values, &weight)| {
        if weight > 0.0 {
            values.iter_mut().for_each(|value| *value /= weight);
        }
    });
    FilteredPlane { size: map.lens().size, channels, values, weights, active_tiles, cut_off, merged }
}

/// Rays where they meet the plane: those of one texel are merged (section 7.4). Also the distances of what they hit, and how
/// many were merged on average.
fn reproject(
    map: &LensMap,
    plane: f64,
    (values, channels): (&[f32], usize),
    filter: &PlaneFilter,
) -> (Level, Vec<f32>, f64) {
    let [width, height] = map.lens().size;
    let count = width * height;
    let texel = |index: usize| {
        let [x, y] = map.position(index, plane);
        let inside = x >= 0.0 && y >= 0.0 && x < width as f64 && y < height as f64;
        inside.then(|| y as usize * width + x as usize)
    };
    let places: Vec<Option<usize>> = (0..count).into_par_iter().map(texel).collect();
    let mut ends = vec![0u32; count + 1];
    places.iter().flatten().for_each(|&place| ends[place + 1] += 1);
    for i in 0..count {
        ends[i + 1] += ends[i];
    }
    let mut next = ends.clone();
    let mut members = vec![0u32; ends[count] as usize];
    for (index, place) in places.iter().enumerate() {
        if let Some(place) = *place {
            members[next[place] as usize] = index as u32;
            next[place] += 1;
        }
    }
    let mut level = Level::empty([width, height], channels);
    let mut distances = vec![0.0f32; count];
    let rows = level.values.par_chunks_mut(channels).zip(&mut level.weight).zip(&mut level.radius);
    let rows = rows.zip(&mut level.offset).zip(&mut distances).enumerate();
    rows.for_each(|(place, ((((out, weight), radius), offset), distance))| {
        let list = &members[ends[place] as usize..ends[place + 1] as usize];
        if list.is_empty() {
            return;
        }
        let share = 1.0 / list.len() as f32;
        let centre = [(place % width) as f64 + 0.5, (place / width) as f64 + 0.5];
        for &index in list {
            let index = index as usize;
            let sample = &map.samples()[index];
            *radius += share * map.lens().circle(plane, f64::from(sample.distance)) as f32;
            *distance += share * sample.distance;
            if filter.centre == SampleCentre::Projected {
                let at = map.projected(index);
                (0..2).for_each(|k| offset[k] += share * (at[k] - centre[k]) as f32);
            }
            let values = &values[index * channels..(index + 1) * channels];
            out.iter_mut().zip(values).for_each(|(out, value)| *out += share * value);
        }
        *weight = list.len() as f32;
    });
    let used = ends.windows(2).filter(|pair| pair[1] > pair[0]).count().max(1);
    (level, distances, members.len() as f64 / used as f64)
}

/// c_l: the least circle of a nearer sample whose circle holds the texel's sample (section 5.2), found by a few taps; 0
/// without one.
fn edge_circles(
    level: &Level,
    distances: &[f32],
    map: &LensMap,
    filter: &PlaneFilter,
    (taps, seed): (&PoissonTaps, u64),
) -> Vec<f32> {
    let [width, height] = level.size;
    let aspect = map.lens().aspect().map(|a| a as f32);
    let find = |place: usize| -> f32 {
        if level.weight[place] <= 0.0 {
            return 0.0;
        }
        let (x, y) = ((place % width) as f32 + 0.5, (place / width) as f32 + 0.5);
        let own = [x + level.offset[place][0], y + level.offset[place][1]];
        let angle = random_stream::Random::stream(seed, place as u64).unit() * std::f64::consts::TAU;
        let (sin, cos) = angle.sin_cos();
        let mut least = f32::INFINITY;
        for &[u, v] in taps.points() {
            let reach = filter.edge_reach;
            let (column, row) =
                (f64::from(x) + reach * (cos * u - sin * v), f64::from(y) + reach * (sin * u + cos * v));
            if !(column >= 0.0 && row >= 0.0 && column < width as f64 && row < height as f64) {
                continue;
            }
            let other = row as usize * width + column as usize;
            if level.weight[other] <= 0.0 || distances[other] >= distances[place] {
                continue;
            }
            let centre = [column.floor() as f32 + 0.5, row.floor() as f32 + 0.5];
            let apart = [0, 1].map(|k| (centre[k] + level.offset[other][k] - own[k]) / aspect[k]);
            let circle = level.radius[other];
            if apart[0] * apart[0] + apart[1] * apart[1] < circle * circle {
                least = least.min(circle);
            }
        }
        if least.is_finite() { least } else { 0.0 }
    };
    let found: Vec<f32> = (0..width * height).into_par_iter().map(find).collect();
    if filter.edge_smoothing { smoothed(&found, [width, height]) } else { found }
}

/// Weights of a Gaussian of standard deviation 1 over 5 texels.
const GAUSSIAN: [f32; 5] = [0.054_488_68, 0.244_201_34, 0.402_619_96, 0.244_201_34, 0.054_488_68];

fn smoothed(field: &[f32], [width, height]: [usize; 2]) -> Vec<f32> {
    let tap = |t: usize, k: usize, size: usize| (t + k).saturating_sub(2).min(size - 1);
    let across = |i: usize| -> f32 {
        let (x, y) = (i % width, i / width);
        GAUSSIAN.iter().enumerate().map(|(k, weight)| weight * field[y * width + tap(x, k, width)]).sum()
    };
    let rows: Vec<f32> = (0..field.len()).into_par_iter().map(across).collect();
    let down = |i: usize| -> f32 {
        let (x, y) = (i % width, i / width);
        GAUSSIAN.iter().enumerate().map(|(k, weight)| weight * rows[tap(y, k, height) * width + x]).sum()
    };
    (0..field.len()).into_par_iter().map(down).collect()
}

#[cfg(test)]
#[path = "plane_tests.rs"]
mod tests;
