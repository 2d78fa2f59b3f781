//! `msm advise`: what a scene needs, and no more. For each application the cheapest technique, format, bias and map size that
//! meets a tolerance, raced on growing samples.

mod applications;
mod budget;
mod costs;
mod hard;
mod picture;
mod query;
mod race;
mod scattering;
mod shipping;
mod soft;
mod soft_method;
mod together;
mod translucent;

pub use applications::{ScatteringAdvice, SoftShadowAdvice, TranslucentCasterAdvice};
pub use budget::{BANDWIDTH, Budget};
pub use costs::CostSource;
pub use hard::{Choice, Nothing};
pub use query::{Answer, Measured};
pub use scattering::ScatteringChoice;
pub use shipping::{BiasInView, DEFINITIONS, Definitions, Shipping};
pub use soft::SoftChoice;
pub use soft_method::NothingSoft;
pub use together::{Shared, Together};
pub use translucent::TranslucentChoice;

use crate::error::EvaluationError;
use crate::experiment::kind::Settings;
use crate::fragments::{Lighting, LoadedScene};
use crate::kinds::single_scattering::MediumSetting;
use crate::kinds::speed_accuracy::{OrderShare, SpeedAccuracyExperiment, SpeedPlan, needed};
use crate::run::{Progress, pool};
use crate::run_directory::RecordedFile;
use applications::{scattering, soft_shadows, translucent_casters};
use hard::HardCourse;
use query::{Wanted, answered};
use race::{CONFIDENCE, Course, Race, Standing};
use serde::Serialize;
use shadow_filtering::{DepthBias, KernelSpec};
use std::path::Path;
use together::Member;

/// What is asked.
#[derive(Clone)]
pub struct AdviceOptions<'a> {
    /// A procedural name, a scene file, or a stack of `msm render`.
    pub scene: &'a str,
    /// Its views and lights.
    pub lighting: Lighting,
    /// Largest mean of |G - F| that is accepted, in (0, 1); without it what suits the scene.
    pub tolerance: Option<f64>,
    /// Largest share of what doing nothing errs by that is accepted, in (0, 1): a large ground in the light dilutes the
    /// mean of |G - F|, and does not dilute this.
    pub relative: f64,
    /// What may be spent; with it and without a tolerance the most accurate is recommended.
    pub budget: Budget,
    /// Side of the reference's map; without it the experiment's.
    pub size: Option<u32>,
    /// Filter of the reference and, at its own size, of every technique.
    pub kernel: Option<KernelSpec>,
    /// What scatters light; without it nothing does.
    pub medium: Option<MediumSetting>,
    /// Seed of the shuffle.
    pub seed: Option<u64>,
    /// An experiment of kind `speed-accuracy` with other candidates.
    pub candidates: Option<&'a Path>,
    /// Whether frames are timed on this machine's graphics processor, for costs of hard shadows.
    pub gpu: bool,
    /// Whether pictures are drawn.
    pub pictures: bool,
    /// Candidates decided, of all.
    pub progress: Progress<'a>,
}

/// What F is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReferenceSetting {
    /// The kernel as `--kernel` takes it.
    pub kernel: String,
    /// Its bias, beside the receiver's plane.
    pub bias: DepthBias,
}

/// The answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Advice {
    /// The scene.
    pub scene: String,
    /// Its views that were looked at.
    pub views: Vec<String>,
    /// Doing nothing, for comparison: what is not clearly better is not recommended.
    pub nothing: Nothing,
    /// Side of the reference's map.
    pub reference_size: u32,
    /// What errors are against.
    pub reference: ReferenceSetting,
    /// Fragments of all views.
    pub fragments: usize,
    /// Probability that all intervals of an application hold.
    pub confidence: f64,
    /// What was not raced, and why.
    pub left_out: Vec<String>,
    /// Hard shadows.
    #[serde(flatten)]
    pub hard: Answer<Choice>,
    /// Soft shadows, where a light has an extent.
    pub soft_shadows: Option<SoftShadowAdvice>,
    /// Single scattering, where there is a medium.
    pub scattering: Option<ScatteringAdvice>,
    /// Translucent casters, where light passes through something.
    pub translucent_casters: Option<TranslucentCasterAdvice>,
    /// The cheapest set of what is good enough for each application; `None` for hard shadows alone.
    pub together: Option<Together>,
    /// Moments and surfaces that the kernels need.
    pub needs: Vec<OrderShare>,
    /// Where costs of hard shadows come from.
    pub costs: CostSource,
    /// What words mean.
    pub definitions: Definitions,
}

/// Hard shadows that are told have been seen so often, at least.
const SHOWN_FRAGMENTS: usize = 1 << 16;

impl Advice {
    /// Races the candidates on the scene, on so many threads; without a number one per logical core. With pictures, where they
    /// are wanted.
    ///
    /// # Errors
    /// [`EvaluationError`] for a tolerance outside (0, 1), a budget that nothing stays within, a scene, a light or a file of
    /// candidates that cannot be read.
    pub fn seek_on(
        options: &AdviceOptions<'_>,
        threads: Option<usize>,
    ) -> Result<(Self, Vec<RecordedFile>), EvaluationError> {
        let (_, pool) = pool(threads)?;
        pool.install(|| Self::seek(options))
    }

    fn seek(options: &AdviceOptions<'_>) -> Result<(Self, Vec<RecordedFile>), EvaluationError> {
        check(options)?;
        let (experiment, left_out) = experiment(options)?;
        let plan = SpeedPlan::new(&experiment)?;
        let loaded = LoadedScene::load_lit(options.scene, &options.lighting)?;
        let views = plan.views_of(std::slice::from_ref(&loaded))?;
        let (costs, measured) = CostSource::of(options, &plan, &loaded, &views);
        // Other costs are modelled, and take as long as those of the unit that was measured.
        let calibrated =
            AdviceOptions { budget: costs.calibrated(&options.budget, &plan), ..options.clone() };
        let options = &calibrated;
        let budget = &options.budget;
        let wanted = Wanted {
            tolerance: options.tolerance,
            relative: options.relative,
            most_accurate: budget.is_limited(),
            shown: SHOWN_FRAGMENTS,
        };
        let course = HardCourse::new((&plan, measured.as_ref()), &views, budget)?;
        let nothing = course.nothing();
        let mut race = Race::new(course);
        let arms = answered(&mut race, &wanted, nothing.l1_error, options.progress)?;
        let pictures = match (options.pictures, &arms.recommendation) {
            (true, Some(used)) => picture::draw(&loaded, &race, (*used, arms.next_cheaper))?,
            (true, None) | (false, _) => Vec::new(),
        };
        let mut members = vec![members(&race, &arms, |arm| race.course.member(arm, &race))];
        let hard = arms.map(|arm| hard::choice(&race, arm, nothing.l1_error, budget));
        drop(race);
        let soft_shadows = soft_shadows(options, &loaded, (&plan, &views), (wanted, &mut members))?;
        let scattering = scattering(options, &loaded, &plan, (wanted, &mut members))?;
        let translucent_casters =
            translucent_casters(options, &loaded, (&plan, &views), (wanted, &mut members))?;
        let records: Vec<_> =
            views.iter().enumerate().map(|(number, view)| needed(&plan, view, number)).collect();
        let advice = Self {
            scene: options.scene.to_owned(),
            views: views.iter().map(|view| view.view.clone()).collect(),
            nothing,
            reference_size: experiment.scenery.size,
            reference: ReferenceSetting {
                kernel: experiment.scenery.kernel.to_string(),
                bias: experiment.reference,
            },
            fragments: views.iter().map(|view| view.receivers.len()).sum(),
            confidence: CONFIDENCE,
            left_out,
            hard,
            soft_shadows,
            scattering,
            translucent_casters,
            together: together::cheapest(&members, plan.unit_cost(), budget),
            needs: experiment.order_shares(&records),
            costs,
            definitions: DEFINITIONS,
        };
        Ok((advice, pictures))
    }
}

fn check(options: &AdviceOptions<'_>) -> Result<(), EvaluationError> {
    let shares = [("tolerance", options.tolerance), ("relative", Some(options.relative))];
    for (what, value) in shares {
        if let Some(value) = value.filter(|value| !(*value > 0.0 && *value < 1.0)) {
            return Err(EvaluationError::Value(format!("{what} {value} is not between 0 and 1")));
        }
    }
    options.budget.check()
}

/// The experiment whose candidates are raced, with what it leaves out.
fn experiment(
    options: &AdviceOptions<'_>,
) -> Result<(SpeedAccuracyExperiment, Vec<String>), EvaluationError> {
    let mut experiment = SpeedAccuracyExperiment::of_candidates(options.candidates, options.seed)?;
    experiment.scenery.scenes = vec![options.scene.to_owned()];
    if let Some(kernel) = options.kernel {
        experiment.scenery.kernel = kernel;
    }
    let mut left_out = Vec::new();
    let own = LoadedScene::own_size(options.scene)?;
    let size = options.size.or(own).unwrap_or(experiment.scenery.size);
    experiment.scenery.size = size;
    let divides = |divisor: &u32| *divisor > 0 && size.is_multiple_of(*divisor);
    for divisor in experiment.divisors.iter().filter(|divisor| !divides(divisor)) {
        left_out.push(format!("maps of a {divisor}th of the side: {size} is not divisible by {divisor}"));
    }
    experiment.divisors.retain(divides);
    if own.is_some() && experiment.divisors.iter().any(|&divisor| divisor > 1) {
        left_out.push("smaller maps: a stack has only its own size, its scene is unknown".to_owned());
    }
    // Pictures of the experiment show other scenes.
    experiment.picture.clear();
    experiment.every_view = None;
    experiment.check()?;
    Ok((experiment, left_out))
}

/// The recommended candidate and the near ties that are good enough, too.
fn members<C: Course>(race: &Race<C>, arms: &Answer<usize>, member: impl Fn(usize) -> Member) -> Vec<Member> {
    let limit = arms.tolerance;
    let near = arms.near_ties.iter().filter(|&&arm| race.standing(arm, limit) == Standing::Meets);
    arms.recommendation.iter().chain(near).map(|&arm| member(arm)).collect()
}
