//! Closed forms against the certified linear program, on the very moments of real fragments.

use super::plan::FilterablePlan;
use super::records::AgreementRecord;
use super::view::View;
use crate::error::EvaluationError;
use crate::fragments::spread;
use moment_problem::Interval;
use rayon::prelude::*;
use shadow_filtering::{TechniqueSpec, encode, filter};

/// One row for each technique whose bound has a linear program on \[0, 1\]: Hausdorff 4 and trigonometric 4.
pub(crate) fn compare(
    plan: &FilterablePlan<'_>,
    view: &View,
) -> Result<Vec<AgreementRecord>, EvaluationError> {
    let mut records = Vec::new();
    let wanted = plan.experiment.agreement_fragments;
    for settings in plan.experiment.technique.iter().filter(|_| wanted > 0) {
        let Some(method) = &settings.method else { continue };
        let fail = |error| settings.failure(error);
        let Some(biased) = method.biased_moments().map_err(fail)? else { continue };
        if biased.bound().interval() == Interval::Real {
            continue;
        }
        let closed = method.build().map_err(fail)?;
        let basis = Some(biased.bound().basis_name().to_owned());
        let program = TechniqueSpec { basis, ..TechniqueSpec::default() }.build().map_err(fail)?;
        let filtered = filter(&encode::<f64>(&view.map, &closed).map_err(fail)?, &plan.kernel);
        let distances: Vec<Result<f64, String>> = spread(view.samples.len(), wanted)
            .into_par_iter()
            .map(|index| {
                let receiver = view.samples[index].receiver;
                let z = plan.hard_shadow(view, 0).compared(&receiver);
                let moments = filtered.texel(receiver.x, receiver.y);
                let solved = program.shade(&biased.biased(moments), z).map_err(|e| e.to_string())?;
                Ok((closed.bounds(moments, z).map_err(|e| e.to_string())?.lower - solved).abs())
            })
            .collect();
        let failures: Vec<&String> = distances.iter().filter_map(|result| result.as_ref().err()).collect();
        records.push(AgreementRecord {
            scene: view.scene.clone(),
            view: view.name.clone(),
            technique: settings.name.clone(),
            fragments: distances.len(),
            largest_disagreement: distances.iter().flatten().copied().fold(0.0, f64::max),
            failed: failures.len(),
            error: failures.first().map(|reason| (*reason).clone()).unwrap_or_default(),
        });
    }
    Ok(records)
}
