//! How many layers can be blended in a format until moments are those of no distribution, and what moment bias mends that.

use super::records::BlendingRecord;
use super::settings::TranslucentStability;
use crate::error::EvaluationError;
use crate::kinds::single_scattering::stability::stored;
use crate::statistics::{rounded, rounded_to};
use applications::translucency::{Layer, LayerError, Rounding, blended_texel};
use moment_problem::MomentBound;
use quantization::{MomentMatrix, NumberFormat};
use random_stream::Random;
use rayon::prelude::*;
use shadow_filtering::TechniqueSpec;

/// How depths and opacities of a texel are made.
#[derive(Clone, Copy)]
enum Case {
    Spread,
    Coincident,
    EightBits,
}

const CASES: [Case; 3] = [Case::Spread, Case::Coincident, Case::EightBits];

impl Case {
    fn name(self) -> &'static str {
        match self {
            Self::Spread => "spread",
            Self::Coincident => "coincident",
            Self::EightBits => "eight bits",
        }
    }

    fn layers(self, opacity: f64, count: usize, random: &mut Random) -> Result<Vec<Layer>, LayerError> {
        let first = random.unit();
        let mut depths: Vec<f64> = match self {
            Self::Spread | Self::EightBits => (0..count).map(|_| random.unit()).collect(),
            Self::Coincident => vec![first; count],
        };
        depths.sort_by(f64::total_cmp);
        let opacity = match self {
            Self::Spread | Self::Coincident => opacity,
            Self::EightBits => (255.0 * opacity).round() / 255.0,
        };
        depths.into_iter().map(|depth| Layer::new(depth, opacity)).collect()
    }
}

/// One texel.
struct Trial {
    invalid_unbiased: bool,
    invalid: bool,
    /// Number of the first bias that is enough, or of how many there are.
    enough: usize,
    error: f64,
}

/// Rows of stability.csv, by bound, format, case, opacity and number of layers.
pub(super) fn records(
    setting: &TranslucentStability,
    seed: u64,
) -> Result<Vec<BlendingRecord>, EvaluationError> {
    let mut jobs = Vec::new();
    for &bound in &setting.bounds {
        for format in setting.number_formats() {
            for case in CASES {
                for &opacity in &setting.opacities {
                    jobs.extend(setting.layers.iter().map(|&layers| (bound, format, case, opacity, layers)));
                }
            }
        }
    }
    let of_job = |(number, &job): (usize, &Job)| record(setting, (seed, number as u64), job);
    jobs.par_iter().enumerate().map(of_job).collect()
}

type Job = (MomentBound, NumberFormat, Case, f64, usize);

fn record(
    setting: &TranslucentStability,
    (seed, stream): (u64, u64),
    (bound, format, case, opacity, layers): Job,
) -> Result<BlendingRecord, EvaluationError> {
    fn fail(error: impl std::fmt::Display) -> EvaluationError {
        EvaluationError::Value(format!("stability: {error}"))
    }
    let spec = stored(bound, format);
    let technique = spec.build().map_err(fail)?;
    let matrix = MomentMatrix::new(&bound.basis()).map_err(fail)?;
    let biased = |alpha: f64| {
        let spec = TechniqueSpec { alpha: Some(alpha), ..spec.clone() };
        spec.biased_moments().map_err(fail)
    };
    let alphas = setting.alphas.values();
    let biases = alphas.iter().map(|&alpha| biased(alpha)).collect::<Result<Vec<_>, _>>()?;
    let (none, usual) = (biased(0.0)?, biased(setting.alpha)?);
    let mut random = Random::substream(seed, stream, 21);
    let mut trials = Vec::with_capacity(setting.trials);
    for _ in 0..setting.trials {
        let texel = case.layers(opacity, layers, &mut random).map_err(fail)?;
        let found = blended_texel(&technique, &texel, None, Rounding::EachLayer);
        let exact = blended_texel(&technique, &texel, None, Rounding::Never);
        let error = found.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let mut b = vec![0.0; found.len()];
        technique.restore(&found, &mut b);
        let is_invalid = |moments: &Option<shadow_filtering::BiasedMoments>| {
            moments.as_ref().is_some_and(|moments| !matrix.is_valid(&moments.biased(&b)))
        };
        trials.push(Trial {
            invalid_unbiased: is_invalid(&none),
            invalid: is_invalid(&usual),
            enough: biases.iter().position(|moments| !is_invalid(moments)).unwrap_or(alphas.len()),
            error,
        });
    }
    let enough = trials.iter().map(|trial| trial.enough).max().unwrap_or_default();
    let most = trials.iter().map(|trial| trial.error).fold(0.0, f64::max);
    Ok(BlendingRecord {
        bound: spec.bound.map_or("", |bound| bound.as_str()).to_owned(),
        format: format.name(),
        transform: spec.transform().to_owned(),
        case: case.name().to_owned(),
        opacity: rounded(opacity),
        layers,
        trials: trials.len(),
        invalid_unbiased: trials.iter().filter(|trial| trial.invalid_unbiased).count(),
        invalid: trials.iter().filter(|trial| trial.invalid).count(),
        smallest_alpha: alphas.get(enough).copied(),
        largest_error: rounded_to(65535.0 * most, 1e3),
    })
}
