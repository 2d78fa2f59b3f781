//! How long the formats of a shadow buffer count: pixels of known shadow under Halton's points.

use super::records::CountRecord;
use super::settings::TemporalShadowsExperiment;
use crate::statistics::rounded;
use applications::samples::{HALTON_START, halton};
use applications::samples::{PoissonTaps, TapShape};
use applications::temporal::{FilterSource, FramePixel, Screen, ShadowBuffer, Start, TemporalMethod};

/// Distance of the pixels, and of the light from them: any will do.
const DISTANCE: f64 = 8.0;

/// Rows of counts.csv: pixel i of n sees an edge that hides the share (i + 1/2) / n of the light.
pub(super) fn counts(experiment: &TemporalShadowsExperiment) -> Vec<CountRecord> {
    let count = experiment.counting.pixels;
    let shares: Vec<f64> = (0..count).map(|i| (i as f64 + 0.5) / count as f64).collect();
    let last = experiment.counting.frames.iter().max().copied().unwrap_or_default();
    let taps = PoissonTaps::new(TapShape::Disc, 1, experiment.scenery.seed, 0);
    let screen = Screen { light_size: 1.0, pixels_per_unit: 1.0 };
    let mut rows = Vec::new();
    for (index, method) in experiment.gathering() {
        // A start by other means is right here: what is left is counting.
        let method = TemporalMethod { filter: FilterSource::Off, ..method.clone() };
        let start =
            |i: usize, _: bool| Start { fraction: shares[i], blocker: Some(DISTANCE / 2.0), moving: false };
        let mut buffer = ShadowBuffer::empty(count, 1);
        for frame in 0..last {
            let [x, _] = halton(HALTON_START + frame as u64);
            let pixels: Vec<Option<FramePixel>> = shares
                .iter()
                .enumerate()
                .map(|(i, &share)| {
                    let before = [i as f64 + 0.5, 0.5, DISTANCE];
                    let in_shadow = x < share;
                    Some(FramePixel {
                        depth: DISTANCE,
                        before,
                        followed: before,
                        receiver: DISTANCE,
                        in_shadow,
                        hidden: in_shadow,
                        map_distance: if in_shadow { DISTANCE / 2.0 } else { DISTANCE },
                        moving: false,
                    })
                })
                .collect();
            let (after, shaded) = method.frame(&buffer, &pixels, &screen, &taps, &start);
            buffer = after;
            if experiment.counting.frames.contains(&(frame + 1)) {
                let shaded = || shaded.iter().flatten();
                let errors: Vec<f64> =
                    shaded().zip(&shares).map(|(shaded, share)| (shaded.estimate - share).abs()).collect();
                let tests: f64 = shaded().map(|shaded| shaded.tests).sum();
                rows.push(CountRecord {
                    technique: experiment.technique[index].name.clone(),
                    format: method.format.name(),
                    frames: frame + 1,
                    tests: rounded(tests / count as f64),
                    mean_error: rounded(errors.iter().sum::<f64>() / count as f64),
                    largest_error: rounded(errors.into_iter().fold(0.0, f64::max)),
                });
            }
        }
    }
    rows
}
