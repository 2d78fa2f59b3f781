//! Timings on one thread of the first view's receivers.

use super::run::Plan;
use super::view::View;
use crate::error::EvaluationError;
use crate::timing::{TimedSample, alone};
use std::hint::black_box;
use std::time::Instant;

/// Technique after technique in each round, so that a machine that slows down slows all alike. What cannot be drawn in its
/// order was recorded with the errors.
pub(super) fn time(plan: &Plan<'_>, view: &View) -> Result<Vec<TimedSample>, EvaluationError> {
    let experiment = plan.experiment;
    let texels = view.map.size().into_iter().product();
    alone(|| {
        let shadow = view.shadow(experiment, &plan.kernel);
        let mut samples = Vec::new();
        for repetition in 0..experiment.timing.repetitions {
            for (technique, method) in experiment.technique.iter().zip(&plan.methods) {
                let Ok(ranks) = view.ranks(technique.order) else { continue };
                let begin = Instant::now();
                let Ok(prepared) = method.prepare(&view.map, &plan.kernel, ranks, experiment.scenery.seed)
                else {
                    continue;
                };
                samples.push(TimedSample::since(begin, &technique.name, "filter", texels, repetition));
                let begin = Instant::now();
                for sample in &view.samples {
                    let _ = black_box(prepared.unclamped(&shadow, &sample.receiver));
                }
                samples.push(TimedSample::since(
                    begin,
                    &technique.name,
                    "shade",
                    view.samples.len(),
                    repetition,
                ));
            }
        }
        Ok(samples)
    })
}
