//! Timings on one thread, after everything else is known.

use super::run::Plan;
use crate::error::EvaluationError;
use crate::lit_frames::{Lit, PointMap, Ready, Sight, Stage, middle_map};
use crate::timing::{TimedSample, rounds};
use applications::samples::{HALTON_START, halton};
use applications::temporal::ShadowBuffer;
use std::hint::black_box;
use std::time::Instant;

/// What a frame of the first path costs under the first view's middle light: the second one, whose pixels have a history.
pub(super) fn time(plan: &Plan<'_>, stage: &Stage) -> Result<Vec<TimedSample>, EvaluationError> {
    let experiment = plan.experiment;
    let path = &experiment.path[0];
    let scenery = stage.on(path.moving);
    let lights = plan.lights(stage, &scenery)?;
    let (light, _) = &lights[(experiment.light.len() - 1) / 2];
    let sight = Sight::new(&experiment.window(), &scenery, &path.camera(experiment.zoom), 0)?;
    let map = middle_map(&scenery, light, 0)?;
    let whole = scenery.whole(0)?;
    rounds(experiment.timing.repetitions, |push| {
        let middle = PointMap::new(scenery.posed(0), light, [0.5; 2], Vec::new());
        let points = [0, 1].map(|frame| halton(HALTON_START + frame));
        let maps = points.map(|point| PointMap::new(scenery.posed(0), light, point, Vec::new()));
        let begin = Instant::now();
        let lit = maps
            .each_ref()
            .map(|map| plan.lit_pixels(&scenery, (&sight, &sight), (light, map, &middle), None));
        let items = lit[1].pixels.iter().flatten().count();
        push("", "map", 2 * items, begin);
        let screen = plan.screen(light, &sight);
        let [width, height] = sight.size();
        for (index, method) in experiment.gathering() {
            let mut buffer = ShadowBuffer::empty(width, height);
            for (frame, (lit, map)) in lit.iter().zip(&maps).enumerate() {
                let start =
                    |pixel: usize, centre: bool| lit.start(pixel, centre, (map, &middle), &plan.start_taps);
                let begin = Instant::now();
                let (after, shown) = method.frame(&buffer, &lit.pixels, &screen, &plan.filter_taps, &start);
                black_box(shown);
                buffer = after;
                if frame == 1 {
                    push(&experiment.technique[index].name, "frame", items, begin);
                }
            }
        }
        let lit_by = Lit { map: &map, light, truth: &plan.truth, triangles: whole.triangles() };
        for (index, technique) in experiment.technique.iter().enumerate() {
            // What cannot be made was recorded with the errors.
            let Some(method) = technique.choice.anew() else { continue };
            let Ok(ready) = Ready::new(method, &lit_by, experiment.scenery.seed) else { continue };
            let begin = Instant::now();
            for seen in lit[1].seen.iter().flatten() {
                let _ = black_box(ready.shadow(&lit_by, plan.bias(index), seen, seen.position));
            }
            push(&technique.name, "frame", items, begin);
        }
        Ok(())
    })
}
