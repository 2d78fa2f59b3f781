//! `msm advise`: the cheapest technique, format, bias and map size that meets a tolerance on a scene.

use super::orders;
use super::race::{CONFIDENCE, Estimate, Race};
use super::records::OrderShare;
use super::scenery::{FreeParameters, SpeedPlan};
use super::settings::SpeedAccuracyExperiment;
use crate::error::EvaluationError;
use crate::experiment::kind::Settings;
use crate::fragments::LoadedScene;
use crate::run::{Progress, pool};
use serde::Serialize;
use std::path::Path;

/// The experiment whose candidates are raced unless a file is given.
pub(crate) const DEFAULT_CANDIDATES: &str = include_str!("../../../../../experiments/speed-accuracy.toml");

/// What is asked.
#[derive(Clone)]
pub struct AdviceOptions<'a> {
    /// A procedural name, a scene file, or a stack of `msm render`.
    pub scene: &'a str,
    /// Views of the scene; empty for all.
    pub views: &'a [String],
    /// Largest mean of |G - F| that is accepted, in (0, 1).
    pub tolerance: f64,
    /// Largest share of what doing nothing errs by that is accepted, in (0, 1): a large ground in the light dilutes the
    /// mean of |G - F|, and does not dilute this.
    pub relative: f64,
    /// Side of the reference's map; without it the experiment's.
    pub size: Option<u32>,
    /// Seed of the shuffle.
    pub seed: Option<u64>,
    /// An experiment of kind `speed-accuracy` with other candidates.
    pub candidates: Option<&'a Path>,
    /// Candidates decided, of all.
    pub progress: Progress<'a>,
}

/// A technique with everything that has to be chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// Technique.
    pub technique: String,
    /// Number format.
    pub format: String,
    /// Affine transform of what is stored.
    pub transform: String,
    /// Moment bias; `None` for techniques without.
    pub alpha: Option<f64>,
    /// Depth bias in texel depths of the map.
    pub bias_texels: f64,
    /// Depth bias in slopes of the receiver.
    pub bias_slopes: f64,
    /// 0 for the lower bound, towards 1 for the upper.
    pub beta: f64,
    /// What shadows are divided by, subtracted from 1.
    pub leak_reduction: f64,
    /// Side of the shadow map in texels.
    pub size: u32,
    /// Texels of its filter kernel along a side.
    pub kernel_size: usize,
    /// Mean of |G - F| over the fragments seen.
    pub l1_error: f64,
    /// Lower end of its interval.
    pub l1_error_low: f64,
    /// Upper end.
    pub l1_error_high: f64,
    /// `l1_error` over what doing nothing errs by.
    pub relative_error: f64,
    /// Lower end of its interval; what doing nothing errs by is known of all fragments.
    pub relative_error_low: f64,
    /// Upper end.
    pub relative_error_high: f64,
    /// Fragments seen; with all of them the interval is a point.
    pub fragments: usize,
    /// Memory of a texel.
    pub bits_per_texel: usize,
    /// Memory of the filtered map.
    pub map_bytes: u64,
    /// Operations of decoding and shading a fragment.
    pub operations: f64,
    /// Modelled cost of a frame, 1 for the first candidate at the reference's size.
    pub cost: f64,
}

/// Calling every fragment lit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Nothing {
    /// What it errs by: the mean of F over all fragments.
    pub l1_error: f64,
    /// Share of the fragments with F > 0: the others are in the light over their whole kernel.
    pub shadowed_share: f64,
    /// Side of a texel of the reference's map in the scene's units, the largest of all views; `None` for a stack. Smaller
    /// things cast no shadow on it.
    pub texel_side: Option<f64>,
}

/// The answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Advice {
    /// The scene.
    pub scene: String,
    /// Its views that were looked at.
    pub views: Vec<String>,
    /// The tolerance.
    pub tolerance: f64,
    /// Largest accepted share of what doing nothing errs by.
    pub relative: f64,
    /// Doing nothing, for comparison: what is not clearly better is not recommended.
    pub nothing: Nothing,
    /// Side of the reference's map.
    pub reference_size: u32,
    /// Fragments of all views.
    pub fragments: usize,
    /// Probability that all intervals hold.
    pub confidence: f64,
    /// Combinations of technique, format, size and biases.
    pub candidates: usize,
    /// Share of the work of evaluating every technique, format and size on every fragment that was done.
    pub evaluated_share: f64,
    /// The cheapest that meets the tolerance and errs no more than the accepted share of doing nothing; `None` if none
    /// does, or if nothing is in shadow.
    pub recommendation: Option<Choice>,
    /// Of the cheaper ones, which do not meet both, the most accurate.
    pub next_cheaper: Option<Choice>,
    /// The cheapest that errs at least a tenth less, or if there is none the most accurate that errs less at all; without
    /// a recommendation the most accurate of all. `None`: of the costlier ones none erred less.
    pub next_better: Option<Choice>,
    /// Moments and surfaces that the kernels need.
    pub needs: Vec<OrderShare>,
}

/// Fragments that a technique in the answer has seen, at least.
const SHOWN_FRAGMENTS: usize = 1 << 16;

/// What is better errs at least a tenth less.
const BETTER: f64 = 0.9;

impl Advice {
    /// Races the candidates on the scene, on so many threads; without a number one per logical core.
    ///
    /// # Errors
    /// [`EvaluationError`] for a tolerance outside (0, 1), a scene or a file of candidates that cannot be read.
    pub fn seek_on(options: &AdviceOptions<'_>, threads: Option<usize>) -> Result<Self, EvaluationError> {
        let (_, pool) = pool(threads)?;
        pool.install(|| Self::seek(options))
    }

    fn seek(options: &AdviceOptions<'_>) -> Result<Self, EvaluationError> {
        let tolerance = options.tolerance;
        if !(tolerance > 0.0 && tolerance < 1.0) {
            return Err(EvaluationError::Value(format!("tolerance {tolerance} is not between 0 and 1")));
        }
        let relative = options.relative;
        if !(relative > 0.0 && relative < 1.0) {
            return Err(EvaluationError::Value(format!("relative {relative} is not between 0 and 1")));
        }
        let experiment = experiment(options)?;
        let plan = SpeedPlan::new(&experiment)?;
        let views = plan.scenery()?;
        let mut race = Race::new(&plan, &views);
        let all = race.fragments() * race.arms.len();
        let sides = views.iter().filter_map(|view| view.texel_side);
        let nothing = Nothing {
            l1_error: race.nothing(),
            shadowed_share: race.shadowed_share(),
            texel_side: sides.reduce(f64::max),
        };
        // Where nothing is in shadow, doing nothing is right, and there is nothing to be recommended.
        let is_lit = nothing.shadowed_share == 0.0;
        let winner = match is_lit {
            true => None,
            false => race.run(tolerance.min(relative * nothing.l1_error), options.progress)?,
        };
        let (recommendation, next_cheaper, next_better) = match winner {
            Some(winner) => {
                race.extend(winner, SHOWN_FRAGMENTS)?;
                let cheaper = least_error(&race, 0..winner);
                if let Some(cheaper) = cheaper {
                    race.extend(cheaper, SHOWN_FRAGMENTS)?;
                }
                let better = better_than(&mut race, winner)?;
                (Some(winner), cheaper, better)
            }
            None if is_lit => (None, None, None),
            None => (None, None, settled(&mut race, |race| least_error(race, 0..race.arms.len()))?),
        };
        let choice = |arm: Option<usize>| arm.map(|arm| choice(&plan, &race, arm, nothing.l1_error));
        let records: Vec<_> =
            views.iter().enumerate().map(|(number, view)| orders::needed(&plan, view, number)).collect();
        Ok(Self {
            scene: options.scene.to_owned(),
            views: views.iter().map(|view| view.view.clone()).collect(),
            tolerance,
            relative,
            nothing,
            reference_size: experiment.scenery.size,
            fragments: race.fragments(),
            confidence: CONFIDENCE,
            candidates: race.arms.iter().map(|arm| arm.variants.len()).sum(),
            evaluated_share: race.evaluations as f64 / all.max(1) as f64,
            recommendation: choice(recommendation),
            next_cheaper: choice(next_cheaper),
            next_better: choice(next_better),
            needs: experiment.order_shares(&records),
        })
    }
}

fn experiment(options: &AdviceOptions<'_>) -> Result<SpeedAccuracyExperiment, EvaluationError> {
    let mut experiment = SpeedAccuracyExperiment::of_candidates(options.candidates, options.seed)?;
    experiment.scenery.scenes = vec![options.scene.to_owned()];
    experiment.scenery.views = options.views.to_vec();
    let own = LoadedScene::own_size(options.scene)?;
    if let Some(size) = options.size.or(own) {
        experiment.scenery.size = size;
        experiment.divisors.retain(|divisor| size.is_multiple_of(*divisor));
    }
    experiment.check()?;
    Ok(experiment)
}

/// The cheapest of the costlier arms that errs at least a tenth less than this one, else the most accurate of those that
/// err less.
fn better_than(race: &mut Race<'_>, winner: usize) -> Result<Option<usize>, EvaluationError> {
    let error = race.best_variant(winner).1.error;
    let errs_less = |race: &Race<'_>, arm: usize, share: f64| race.best_variant(arm).1.error < share * error;
    let clearly =
        settled(race, |race| (winner + 1..race.arms.len()).find(|&arm| errs_less(race, arm, BETTER)))?;
    if clearly.is_some() {
        return Ok(clearly);
    }
    settled(race, |race| {
        least_error(race, winner + 1..race.arms.len()).filter(|&arm| errs_less(race, arm, 1.0))
    })
}

/// What `choose` names once it has seen enough of it: the choice may change as more is seen.
fn settled(
    race: &mut Race<'_>,
    choose: impl Fn(&Race<'_>) -> Option<usize>,
) -> Result<Option<usize>, EvaluationError> {
    let enough = SHOWN_FRAGMENTS.min(race.fragments());
    while let Some(arm) = choose(race) {
        if race.arms[arm].seen() >= enough {
            return Ok(Some(arm));
        }
        race.extend(arm, enough)?;
    }
    Ok(None)
}

fn least_error(race: &Race<'_>, arms: std::ops::Range<usize>) -> Option<usize> {
    let error = |arm: usize| race.best_variant(arm).1.error;
    arms.reduce(|a, b| if error(b) < error(a) { b } else { a })
}

/// An arm as it is told; `nothing` is what doing nothing errs by, above 0.
fn choice(plan: &SpeedPlan<'_>, race: &Race<'_>, arm: usize, nothing: f64) -> Choice {
    let (variant, estimate) = race.best_variant(arm);
    let Estimate { error, low, high, fragments } = estimate;
    let (candidate, divisor) = (race.arms[arm].candidate, race.arms[arm].divisor);
    let FreeParameters { alpha, bias, blend, .. } = race.arms[arm].variants[variant];
    let of = &plan.candidates[candidate];
    let size = plan.experiment.scenery.size / plan.experiment.divisors[divisor];
    let bits_per_texel = of.technique().bits_per_texel();
    Choice {
        technique: of.name.clone(),
        format: of.format.clone(),
        transform: plan.experiment.technique[candidate].method.transform().to_owned(),
        alpha,
        bias_texels: bias.texels,
        bias_slopes: bias.slopes,
        beta: blend.beta,
        leak_reduction: blend.leak_reduction,
        size,
        kernel_size: plan.kernels[divisor].size(),
        l1_error: error,
        l1_error_low: low,
        l1_error_high: high,
        relative_error: error / nothing,
        relative_error_low: low / nothing,
        relative_error_high: high / nothing,
        fragments,
        bits_per_texel,
        map_bytes: u64::from(size).pow(2) * bits_per_texel as u64 / 8,
        operations: of.operations,
        cost: race.arms[arm].cost / plan.unit_cost(),
    }
}
