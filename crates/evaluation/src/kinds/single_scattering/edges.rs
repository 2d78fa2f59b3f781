//! Rows at the edge of what prefix sums are for, made by hand: one depth, one texel, rays along the light, no extinction and
//! far too much, rows of 8192 texels.

use super::records::EdgeRecord;
use super::settings::ScatteringStability;
use crate::error::EvaluationError;
use crate::statistics::rounded;
use applications::Estimate;
use applications::scattering::{
    Blending, ExactPrefixes, LightAxes, LightMap, Medium, Prefiltered, Rectification, RectifiedMap,
    RectifiedTexel, SingleScattering, StoredPrefixes, ViewRay,
};
use moment_problem::MomentBound;
use random_stream::Random;
use shadow_filtering::{DepthMap, FilteringError, TechniqueSpec};
use std::f64::consts::{PI, TAU};

/// What is extreme.
struct Case {
    name: &'static str,
    columns: usize,
    /// Depths of the texels are drawn from so many.
    depths: usize,
    /// Bounds of pi - theta.
    flipped: [f64; 2],
    /// Optical depth of the row, seen across the light.
    optical_depth: f64,
    /// Part of the row that rays reach at most.
    reach: f64,
}

const CASES: [Case; 9] = [
    case("one depth", 256, 1, [0.6, 2.4], 1.0, 1.0),
    case("two depths", 256, 2, [0.6, 2.4], 1.0, 1.0),
    case("prefix of one texel", 256, 4, [0.6, 2.4], 1.0, 1.0 / 256.0),
    case("looking into the light", 256, 4, [0.0, 1e-3], 1.0, 1.0),
    case("looking along the light", 256, 4, [PI - 1e-3, PI], 1.0, 1.0),
    case("no extinction", 256, 4, [0.6, 2.4], 0.0, 1.0),
    case("extinction 1e6", 256, 4, [0.6, 2.4], 1e6, 1.0),
    case("8192 texels", 8192, 4, [0.6, 2.4], 1.0, 1.0),
    case("8192 texels, no extinction", 8192, 4, [0.6, 2.4], 0.0, 1.0),
];

const fn case(
    name: &'static str,
    columns: usize,
    depths: usize,
    flipped: [f64; 2],
    optical_depth: f64,
    reach: f64,
) -> Case {
    Case { name, columns, depths, flipped, optical_depth, reach }
}

/// Rays a case.
const RAYS: usize = 400;

/// Rows of the map: the least that there are.
const ROWS: usize = 3;

/// How far rays stay from the depths of texels, where an exact distribution jumps and no bound can follow.
const CLEAR: f64 = 0.02;

impl Case {
    fn map(&self, random: &mut Random) -> (RectifiedMap, Vec<f64>) {
        let values: Vec<f64> = (0..self.depths).map(|_| 0.1 + 0.8 * random.unit()).collect();
        let rectification = Rectification {
            camera: [0.0; 3],
            axes: LightAxes { x: [1.0, 0.0, 0.0], y: [0.0, 1.0, 0.0], light: [0.0, 0.0, 1.0] },
            size: [self.columns, ROWS],
            r_max: 1.0,
            phi_start: 0.0,
            phi_extent: TAU,
            flipped: self.flipped,
        };
        let texel = |_: usize| RectifiedTexel {
            depths: [values[random.below(values.len())]; 2],
            weights: [1.0, 0.0],
        };
        (RectifiedMap { rectification, texels: (0..self.columns * ROWS).map(texel).collect() }, values)
    }

    fn rays(&self, values: &[f64], random: &mut Random) -> Vec<ViewRay> {
        let ray = |stream: usize| {
            let depth = loop {
                let depth = random.unit();
                if values.iter().all(|value| (value - depth).abs() > CLEAR) {
                    break depth;
                }
            };
            let flipped = self.flipped[0] + depth * (self.flipped[1] - self.flipped[0]);
            let phi = TAU * random.unit();
            let direction = [flipped.sin() * phi.cos(), flipped.sin() * phi.sin(), -flipped.cos()];
            let length = self.reach * random.unit() / flipped.sin().max(1e-9);
            ViewRay { direction, length, noise: 0.0, stream: stream as u64 }
        };
        (0..RAYS).map(ray).collect()
    }
}

/// A row a case and bound: in double precision against the exact distribution, and single against double.
pub(super) fn records(
    stability: &ScatteringStability,
    seed: u64,
) -> Result<Vec<EdgeRecord>, EvaluationError> {
    let fail = |error: FilteringError| EvaluationError::Value(format!("stability: {error}"));
    let map = DepthMap::new(1, 1, vec![1.0]).map_err(fail)?;
    let mut records = Vec::new();
    for (number, case) in CASES.iter().enumerate() {
        let mut random = Random::substream(seed, number as u64, 1);
        let (rectified, values) = case.map(&mut random);
        let rays = case.rays(&values, &mut random);
        let medium = Medium::new(case.optical_depth, 1.0, 0.0);
        let view = SingleScattering {
            light: LightMap { map: &map, corner: [0.0; 2], texel: [1.0; 2], near: 0.0, range: 1.0 },
            axes: rectified.rectification.axes,
            medium: medium.map_err(|error| EvaluationError::Value(error.to_string()))?,
            camera: [0.0; 3],
        };
        // As for rays across the light; the errors of spacing are the same for all bounds.
        let spacing = vec![vec![1.0; ROWS]];
        let exact = ExactPrefixes::new(&rectified, spacing.clone());
        for &bound in &stability.bounds {
            records.push(judged(case, bound, (&rectified, &view, &spacing), &exact, &rays).map_err(fail)?);
        }
    }
    Ok(records)
}

fn judged(
    case: &Case,
    bound: MomentBound,
    (rectified, view, spacing): (&RectifiedMap, &SingleScattering<'_>, &[Vec<f64>]),
    exact: &ExactPrefixes<'_>,
    rays: &[ViewRay],
) -> Result<EdgeRecord, FilteringError> {
    let spec = TechniqueSpec { alpha: Some(bound.single_precision_bias()), ..TechniqueSpec::from(bound) };
    let technique = spec.build()?;
    let method = StoredPrefixes { technique: &technique, blending: Blending::Fixed(0.5), margin: 0.0 };
    let double = Prefiltered::<f64>::new(method, rectified, view, spacing)?;
    let single = Prefiltered::<f32>::new(method, rectified, view, spacing)?;
    let (mut sum, mut largest, mut changes, mut largest_change, mut failed) = (0.0, 0.0f64, 0.0, 0.0f64, 0);
    for ray in rays {
        let [a, b] = [double.estimate(view, ray)?, single.estimate(view, ray)?];
        let error = (a - exact.estimate(view, ray)?).abs();
        let change = (a - b).abs();
        if ![a, b].iter().all(|answer| (0.0..=1.0).contains(answer)) {
            failed += 1;
            continue;
        }
        sum += error;
        largest = largest.max(error);
        changes += change;
        largest_change = largest_change.max(change);
    }
    let count = (rays.len() - failed).max(1) as f64;
    Ok(EdgeRecord {
        case: case.name.to_owned(),
        bound: spec.bound.map_or("", |bound| bound.as_str()).to_owned(),
        alpha: bound.single_precision_bias(),
        rays: rays.len(),
        mean_error: rounded(sum / count),
        largest_error: rounded(largest),
        mean_change: rounded(changes / count),
        largest_change: rounded(largest_change),
        failed,
    })
}
