//! Techniques on the fragments of views.

use super::agreement;
use super::maps;
use super::picture;
use super::plan::FilterablePlan;
use super::settings::FilterableExperiment;
use super::statistics::{Outcome, TOLERANCE};
use super::tables::{Evaluated, Finding, Tables};
use super::timing;
use super::view::{Sample, View};
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::fragments::{LoadedScene, reference_records, spread};
use crate::run::Recorded;
use crate::shards::{self, Gathered, Keep, Known, Pieces};
use applications::{Estimate, truths};
use rayon::prelude::*;
use scenes::LightView;
use shadow_filtering::{FilteringError, Receiver};
use std::sync::atomic::{AtomicUsize, Ordering};

impl FilterablePlan<'_> {
    fn evaluate(&self, technique: usize, view: &View, truth: &Truth) -> Result<Evaluated, EvaluationError> {
        let settings = &self.experiment.technique[technique];
        let method = &self.methods[technique];
        let shader = method.prepare(&view.map, &self.kernel).map_err(|error| settings.failure(error))?;
        let few = if settings.is_certified() { self.experiment.certified_fragments } else { usize::MAX };
        let chosen = spread(view.samples.len(), few);
        let one = |&index: &usize| -> Result<Vec<Outcome>, FilteringError> {
            let Sample { receiver, class } = view.samples[index];
            let violates = method.is_bound() && {
                let g = shader.shade(receiver.x, receiver.y, receiver.depth)?;
                g > truth.unbiased[index] + TOLERANCE
            };
            let under = |bias: usize| {
                let g = shader.estimate(&self.hard_shadow(view, bias), &receiver)?;
                Ok(Outcome {
                    error: (g - truth.reference[bias][index]) as f32,
                    reference: truth.reference[bias][index] as f32,
                    leak: (truth.plain[bias][index] - g) as f32,
                    violates,
                    class: class as u8,
                })
            };
            (0..self.experiment.bias.len()).map(under).collect()
        };
        let results: Vec<Result<Vec<Outcome>, FilteringError>> = chosen.par_iter().map(one).collect();
        let mut evaluated = Evaluated {
            by_bias: vec![Vec::new(); self.experiment.bias.len()],
            places: Vec::new(),
            error: String::new(),
        };
        let mut failed = 0;
        let mut reason = None;
        for (result, &place) in results.into_iter().zip(&chosen) {
            match result {
                Ok(outcomes) => {
                    evaluated.places.push(place);
                    evaluated.by_bias.iter_mut().zip(outcomes).for_each(|(list, outcome)| list.push(outcome));
                }
                Err(error) => {
                    failed += 1;
                    reason.get_or_insert(error);
                }
            }
        }
        if let Some(reason) = reason {
            evaluated.error = format!("{failed} of {} fragments failed: {reason}", chosen.len());
        }
        Ok(evaluated)
    }
}

/// Doing nothing on the samples of a view: G = 0, whatever the bias of techniques.
fn nothing(view: &View, truth: &Truth) -> Evaluated {
    let under = |(reference, plain): (&Vec<f64>, &Vec<f64>)| {
        let samples = view.samples.iter().zip(reference).zip(plain);
        let one = |((sample, &f), &plain): ((&Sample, &f64), &f64)| Outcome {
            error: -f as f32,
            reference: f as f32,
            leak: plain as f32,
            violates: false,
            class: sample.class as u8,
        };
        samples.map(one).collect()
    };
    Evaluated {
        by_bias: truth.reference.iter().zip(&truth.plain).map(under).collect(),
        places: (0..view.samples.len()).collect(),
        error: String::new(),
    }
}

/// PCF of the samples of a view: F by bias, F_Z at the techniques' depths by bias, F_Z at z_f.
struct Truth {
    reference: Vec<Vec<f64>>,
    plain: Vec<Vec<f64>>,
    unbiased: Vec<f64>,
}

fn receivers(view: &View) -> Vec<Receiver> {
    view.samples.iter().map(|sample| sample.receiver).collect()
}

impl Truth {
    fn new(plan: &FilterablePlan<'_>, view: &View) -> Self {
        let receivers = receivers(view);
        let biases = 0..plan.experiment.bias.len();
        let bounded = |bias: usize| {
            receivers.par_iter().map(|receiver| plan.hard_shadow(view, bias).bounded(receiver)).collect()
        };
        let plain = |r: &Receiver| plan.kernel.percentage_closer(&view.map, r.x, r.y, r.depth);
        Self {
            reference: biases.clone().map(|bias| truths(&plan.hard_shadow(view, bias), &receivers)).collect(),
            plain: biases.map(bounded).collect(),
            unbiased: receivers.par_iter().map(plain).collect(),
        }
    }
}

impl FilterablePlan<'_> {
    /// All techniques on one view. `number` counts views over all scenes.
    fn finding(
        &self,
        (scene, light): (&LoadedScene<'_>, &LightView),
        number: usize,
        progress: &dyn Fn(),
    ) -> Result<Finding, EvaluationError> {
        let view = View::prepare(self.experiment, &self.kernel, scene, light, number)?;
        let truth = Truth::new(self, &view);
        let mut evaluated = Vec::new();
        for technique in 0..self.methods.len() {
            evaluated.push(self.evaluate(technique, &view, &truth)?);
            progress();
        }
        evaluated.push(nothing(&view, &truth));
        let mut pictures = picture::Tables::default();
        let agreement = agreement::compare(self, &view)?;
        let files = maps::draw(self, &view)?;
        picture::draw(self, &view, &mut pictures)?;
        let samples = if number == 0 { timing::time(self, &view)? } else { Vec::new() };
        let own = self.experiment.bias[0].reference;
        let reference = reference_records((&view.scene, &view.name), own, |bias| {
            let mut application = self.hard_shadow(&view, 0);
            application.bias.reference = bias;
            truths(&application, &receivers(&view))
        });
        let (is_complete, view) = (view.is_complete(), view.record(&truth.reference[0]));
        Ok(Finding { view, reference, is_complete, evaluated, agreement, files, pictures, samples })
    }
}

impl FilterableExperiment {
    /// Evaluates view by view; the first one is timed as well.
    pub(super) fn evaluate(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        let plan = self.plan()?;
        let scenes = LoadedScene::load_all(&self.scenery.scenes, &self.scenery.views)?;
        for picture in self.picture.iter().enumerate() {
            picture::check(picture, &scenes)?;
        }
        let views: Vec<_> =
            scenes.iter().flat_map(|scene| scene.lights.iter().map(move |light| (scene, light))).collect();
        match shards::gather(context, &context.identity, &FilterablePieces { plan: &plan, views, context })? {
            Gathered::All(mut known) => {
                Tables::new((0..known.len()).filter_map(|number| known.remove(&number))).recorded(&plan)
            }
            Gathered::Part(recorded) => Ok(recorded),
        }
    }
}

/// The views as pieces of work.
struct FilterablePieces<'a> {
    plan: &'a FilterablePlan<'a>,
    views: Vec<(&'a LoadedScene<'a>, &'a LightView)>,
    context: &'a RunContext<'a>,
}

impl Pieces for FilterablePieces<'_> {
    type Key = usize;
    type Finding = Finding;

    fn name(&self) -> &'static str {
        "views"
    }

    fn keys(&self, _round: usize, _known: &Known<Self>) -> Vec<usize> {
        (0..self.views.len()).collect()
    }

    fn find(
        &self,
        keys: &[usize],
        (before, all): (usize, usize),
        keep: Keep<'_, Self>,
    ) -> Result<(), EvaluationError> {
        // Techniques are counted: a view takes long.
        let each = self.plan.methods.len();
        let done = AtomicUsize::new(before * each);
        let count = || (self.context.progress)(done.fetch_add(1, Ordering::Relaxed) + 1, all * each);
        for &number in keys {
            keep(vec![(number, self.plan.finding(self.views[number], number, &count)?)])?;
        }
        Ok(())
    }
}
