//! The search for edges in front of samples (SSSM15 section 5.2).

use rayon::prelude::*;
use shadow_filtering::Precision;

use super::lens_map::LensMap;
use super::level::Level;
use super::plane::PlaneFilter;
use crate::samples::PoissonTaps;

/// c_l: the least circle of a nearer sample whose circle holds the texel's sample (section 5.2), found by a few taps; 0
/// without one.
pub(super) fn edge_circles<R: Precision>(
    level: &Level<R>,
    distances: &[R],
    map: &LensMap,
    filter: &PlaneFilter,
    (taps, seed): (&PoissonTaps, u64),
) -> Vec<R> {
    let [width, height] = level.size;
    let aspect = map.lens().aspect().map(R::from_f64);
    let reach = R::from_f64(filter.edge_reach);
    let find = |place: usize| -> R {
        if level.weight[place] <= R::zero() {
            return R::zero();
        }
        let [x, y] = [place % width, place / width].map(|t| R::from_f64(t as f64 + 0.5));
        let own = [x + level.offset[place][0], y + level.offset[place][1]];
        let angle = R::from_f64(f64::from(turn(seed, place))) * R::from_f64(std::f64::consts::TAU);
        let (sin, cos) = (angle.sin(), angle.cos());
        let mut least = None;
        for point in taps.points() {
            let [u, v] = point.map(R::from_f64);
            let (column, row) = (x + reach * (cos * u - sin * v), y + reach * (sin * u + cos * v));
            let (column, row) = (column.to_f64(), row.to_f64());
            if !(column >= 0.0 && row >= 0.0 && column < width as f64 && row < height as f64) {
                continue;
            }
            let other = row as usize * width + column as usize;
            if level.weight[other] <= R::zero() || distances[other] >= distances[place] {
                continue;
            }
            let centre = [column, row].map(|t| R::from_f64(t.floor() + 0.5));
            let apart = [0, 1].map(|k| (centre[k] + level.offset[other][k] - own[k]) / aspect[k]);
            let circle = level.radius[other];
            if apart[0] * apart[0] + apart[1] * apart[1] < circle * circle {
                least = Some(least.map_or(circle, |least: R| least.min(circle)));
            }
        }
        least.unwrap_or(R::zero())
    };
    let found: Vec<R> = (0..width * height).into_par_iter().map(find).collect();
    if filter.edge_smoothing { smoothed(&found, [width, height]) } else { found }
}

/// By how much of a turn the taps of a texel are rotated.
pub(super) fn turn(seed: u64, place: usize) -> f32 {
    // Below 1 in single precision, too.
    (random_stream::Random::stream(seed, place as u64).unit() as f32).min(1.0f32.next_down())
}

/// Weights of a Gaussian of standard deviation 1 over 5 texels.
pub(super) const GAUSSIAN: [f64; 5] = [0.054_488_68, 0.244_201_34, 0.402_619_96, 0.244_201_34, 0.054_488_68];

fn smoothed<R: Precision>(field: &[R], [width, height]: [usize; 2]) -> Vec<R> {
    let tap = |t: usize, k: usize, size: usize| (t + k).saturating_sub(2).min(size - 1);
    let sum = |of: &dyn Fn(usize) -> R| {
        let weights = GAUSSIAN.iter().enumerate();
        weights.fold(R::zero(), |sum, (k, &weight)| sum + R::from_f64(weight) * of(k))
    };
    let across = |i: usize| -> R {
        let (x, y) = (i % width, i / width);
        sum(&|k| field[y * width + tap(x, k, width)])
    };
    let rows: Vec<R> = (0..field.len()).into_par_iter().map(across).collect();
    let down = |i: usize| -> R {
        let (x, y) = (i % width, i / width);
        sum(&|k| rows[tap(y, k, height) * width + x])
    };
    (0..field.len()).into_par_iter().map(down).collect()
}
