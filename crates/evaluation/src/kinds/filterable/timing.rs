//! Timings on one thread, after all errors of the first view are known.

use super::plan::FilterablePlan;
use super::view::View;
use crate::error::EvaluationError;
use crate::timing::{TimedSample, alone};
use applications::{Estimate, ShadowMethod};
use std::hint::black_box;
use std::time::Instant;

/// Filter and shading times of every closed-form technique on a view.
pub(crate) fn time(plan: &FilterablePlan<'_>, view: &View) -> Result<Vec<TimedSample>, EvaluationError> {
    alone(|| {
        let mut samples = Vec::new();
        let techniques = plan.experiment.technique.iter().zip(&plan.methods);
        for (settings, method) in techniques.filter(|(settings, _)| !settings.is_certified()) {
            for repetition in 0..plan.experiment.timing.repetitions {
                let mut push = |stage: &str, items: usize, begin: Instant| {
                    samples.push(TimedSample::since(begin, &settings.name, stage, items, repetition));
                };
                let begin = Instant::now();
                let shader = method.prepare(&view.map, &plan.kernel).map_err(|e| settings.failure(e))?;
                if matches!(method, ShadowMethod::Prefiltered(_)) {
                    push("filter", view.map.depths().len(), begin);
                }
                let application = plan.hard_shadow(view, 0);
                let begin = Instant::now();
                for sample in &view.samples {
                    // A failure was recorded with the errors.
                    let _ = black_box(shader.estimate(&application, &sample.receiver));
                }
                push("shade", view.samples.len(), begin);
            }
        }
        Ok(samples)
    })
}
