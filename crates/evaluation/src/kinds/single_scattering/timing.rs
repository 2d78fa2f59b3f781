//! Timings on one thread of the first camera.

use super::run::Plan;
use super::shot::{Maps, Shot, Source};
use super::view::ScatteringScene;
use crate::error::EvaluationError;
use crate::fragments::spread;
use crate::timing::{TimedSample, rounds};
use applications::Application;
use applications::scattering::ViewRay;
use std::hint::black_box;
use std::time::Instant;

/// Technique after technique in each round, so that a machine that slows down slows all alike.
pub(super) fn time(
    plan: &Plan<'_>,
    scene: &ScatteringScene<'_>,
    shot: &Shot<'_>,
    source: &Source<'_>,
) -> Result<Vec<TimedSample>, EvaluationError> {
    let experiment = plan.experiment;
    let texels = experiment.rectified[0] * experiment.rectified[1];
    let places = spread(shot.rays.len(), experiment.scenery.fragments.max(1));
    let rays: Vec<ViewRay> = places.iter().map(|&place| shot.rays[place]).collect();
    rounds(experiment.timing.repetitions, |push| {
        let begin = Instant::now();
        for ray in &rays {
            black_box(shot.view.truth(ray));
        }
        push("truth", "walk", rays.len(), begin);
        let begin = Instant::now();
        let sent: usize =
            rays.iter().map(|ray| shot.view.traced(&scene.triangles, &plan.nets, ray).rays).sum();
        push("truth", "rays", sent, begin);
        for (index, (technique, stored)) in experiment.technique.iter().zip(&plan.techniques).enumerate() {
            let marches = technique.method.steps.is_some();
            let begin = Instant::now();
            let maps = Maps::new(experiment, shot, source, &[index])?;
            if !marches {
                push(&technique.name, "resample", texels, begin);
            }
            let begin = Instant::now();
            let settings = (experiment.guard_band, experiment.scenery.seed);
            let method = technique.method.prepare(shot, &maps, stored.as_ref(), settings)?;
            if !marches && stored.is_some() {
                push(&technique.name, "prefix", texels, begin);
            }
            let begin = Instant::now();
            for ray in &rays {
                black_box(method.lit(&shot.view, ray));
            }
            push(&technique.name, if marches { "march" } else { "look up" }, rays.len(), begin);
        }
        Ok(())
    })
}
