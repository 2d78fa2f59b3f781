//! Timings on one thread of the first view's receivers.

use super::run::Plan;
use super::view::View;
use crate::error::EvaluationError;
use crate::timing::{TimedSample, rounds};
use std::hint::black_box;
use std::time::Instant;

/// Technique after technique in each round, so that a machine that slows down slows all alike. What cannot be drawn in its
/// order was recorded with the errors.
pub(super) fn time(plan: &Plan<'_>, view: &View) -> Result<Vec<TimedSample>, EvaluationError> {
    let experiment = plan.experiment;
    let texels = view.map.size().into_iter().product();
    rounds(experiment.timing.repetitions, |push| {
        let shadow = view.shadow(experiment, &plan.kernel);
        for (technique, method) in experiment.technique.iter().zip(&plan.methods) {
            let Ok(ranks) = view.ranks(technique.order) else { continue };
            let begin = Instant::now();
            let Ok(prepared) = method.prepare(&view.map, &plan.kernel, ranks, experiment.scenery.seed) else {
                continue;
            };
            push(&technique.name, "filter", texels, begin);
            let begin = Instant::now();
            for sample in &view.samples {
                let _ = black_box(prepared.unclamped(&shadow, &sample.receiver));
            }
            push(&technique.name, "shade", view.samples.len(), begin);
        }
        Ok(())
    })
}
