//! Applications beside hard shadows: what is told of each, and the race that finds it.

use super::query::{Answer, Wanted, answered};
use super::race::Race;
use super::scattering::{self, ScatteringChoice, ScatteringCourse};
use super::soft::{self, SoftChoice, SoftCourse};
use super::soft_method::NothingSoft;
use super::together::Member;
use super::translucent::{self, TranslucentChoice, TranslucentCourse};
use super::{AdviceOptions, members};
use crate::error::EvaluationError;
use crate::experiment::kind::Settings;
use crate::experiment::{Experiment, Scale};
use crate::fragments::LoadedScene;
use crate::kinds::single_scattering::{MediumSetting, SingleScatteringExperiment};
use crate::kinds::soft_shadows::SoftShadowsExperiment;
use crate::kinds::speed_accuracy::{SceneView, SpeedPlan};
use crate::kinds::translucent_shadows::{Plan, TranslucentShadowsExperiment, View};
use serde::Serialize;
use std::path::Path;

/// The experiments whose candidates are raced; links in the crate, so that a package of it holds them.
const SOFT_CANDIDATES: &str = include_str!("../../candidates/soft-shadows.toml");
const SCATTERING_CANDIDATES: &str = include_str!("../../candidates/single-scattering.toml");
const TRANSLUCENT_CANDIDATES: &str = include_str!("../../candidates/translucent-shadows.toml");

/// Receivers of each class and view that are drawn where light passes through something.
const DRAWN_RECEIVERS: usize = 1 << 14;

/// Soft shadows that are told have been seen so often, at least: their truth takes many rays.
const SHOWN_RECEIVERS: usize = 1 << 14;

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

/// What is told of translucent casters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TranslucentCasterAdvice {
    /// The views that have some.
    pub views: Vec<String>,
    /// Opaque receivers of these views, and translucent surfaces, which are receivers at their own depth.
    pub surfaces: usize,
    /// See `surfaces`.
    pub inside: usize,
    /// Of both, those that were drawn for the race, spread evenly over each view.
    pub drawn: usize,
    /// What doing nothing errs by over the receivers seen.
    pub nothing: f64,
    /// The answer.
    #[serde(flatten)]
    pub answer: Answer<TranslucentChoice>,
}

/// The experiment of a file of candidates, called by its kind.
fn candidates<T: Settings>(file: &str, options: &AdviceOptions<'_>) -> Result<T, EvaluationError> {
    let name = format!("{}.toml", T::KIND);
    let read = Experiment::parse(Path::new(&name), file, Scale::Quick, options.seed)?;
    read.settings::<T>()
        .cloned()
        .ok_or_else(|| EvaluationError::Value(format!("{name} is not of kind \"{}\"", T::KIND)))
}

/// What is told of soft shadows; `None` where no light has an extent.
pub(super) fn soft_shadows(
    options: &AdviceOptions<'_>,
    loaded: &LoadedScene<'_>,
    (plan, views): (&SpeedPlan<'_>, &[SceneView]),
    (wanted, sets): (Wanted, &mut Vec<Vec<Member>>),
) -> Result<Option<SoftShadowAdvice>, EvaluationError> {
    let lit: Vec<&SceneView> = views.iter().filter(|view| view.light.light.has_extent()).collect();
    if lit.is_empty() {
        return Ok(None);
    }
    let experiment: SoftShadowsExperiment = candidates(SOFT_CANDIDATES, options)?;
    let budget = &options.budget;
    let divisors = &plan.experiment.divisors;
    let course = SoftCourse::new((&experiment, divisors), loaded, &lit, (plan.experiment.frame, budget))?;
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
        views: lit.iter().map(|view| lit_view(view)).collect(),
        fragments: lit.iter().map(|view| view.receivers.len()).sum(),
        nothing,
        truth_standard_error: race.course.truth_error(),
        answer,
    }))
}

/// A view with its light, once.
fn lit_view(view: &SceneView) -> String {
    let light = view.light.light.to_string();
    if view.view.ends_with(&light) { view.view.clone() } else { format!("{}, {light}", view.view) }
}

/// What is told of single scattering; `None` without a medium.
pub(super) fn scattering(
    options: &AdviceOptions<'_>,
    loaded: &LoadedScene<'_>,
    plan: &SpeedPlan<'_>,
    (wanted, sets): (Wanted, &mut Vec<Vec<Member>>),
) -> Result<Option<ScatteringAdvice>, EvaluationError> {
    let Some(medium) = options.medium else { return Ok(None) };
    let mut experiment: SingleScatteringExperiment = candidates(SCATTERING_CANDIDATES, options)?;
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

/// What is told of translucent casters; `None` where all surfaces are opaque.
pub(super) fn translucent_casters(
    options: &AdviceOptions<'_>,
    loaded: &LoadedScene<'_>,
    (plan, views): (&SpeedPlan<'_>, &[SceneView]),
    (wanted, sets): (Wanted, &mut Vec<Vec<Member>>),
) -> Result<Option<TranslucentCasterAdvice>, EvaluationError> {
    if !loaded.may_be_translucent() {
        return Ok(None);
    }
    let mut experiment: TranslucentShadowsExperiment = candidates(TRANSLUCENT_CANDIDATES, options)?;
    experiment.scenery.size = plan.experiment.scenery.size;
    experiment.scenery.kernel = plan.experiment.scenery.kernel;
    experiment.scenery.fragments = DRAWN_RECEIVERS;
    let raced = experiment.advice.clone().unwrap_or_default();
    let techniques = experiment.named(&raced.techniques, "advice.techniques")?;
    let methods = Plan::new(&experiment)?;
    let mut lit = Vec::new();
    for (number, of) in views.iter().enumerate() {
        let view = View::new(&experiment, &methods.kernel, (loaded, &of.light), number)?;
        if view.is_translucent() {
            lit.push((of, view));
        }
    }
    if lit.is_empty() {
        return Ok(None);
    }
    let budget = &options.budget;
    let frame = plan.experiment.frame;
    let course = TranslucentCourse::new((&methods, &techniques, &raced.bias), &lit, (frame, budget))?;
    let nothing = course.nothing();
    let mut race = Race::new(course);
    let arms = answered(&mut race, &Wanted { shown: SHOWN_RECEIVERS, ..wanted }, nothing, options.progress)?;
    sets.push(members(&race, &arms, |arm| race.course.member(arm)));
    let least = nothing.max(f64::MIN_POSITIVE);
    let unit = (plan.unit_cost(), budget);
    let counts = |class: usize| lit.iter().map(|(_, view)| view.counts()[class]).sum();
    Ok(Some(TranslucentCasterAdvice {
        views: lit.iter().map(|(of, _)| of.view.clone()).collect(),
        surfaces: counts(0),
        inside: counts(1),
        drawn: lit.iter().map(|(_, view)| view.samples.len()).sum(),
        nothing,
        answer: arms.map(|arm| translucent::choice(&race, arm, least, unit)),
    }))
}
