//! Timings on one thread, after all errors of the first view are known.

use super::plan::FilterablePlan;
use super::records::FilterableSample;
use super::view::View;
use crate::error::EvaluationError;
use crate::timing::alone;
use applications::{Estimate, ShadowMethod};
use std::hint::black_box;
use std::time::Instant;

/// Filter and shading times of every closed-form technique on a view.
pub(crate) fn time(plan: &FilterablePlan<'_>, view: &View) -> Result<Vec<FilterableSample>, EvaluationError> {
    alone(|| {
        let mut samples = Vec::new();
        let techniques = plan.experiment.technique.iter().zip(&plan.methods);
        for (settings, method) in techniques.filter(|(settings, _)| !settings.is_certified()) {
            for repetition in 0..plan.experiment.timing.repetitions {
                let mut push = |stage: &str, items: usize, begin: Instant| {
                    samples.push(FilterableSample {
                        technique: settings.name.clone(),
                        stage: stage.to_owned(),
                        items,
                        repetition,
                        time_ns: u64::try_from(begin.elapsed().as_nanos()).unwrap_or(u64::MAX),
                    });
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
