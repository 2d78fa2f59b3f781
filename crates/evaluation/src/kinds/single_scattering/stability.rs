//! Moment biases by bound and format: what rounding makes necessary, and what the bias itself costs.

use super::records::StoredBiasRecord;
use super::run::Plan;
use super::settings::ScatteringStability;
use super::shot::{Maps, Shot};
use crate::error::EvaluationError;
use crate::fragments::spread;
use crate::statistics::{percentile, rounded};
use applications::scattering::{Blending, Prefiltered, Spacing, StoredPrefixes, ViewRay};
use applications::truths;
use moment_problem::MomentBound;
use quantization::{MomentMatrix, NumberFormat};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use shadow_filtering::{FilteringError, Technique, TechniqueSpec};

/// One ray under one bound, format and bias.
#[derive(Clone, Copy, Deserialize, Serialize)]
struct Trial {
    /// Distance of the answer from the truth; NaN where it failed.
    error: f64,
    /// Distance from the answer of unrounded moments.
    change: f64,
    invalid: bool,
}

/// Trials by bound, format and bias, over all views.
#[derive(Clone, Default, Deserialize, Serialize)]
pub(super) struct Tally {
    trials: Vec<Vec<Trial>>,
}

/// What is stored of so many moments in a format.
pub(crate) fn stored(bound: MomentBound, format: NumberFormat) -> TechniqueSpec {
    let transform = match (format, bound) {
        (NumberFormat::F16 | NumberFormat::F32, _) => "identity",
        (_, MomentBound::Hamburger2) => "plain",
        (_, MomentBound::Hamburger4) => "GDC16 four moments",
        (_, MomentBound::Hamburger6) => "GDC16 six moments",
        (_, MomentBound::Hamburger8) => "ours, order 8",
        (_, MomentBound::Hausdorff4) => "MSM15 theta_4",
        (_, MomentBound::Trigonometric4) => "plain",
    };
    TechniqueSpec {
        format: Some(format),
        transform: Some(transform.to_owned()),
        ..TechniqueSpec::from(bound)
    }
}

/// Sines and cosines need one, as depths are clamped.
fn margin(bound: MomentBound) -> f64 {
    if bound.is_trigonometric() { 0.05 } else { 0.0 }
}

/// Every bound in every format.
fn variants(stability: &ScatteringStability) -> Vec<TechniqueSpec> {
    // Names were read when the file was.
    let formats: Vec<NumberFormat> =
        stability.formats.iter().filter_map(|format| format.parse().ok()).collect();
    stability
        .bounds
        .iter()
        .flat_map(|&bound| formats.iter().map(move |&format| stored(bound, format)))
        .collect()
}

impl Tally {
    /// Trials of later views behind those of earlier ones.
    pub(super) fn merge(&mut self, later: &Self) {
        self.trials.resize_with(self.trials.len().max(later.trials.len()), Vec::new);
        self.trials.iter_mut().zip(&later.trials).for_each(|(mine, theirs)| mine.extend(theirs));
    }

    /// Adds the rays of a view from its first standpoint.
    pub(super) fn add(
        &mut self,
        plan: &Plan<'_>,
        shot: &Shot<'_>,
        maps: &Maps,
    ) -> Result<(), EvaluationError> {
        let Some(stability) = &plan.experiment.stability else { return Ok(()) };
        let fail = |error: FilteringError| EvaluationError::Value(format!("stability: {error}"));
        let places = spread(shot.rays.len(), stability.rays);
        let rays: Vec<ViewRay> = places.iter().map(|&place| shot.rays[place]).collect();
        let truth = truths(&shot.view, &rays);
        let rectified = maps.get(false, plan.experiment.guard_band)?;
        let spacing = Spacing::default().inverse_sines(rectified, &shot.frustum, &shot.view, &shot.rays);
        let alphas = stability.alphas.values();
        let specs = variants(stability);
        self.trials.resize_with(specs.len() * alphas.len(), Vec::new);
        let blending = Blending::Fixed(stability.beta);
        for (number, spec) in specs.iter().enumerate() {
            let Some(bound) = spec.moment_bound() else { continue };
            let margin = margin(bound);
            let least =
                TechniqueSpec { alpha: Some(bound.single_precision_bias()), ..TechniqueSpec::from(bound) };
            let least = least.build().map_err(fail)?;
            let exact = Prefiltered::<f64>::new(
                StoredPrefixes { technique: &least, blending, margin },
                rectified,
                &shot.view,
                &spacing,
            )
            .map_err(fail)?;
            let exact = answers(&rays, |ray| exact.read_by(&least, &shot.view, ray)).map_err(fail)?;
            let technique = spec.build().map_err(fail)?;
            let method = Prefiltered::<f32>::new(
                StoredPrefixes { technique: &technique, blending, margin },
                rectified,
                &shot.view,
                &spacing,
            );
            let method = method.map_err(fail)?;
            let matrix = MomentMatrix::new(&bound.basis());
            let matrix = matrix.map_err(|error| EvaluationError::Value(format!("stability: {error}")))?;
            for (step, &alpha) in alphas.iter().enumerate() {
                let biased = TechniqueSpec { alpha: Some(alpha), ..spec.clone() };
                let moments = biased.biased_moments().map_err(fail)?;
                let reader: Technique = biased.draft().map_err(fail)?;
                let found = answers(&rays, |ray| method.read_by(&reader, &shot.view, ray)).map_err(fail)?;
                let trial = |i: usize| {
                    let b = method.values(&shot.view, &rays[i]).map(|(b, _)| b);
                    let double: Vec<f64> = b.iter().flatten().map(|&value| f64::from(value)).collect();
                    let invalid = moments.is_some_and(|moments| !matrix.is_valid(&moments.biased(&double)));
                    let is_share = (0.0..=1.0).contains(&found[i]);
                    let error = if is_share { (found[i] - truth[i]).abs() } else { f64::NAN };
                    Trial { error, change: (found[i] - exact[i]).abs(), invalid }
                };
                let trials: Vec<Trial> = (0..rays.len()).into_par_iter().map(trial).collect();
                self.trials[number * alphas.len() + step].extend(trials);
            }
        }
        Ok(())
    }

    /// The rows, by bound, format and bias.
    pub(super) fn records(&self, stability: &ScatteringStability) -> Vec<StoredBiasRecord> {
        let alphas = stability.alphas.values();
        let row = |(number, spec): (usize, &TechniqueSpec)| {
            let of_alpha = |step: usize| {
                let trials = &self.trials[number * alphas.len() + step];
                let answered: Vec<&Trial> = trials.iter().filter(|trial| trial.error.is_finite()).collect();
                let count = answered.len().max(1) as f64;
                let mut errors: Vec<f64> = answered.iter().map(|trial| trial.error).collect();
                errors.sort_by(f64::total_cmp);
                StoredBiasRecord {
                    bound: spec.bound.map_or("", |bound| bound.as_str()).to_owned(),
                    format: spec.format().name(),
                    transform: spec.transform().to_owned(),
                    alpha: alphas[step],
                    rays: trials.len(),
                    l1_error: rounded(errors.iter().sum::<f64>() / count),
                    p95: rounded(percentile(&errors, 0.95)),
                    change: rounded(answered.iter().map(|trial| trial.change).sum::<f64>() / count),
                    invalid: trials.iter().filter(|trial| trial.invalid).count(),
                    failed: trials.len() - answered.len(),
                }
            };
            (0..alphas.len()).map(of_alpha).collect::<Vec<_>>()
        };
        variants(stability).iter().enumerate().filter(|_| !self.trials.is_empty()).flat_map(row).collect()
    }
}

fn answers(
    rays: &[ViewRay],
    answer: impl Fn(&ViewRay) -> Result<f64, FilteringError> + Send + Sync,
) -> Result<Vec<f64>, FilteringError> {
    rays.par_iter().map(answer).collect()
}
