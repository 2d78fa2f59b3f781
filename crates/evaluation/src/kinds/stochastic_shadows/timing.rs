//! Timings on one thread, after everything else is known.

use super::method::Choice;
use super::settings::StochasticShadowsExperiment;
use super::shading::Traced;
use crate::error::EvaluationError;
use crate::lit_frames::{Lit, Ready, Seen, Stage, middle_map};
use crate::timing::{TimedSample, rounds};
use std::hint::black_box;
use std::time::Instant;

/// What the first scene costs under the first view's middle light.
pub(super) fn time(
    experiment: &StochasticShadowsExperiment,
    stage: &Stage,
) -> Result<Vec<TimedSample>, EvaluationError> {
    let scenery = stage.on(false);
    let sight = experiment.sight(&scenery, experiment.camera, experiment.zoom, 0)?;
    let Some(view) = experiment.view_of(stage, "")? else { return Ok(Vec::new()) };
    let light = &experiment.light[(experiment.light.len() - 1) / 2];
    let lit = experiment.lit_frame(&scenery, 0, (light.of(view)?, &sight))?;
    let map = middle_map(&scenery, &lit.light, 0)?;
    let (truth, whole) = (experiment.truth.nets(experiment.scenery.seed)?, scenery.whole(0)?);
    let lit_by = Lit { map: &map, light: &lit.light, truth: &truth, triangles: whole.triangles() };
    let pixels: Vec<&Seen> = lit.seen.iter().flatten().collect();
    rounds(experiment.timing.repetitions, |push| {
        let frame = &lit.light.frame;
        let begin = Instant::now();
        let focus = frame.near + 0.5 * frame.depth_range;
        let rays = lit.traced(&lit.light, focus, (experiment.scenery.seed, 0));
        push("", "rays", rays.samples().len(), begin);
        for (index, technique) in experiment.technique.iter().enumerate() {
            let bias = experiment.bias(index);
            match technique.choice() {
                Some(Choice::Stochastic(_)) => {
                    // Rays first, so that only the filter is timed.
                    let mut traced = Traced::new();
                    lit.groups(&experiment.filtered(&[index]), 0, &mut traced)?;
                    let begin = Instant::now();
                    let groups = lit.groups(&experiment.filtered(&[index]), 0, &mut traced)?;
                    let side = groups.first().map_or(0, |group| group.size() as usize);
                    push(&technique.name, "filter", side * side, begin);
                    let begin = Instant::now();
                    for group in &groups {
                        for seen in &pixels {
                            let _ = black_box(group.shadow(0, bias, seen));
                        }
                    }
                    push(&technique.name, "shade", pixels.len(), begin);
                }
                Some(Choice::Anew(method)) => {
                    let begin = Instant::now();
                    // What cannot be made was recorded with the errors.
                    let Ok(ready) = Ready::new(method, &lit_by, experiment.scenery.seed) else {
                        continue;
                    };
                    push(&technique.name, "filter", map.depths().len(), begin);
                    let begin = Instant::now();
                    for seen in &pixels {
                        let _ = black_box(ready.shadow(&lit_by, bias, seen, seen.position));
                    }
                    push(&technique.name, "shade", pixels.len(), begin);
                }
                None => {}
            }
        }
        Ok(())
    })
}
