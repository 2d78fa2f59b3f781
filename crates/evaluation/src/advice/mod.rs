//! `msm advise`: what a scene needs, and no more. For each application the cheapest technique, format, bias and map size that
//! meets a tolerance, raced on growing samples.

mod budget;
mod hard;
mod picture;
mod query;
mod race;
mod scattering;
mod shipping;
mod soft;
mod soft_method;
mod together;

pub use budget::{BANDWIDTH, Budget};
pub use hard::{Choice, Nothing};
pub use query::{Answer, Measured};
pub use scattering::ScatteringChoice;
pub use shipping::{BiasInView, DEFINITIONS, Definitions, Shipping};
pub use soft::SoftChoice;
pub use soft_method::NothingSoft;
pub use together::{Shared, Together};

use crate::error::EvaluationError;
use crate::experiment::kind::Settings;
use crate::experiment::{Experiment, Scale};
use crate::fragments::{Lighting, LoadedScene};
use crate::kinds::single_scattering::{MediumSetting, SingleScatteringExperiment};
use crate::kinds::soft_shadows::SoftShadowsExperiment;
use crate::kinds::speed_accuracy::{OrderShare, SceneView, SpeedAccuracyExperiment, SpeedPlan, needed};
use crate::run::{Progress, pool};
use crate::run_directory::RecordedFile;
use hard::HardCourse;
use query::{Wanted, answered};
use race::{CONFIDENCE, Course, Race, Standing};
use scattering::ScatteringCourse;
use serde::Serialize;
use shadow_filtering::{DepthBias, KernelSpec};
use soft::SoftCourse;
use std::path::Path;
use together::Member;

/// The experiments whose candidates are raced.
const SOFT_CANDIDATES: &str = include_str!("../../../../experiments/soft-shadows.toml");
const SCATTERING_CANDIDATES: &str = include_str!("../../../../experiments/single-scattering.toml");

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

/// What is told of soft shadows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SoftShadowAdvice {
    /// The views with their lights.
    pub views: Vec<String>,
    /// Receivers of all views.
    pub fragments: usize,
    /// Doing nothing, for comparison.
    pub nothing: NothingSoft,
    /// Mean standard error of the truths: errors against exact truths are at most so much less than those told, and not more.
    pub truth_standard_error: f64,
    /// The answer.
    #[serde(flatten)]
    pub answer: Answer<SoftChoice>,
}

/// What is told of single scattering.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScatteringAdvice {
    /// Extinction over half the scene's diagonal, albedo and anisotropy.
    pub medium: MediumSetting,
    /// Cameras under lights.
    pub views: Vec<String>,
    /// View rays of all cameras.
    pub rays: usize,
    /// What a medium without shadows errs by over the rays seen.
    pub nothing: f64,
    /// The answer.
    #[serde(flatten)]
    pub answer: Answer<ScatteringChoice>,
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
    /// The cheapest set of what is good enough for each application; `None` for hard shadows alone.
    pub together: Option<Together>,
    /// Moments and surfaces that the kernels need.
    pub needs: Vec<OrderShare>,
    /// What words mean.
    pub definitions: Definitions,
}

/// Hard shadows that are told have been seen so often, at least.
const SHOWN_FRAGMENTS: usize = 1 << 16;

/// Soft ones, whose truth takes many rays.
const SHOWN_RECEIVERS: usize = 1 << 14;

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
        let budget = &options.budget;
        let wanted = Wanted {
            tolerance: options.tolerance,
            relative: options.relative,
            most_accurate: budget.is_limited(),
            shown: SHOWN_FRAGMENTS,
        };
        let course = HardCourse::new(&plan, &views, budget)?;
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
            together: together::cheapest(&members, plan.unit_cost(), budget),
            needs: experiment.order_shares(&records),
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

/// What is told of soft shadows; `None` where no light has an extent.
fn soft_shadows(
    options: &AdviceOptions<'_>,
    loaded: &LoadedScene<'_>,
    (plan, views): (&SpeedPlan<'_>, &[SceneView]),
    (wanted, sets): (Wanted, &mut Vec<Vec<Member>>),
) -> Result<Option<SoftShadowAdvice>, EvaluationError> {
    let lit: Vec<&SceneView> = views.iter().filter(|view| view.light.light.has_extent()).collect();
    if lit.is_empty() {
        return Ok(None);
    }
    let path = Path::new("soft-shadows.toml");
    let read = Experiment::parse(path, SOFT_CANDIDATES, Scale::Quick, options.seed)?;
    let Some(experiment) = read.settings::<SoftShadowsExperiment>() else {
        return Err(EvaluationError::Value("soft-shadows.toml is not of kind \"soft-shadows\"".to_owned()));
    };
    let budget = &options.budget;
    let divisors = &plan.experiment.divisors;
    let course = SoftCourse::new((experiment, divisors), loaded, &lit, (plan.experiment.frame, budget))?;
    let nothing = course.nothing();
    let mut race = Race::new(course);
    let wanted = Wanted { shown: SHOWN_RECEIVERS, ..wanted };
    let arms = answered(&mut race, &wanted, nothing.l1_error_low, options.progress)?;
    let nothing = race.course.nothing();
    let least = nothing.l1_error.max(f64::MIN_POSITIVE);
    let unit = (plan.unit_cost(), budget);
    sets.push(members(&race, &arms, |arm| race.course.member(arm)));
    let answer = arms.map(|arm| soft::choice(&race, arm, least, unit));
    Ok(Some(SoftShadowAdvice {
        views: lit.iter().map(|view| format!("{}, {}", view.view, view.light.light)).collect(),
        fragments: lit.iter().map(|view| view.receivers.len()).sum(),
        nothing,
        truth_standard_error: race.course.truth_error(),
        answer,
    }))
}

/// What is told of single scattering; `None` without a medium.
fn scattering(
    options: &AdviceOptions<'_>,
    loaded: &LoadedScene<'_>,
    plan: &SpeedPlan<'_>,
    (wanted, sets): (Wanted, &mut Vec<Vec<Member>>),
) -> Result<Option<ScatteringAdvice>, EvaluationError> {
    let Some(medium) = options.medium else { return Ok(None) };
    let path = Path::new("single-scattering.toml");
    let read = Experiment::parse(path, SCATTERING_CANDIDATES, Scale::Quick, options.seed)?;
    let Some(mut experiment) = read.settings::<SingleScatteringExperiment>().cloned() else {
        let reason = "single-scattering.toml is not of kind \"single-scattering\"".to_owned();
        return Err(EvaluationError::Value(reason));
    };
    experiment.medium = medium;
    experiment.scenery.size = plan.experiment.scenery.size;
    // The moment map that is resampled may be that of hard shadows.
    experiment.scenery.kernel = plan.experiment.scenery.kernel;
    let budget = &options.budget;
    let parallel = loaded.under_parallel_light()?;
    experiment.on_rays(&parallel, |rays| {
        let course = ScatteringCourse::new(&experiment, rays, budget)?;
        let nothing = course.nothing();
        let mut race = Race::new(course);
        let arms = answered(&mut race, &wanted, nothing, options.progress)?;
        let unit = (plan.unit_cost(), budget);
        let least = nothing.max(f64::MIN_POSITIVE);
        sets.push(members(&race, &arms, |arm| race.course.member(arm)));
        let answer = arms.map(|arm| scattering::choice(&race, arm, least, unit));
        Ok(Some(ScatteringAdvice { medium, views: rays.names(), rays: rays.counts().sum(), nothing, answer }))
    })
}

/// The recommended candidate and the near ties that are good enough, too.
fn members<C: Course>(race: &Race<C>, arms: &Answer<usize>, member: impl Fn(usize) -> Member) -> Vec<Member> {
    let limit = arms.tolerance;
    let near = arms.near_ties.iter().filter(|&&arm| race.standing(arm, limit) == Standing::Meets);
    arms.recommendation.iter().chain(near).map(|&arm| member(arm)).collect()
}
