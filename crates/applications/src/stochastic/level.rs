//! A level of the filter: samples before gathering, sums after it.

use moment_problem::arithmetic::Real;
use rayon::prelude::*;
use shadow_filtering::Precision;

use super::plane::{Footprint, PlaneFilter, TILE};

/// Texels with a weight, and what belongs to it; after gathering sums in place of means.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Level<R> {
    pub(super) size: [usize; 2],
    channels: usize,
    /// Samples; 0 where there is none.
    pub(super) weight: Vec<R>,
    /// rho in this level's texels.
    pub(super) radius: Vec<R>,
    /// From the texel's middle to where the sample reaches from.
    pub(super) offset: Vec<[R; 2]>,
    pub(super) values: Vec<R>,
}

/// Which tiles of a level somebody needs.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tiles {
    size: [usize; 2],
    active: Vec<bool>,
}

impl Tiles {
    /// Tiles with a needed texel, and their neighbours: look-ups and smoothing reach over borders.
    pub(super) fn new([width, height]: [usize; 2], needed: Option<&[bool]>) -> Self {
        let size = [width.div_ceil(TILE), height.div_ceil(TILE)];
        let Some(needed) = needed else { return Self { size, active: vec![true; size[0] * size[1]] } };
        let mut active = vec![false; size[0] * size[1]];
        for (texel, _) in needed.iter().enumerate().filter(|(_, needed)| **needed) {
            active[texel / width / TILE * size[0] + texel % width / TILE] = true;
        }
        Self { size, active }.grown()
    }

    fn grown(&self) -> Self {
        let [width, height] = self.size;
        let near = |t: usize, size: usize| t.saturating_sub(1)..=(t + 1).min(size - 1);
        let any = |i: usize| {
            let (x, y) = (i % width, i / width);
            near(y, height).any(|row| near(x, width).any(|column| self.active[row * width + column]))
        };
        Self { size: self.size, active: (0..self.active.len()).map(any).collect() }
    }

    /// Those of the next coarser level, which has the given size in texels.
    pub(super) fn coarser(&self, [width, height]: [usize; 2]) -> Self {
        let size = [width.div_ceil(TILE), height.div_ceil(TILE)];
        let mut active = vec![false; size[0] * size[1]];
        for (i, _) in self.active.iter().enumerate().filter(|(_, active)| **active) {
            active[(i / self.size[0] / 2) * size[0] + i % self.size[0] / 2] = true;
        }
        Self { size, active }.grown()
    }

    pub(super) fn share(&self) -> f64 {
        self.active.iter().filter(|active| **active).count() as f64 / self.active.len() as f64
    }

    fn holds(&self, x: usize, y: usize) -> bool {
        self.active[y / TILE * self.size[0] + x / TILE]
    }
}

impl<R: Precision> Level<R> {
    pub(super) fn empty(size: [usize; 2], channels: usize) -> Self {
        let count = size[0] * size[1];
        Self {
            size,
            channels,
            weight: vec![R::zero(); count],
            radius: vec![R::zero(); count],
            offset: vec![[R::zero(); 2]; count],
            values: vec![R::zero(); count * channels],
        }
    }

    /// Gives the share of each sample that `coarser` says for its radius to a level of half the size, and keeps the rest.
    pub(super) fn split(&mut self, coarser: impl Fn(R) -> R + Sync) -> Self {
        let [width, height] = self.size;
        let mut next = Self::empty([width.div_ceil(2), height.div_ceil(2)], self.channels);
        let (columns, channels, finer) = (next.size[0], self.channels, &*self);
        let half = R::from_f64(0.5);
        let texels = next.values.par_chunks_mut(channels).zip(&mut next.weight).zip(&mut next.radius);
        texels.zip(&mut next.offset).enumerate().for_each(|(i, (((values, weight), radius), offset))| {
            let (x, y) = (i % columns, i / columns);
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let (fx, fy) = (2 * x + dx, 2 * y + dy);
                if fx >= width || fy >= height {
                    continue;
                }
                let j = fy * width + fx;
                let share = finer.weight[j] * coarser(finer.radius[j]);
                if share <= R::zero() {
                    continue;
                }
                *weight = *weight + share;
                *radius = *radius + share * half * finer.radius[j];
                if finer.offset[j] != [R::zero(); 2] {
                    let corner = [dx, dy].map(|d| R::from_f64(d as f64 - 0.5));
                    (0..2).for_each(|k| {
                        offset[k] = offset[k] + share * half * (corner[k] + finer.offset[j][k]);
                    });
                }
                add(values, share, &finer.values[j * channels..(j + 1) * channels]);
            }
            if *weight > R::zero() {
                let inverse = R::one() / *weight;
                *radius = *radius * inverse;
                offset.iter_mut().for_each(|offset| *offset = *offset * inverse);
                values.iter_mut().for_each(|value| *value = *value * inverse);
            }
        });
        self.weight
            .par_iter_mut()
            .zip(&self.radius)
            .for_each(|(weight, &radius)| *weight = *weight * (R::one() - coarser(radius)));
        next
    }

    /// Sums over the samples that reach each texel, weighted by 1 / rho^2 (equation 7) times `scale`, which makes the radii of
    /// all levels comparable.
    pub(super) fn gathered(&self, filter: &PlaneFilter, aspect: [f64; 2], scale: R, tiles: &Tiles) -> Self {
        let [width, height] = self.size;
        let channels = self.channels;
        let aspect = aspect.map(R::from_f64);
        let mut sums = Self::empty(self.size, channels);
        let reach = self.largest_reach(filter, aspect);
        let across = width.div_ceil(TILE);
        let stride = if filter.interleaved { 2 } else { 1 };
        let disc = filter.footprint == Footprint::Disc;
        // The rectangle has the area of the disc.
        let side = R::from_f64(0.5 * std::f64::consts::PI.sqrt());
        let rows = sums.values.par_chunks_mut(width * channels).zip(sums.weight.par_chunks_mut(width));
        rows.enumerate().for_each(|(y, (values, weights))| {
            for x in (0..width).filter(|&x| tiles.holds(x, y)) {
                let radius = reach[y / TILE * across + x / TILE];
                // Every second sample, the texel's own among them.
                let first = |t: usize| {
                    let low = t.saturating_sub(radius);
                    if stride == 2 && (t - low) % 2 == 1 { low + 1 } else { low }
                };
                let out = &mut values[x * channels..(x + 1) * channels];
                for row in (first(y)..=(y + radius).min(height - 1)).step_by(stride) {
                    for column in (first(x)..=(x + radius).min(width - 1)).step_by(stride) {
                        let i = row * width + column;
                        let weight = self.weight[i];
                        if weight <= R::zero() {
                            continue;
                        }
                        let steps = [column as f64 - x as f64, row as f64 - y as f64];
                        let [dx, dy] =
                            [0, 1].map(|k| (R::from_f64(steps[k]) + self.offset[i][k]) / aspect[k]);
                        let rho = self.radius[i];
                        let is_reached = if disc {
                            dx * dx + dy * dy < rho * rho
                        } else {
                            dx.abs() < side * rho && dy.abs() < side * rho
                        };
                        if is_reached {
                            let weight = scale * weight / (rho * rho);
                            weights[x] = weights[x] + weight;
                            add(out, weight, &self.values[i * channels..(i + 1) * channels]);
                        }
                    }
                }
            }
        });
        sums
    }

    /// How far texels of each tile have to look: as far as the largest radius in the tile and around it, at most R_G.
    fn largest_reach(&self, filter: &PlaneFilter, aspect: [R; 2]) -> Vec<usize> {
        let [width, height] = self.size;
        let (across, down) = (width.div_ceil(TILE), height.div_ceil(TILE));
        let wide = aspect[0].max(aspect[1]);
        let of_tile = |tile: usize| {
            let (left, top) = (tile % across * TILE, tile / across * TILE);
            let mut most = R::zero();
            for y in top..(top + TILE).min(height) {
                for x in left..(left + TILE).min(width) {
                    let i = y * width + x;
                    if self.weight[i] > R::zero() {
                        let [dx, dy] = self.offset[i];
                        most = most.max(wide * self.radius[i] + dx.abs().max(dy.abs()));
                    }
                }
            }
            most
        };
        let own: Vec<R> = (0..across * down).into_par_iter().map(of_tile).collect();
        let near = |t: usize, size: usize| t.saturating_sub(1)..=(t + 1).min(size - 1);
        let around = |tile: usize| {
            let (x, y) = (tile % across, tile / across);
            let rows = near(y, down).flat_map(|row| near(x, across).map(move |column| row * across + column));
            let most = rows.map(|tile| own[tile]).fold(R::zero(), R::max);
            (most.to_f64().ceil() as usize).min(filter.gather_radius)
        };
        (0..across * down).map(around).collect()
    }

    /// Adds the sums of a level of half the size, interpolated.
    pub(super) fn add_upsampled(&mut self, coarser: &Self, tiles: &Tiles) {
        let [width, _] = self.size;
        let [columns, rows] = coarser.size;
        let channels = self.channels;
        let texels = self.values.par_chunks_mut(channels).zip(&mut self.weight).enumerate();
        texels.filter(|(i, _)| tiles.holds(i % width, i / width)).for_each(|(i, (values, weight))| {
            let place = |t: usize, size: usize| {
                let at = (0.5 * (t as f64 + 0.5) - 0.5).clamp(0.0, (size - 1) as f64);
                let low = at.floor() as usize;
                // A multiple of a quarter.
                (low, (low + 1).min(size - 1), R::from_f64(at.fract()))
            };
            let (left, right, u) = place(i % width, columns);
            let (top, bottom, v) = place(i / width, rows);
            let one = R::one();
            let corners = [
                (left, top, (one - u) * (one - v)),
                (right, top, u * (one - v)),
                (left, bottom, (one - u) * v),
                (right, bottom, u * v),
            ];
            for (x, y, share) in corners {
                let j = y * columns + x;
                *weight = *weight + share * coarser.weight[j];
                add(values, share, &coarser.values[j * channels..(j + 1) * channels]);
            }
        });
    }

    /// Means of sums over 3x3 texels.
    pub(super) fn boxed(&self, tiles: &Tiles) -> Self {
        let [width, height] = self.size;
        let channels = self.channels;
        let mut out = Self::empty(self.size, channels);
        let texels = out.values.par_chunks_mut(channels).zip(&mut out.weight).enumerate();
        texels.filter(|(i, _)| tiles.holds(i % width, i / width)).for_each(|(i, (values, weight))| {
            let near = |t: usize, size: usize| t.saturating_sub(1)..=(t + 1).min(size - 1);
            let mut count = R::zero();
            for y in near(i / width, height) {
                for x in near(i % width, width) {
                    let j = y * width + x;
                    count = count + R::one();
                    *weight = *weight + self.weight[j];
                    add(values, R::one(), &self.values[j * channels..(j + 1) * channels]);
                }
            }
            *weight = *weight / count;
            values.iter_mut().for_each(|value| *value = *value / count);
        });
        out
    }
}

/// Adds so much of some values to others.
pub(super) fn add<R: Real>(to: &mut [R], share: R, values: &[R]) {
    to.iter_mut().zip(values).for_each(|(to, &value)| *to = *to + share * value);
}
