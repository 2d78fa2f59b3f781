//! Timings on one thread, after everything else is known.

use super::run::SoftPlan;
use crate::error::EvaluationError;
use crate::timing::{TimedSample, rounds};
use applications::soft_shadow::SoftReceiver;
use std::hint::black_box;
use std::time::Instant;

/// What the first view's fragments cost under the last light that is meant for it, technique after technique in each round.
pub(super) fn time(plan: &SoftPlan<'_>) -> Result<Vec<TimedSample>, EvaluationError> {
    let experiment = plan.experiment;
    let light = plan.pairs()?.into_iter().filter(|pair| pair.0 == 0).map(|pair| pair.1).max();
    let lit = plan.lit(0, light.unwrap_or_default())?;
    let view = &plan.views[0];
    let receivers: Vec<SoftReceiver> =
        view.points[0].iter().map(|point| view.receiver(point, &experiment.bias[0])).collect();
    rounds(experiment.timing.repetitions, |push| {
        let begin = Instant::now();
        let rays: usize = receivers.iter().map(|receiver| lit.occluded(receiver).rays).sum();
        push("truth", "rays", rays, begin);
        for technique in &experiment.technique {
            let begin = Instant::now();
            // A table that cannot be made was recorded with the errors.
            let Ok(method) = technique.method.prepare(lit.map, &lit.penumbra) else { continue };
            if !technique.method.is_percentage_closer() {
                push(&technique.name, "sum", view.map.depths().len(), begin);
            }
            let begin = Instant::now();
            for receiver in &receivers {
                let _ = black_box(method.estimate(&lit, receiver));
            }
            push(&technique.name, "shade", receivers.len(), begin);
        }
        Ok(())
    })
}
