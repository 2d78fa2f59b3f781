//! What turning a part of a scene changes on what stands still: the shadow light field is modulated, which maps from one point
//! of the light cannot see (SSSM15 section 8.2, Figure 14).

use super::method::Choice;
use super::records::ModulationRecord;
use super::run::Sample;
use super::settings::StochasticShadowsExperiment;
use super::shading::Traced;
use crate::error::EvaluationError;
use crate::lit_frames::{Lit, Ready, Seen, Stage, largest_coordinate, middle_map};
use crate::statistics::rounded;
use applications::soft_shadow::AreaTruth;
use rayon::prelude::*;

/// Shadows of a frame, by technique, then pixel, and the truth.
struct Observed {
    truth: Vec<f64>,
    shadows: Vec<Vec<f64>>,
}

/// Rows of modulation.csv; nothing without the setting.
pub(super) fn measure(
    experiment: &StochasticShadowsExperiment,
    truth: &AreaTruth,
) -> Result<Option<Vec<ModulationRecord>>, EvaluationError> {
    let Some(setting) = &experiment.modulation else { return Ok(None) };
    let fail = |key: &str, reason: String| EvaluationError::key(format!("modulation.{key}"), reason);
    let stage = Stage::load(&setting.scene, 0).map_err(|error| fail("scene", error.to_string()))?;
    let scenery = stage.on(true);
    if !scenery.scene.has_motion() {
        return Err(fail("scene", format!("modulation: nothing moves in scene `{}`", setting.scene)));
    }
    let names = std::slice::from_ref(&setting.view);
    let view = stage.views(names).map_err(|error| fail("view", error.to_string()))?[0];
    let techniques = experiment.named(&setting.techniques, "modulation.techniques")?;
    let sights = setting.frames.map(|frame| experiment.sight(&scenery, experiment.camera, 1.0, frame));
    let [first, second] = sights;
    let sights = [first?, second?];
    let mut rows = Vec::new();
    for light in &experiment.light {
        let observe = |i: usize,
                       pixels: Option<&[usize]>|
         -> Result<(Vec<Option<Seen>>, Option<Observed>), EvaluationError> {
            let lit = experiment.lit_frame(&scenery, setting.frames[i], (light.of(view)?, &sights[i]))?;
            let Some(pixels) = pixels else { return Ok((lit.seen, None)) };
            let whole = scenery.whole(setting.frames[i])?;
            let largest = largest_coordinate(&scenery.scene.at(setting.frames[i]));
            let sample = |&pixel: &usize| {
                let seen = lit.seen[pixel]?;
                Some(experiment.sample(&lit, (whole.triangles(), largest), truth, &seen, pixel as u64))
            };
            let samples: Vec<Sample> = pixels.par_iter().filter_map(sample).collect();
            let mut shadows: Vec<Vec<f64>> = vec![Vec::new(); techniques.len()];
            // The same points of the light in both frames, as nothing else should change.
            for group in lit.groups(&experiment.filtered(&techniques), u64::MAX >> 1, &mut Traced::new())? {
                for (member, technique) in group.techniques() {
                    let shade = |sample: &Sample| {
                        let shadow = group.shadow(member, experiment.bias(technique), &sample.seen);
                        shadow.ok().flatten().unwrap_or(0.0)
                    };
                    let Some(place) = techniques.iter().position(|&t| t == technique) else { continue };
                    shadows[place] = samples.par_iter().map(shade).collect();
                }
            }
            let map = middle_map(&scenery, &lit.light, setting.frames[i])?;
            let lit_by = Lit { map: &map, light: &lit.light, truth, triangles: whole.triangles() };
            for (place, &technique) in techniques.iter().enumerate() {
                let Some(Choice::Anew(method)) = experiment.technique[technique].choice() else { continue };
                let name = &experiment.technique[technique].name;
                let ready = Ready::new(method, &lit_by, experiment.scenery.seed)
                    .map_err(|error| EvaluationError::Value(format!("technique `{name}`: {error}")))?;
                let shade = |sample: &Sample| {
                    let seen = &sample.seen;
                    ready.shadow(&lit_by, experiment.bias(technique), seen, seen.position).unwrap_or(0.0)
                };
                shadows[place] = samples.par_iter().map(shade).collect();
            }
            let truth = samples.iter().map(|sample| sample.truth.fraction).collect();
            Ok((Vec::new(), Some(Observed { truth, shadows })))
        };
        // Pixels that show the same surface in both frames.
        let (before, after) = (observe(0, None)?.0, observe(1, None)?.0);
        let stands = |pixel: &usize| match (&before[*pixel], &after[*pixel]) {
            (Some(a), Some(b)) => !a.moves && !b.moves && a.position == b.position,
            _ => false,
        };
        let all: Vec<usize> = (0..before.len()).filter(stands).collect();
        let wanted = experiment.scenery.fragments;
        let indices = crate::fragments::chosen(all.len(), wanted, experiment.scenery.seed, 0);
        let pixels: Vec<usize> = indices.into_iter().map(|index| all[index]).collect();
        let (first, second) = (observe(0, Some(&pixels))?.1, observe(1, Some(&pixels))?.1);
        let (Some(first), Some(second)) = (first, second) else { continue };
        for (place, &technique) in techniques.iter().enumerate() {
            rows.push(row(
                [&setting.scene, &setting.view, &light.name, &experiment.technique[technique].name],
                (&first.truth, &second.truth),
                (&first.shadows[place], &second.shadows[place]),
            ));
        }
    }
    Ok(Some(rows))
}

fn row(
    [scene, view, light, technique]: [&String; 4],
    truths: (&[f64], &[f64]),
    shadows: (&[f64], &[f64]),
) -> ModulationRecord {
    let changes = |(a, b): (&[f64], &[f64])| a.iter().zip(b).map(|(a, b)| b - a).collect::<Vec<f64>>();
    let (truth, shadow) = (changes(truths), changes(shadows));
    let count = truth.len().max(1) as f64;
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / count;
    let error = |shadows: &[f64], truths: &[f64]| {
        mean(&mut shadows.iter().zip(truths).map(|(shadow, truth)| (shadow - truth).abs()))
    };
    ModulationRecord {
        scene: scene.clone(),
        view: view.clone(),
        light: light.clone(),
        technique: technique.clone(),
        receivers: truth.len(),
        truth_change: rounded(mean(&mut truth.iter().map(|change| change.abs()))),
        change: rounded(mean(&mut shadow.iter().map(|change| change.abs()))),
        change_error: rounded(error(&shadow, &truth)),
        correlation: rounded(correlation(&truth, &shadow)),
        l1_error: rounded(0.5 * (error(shadows.0, truths.0) + error(shadows.1, truths.1))),
    }
}

/// 0 where one of both does not change.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let count = a.len().max(1) as f64;
    let (mean_a, mean_b) = (a.iter().sum::<f64>() / count, b.iter().sum::<f64>() / count);
    let product: f64 = a.iter().zip(b).map(|(a, b)| (a - mean_a) * (b - mean_b)).sum();
    let square = |values: &[f64], mean: f64| values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
    let scale = (square(a, mean_a) * square(b, mean_b)).sqrt();
    if scale > 0.0 { product / scale } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_compared_with_their_sign() {
        let names = ["s", "v", "l", "t"].map(str::to_owned);
        let of =
            |shadows: (&[f64], &[f64])| row(names.each_ref(), (&[0.0, 0.5, 1.0], &[0.5, 0.5, 0.5]), shadows);
        let same = of((&[0.0, 0.5, 1.0], &[0.5, 0.5, 0.5]));
        assert_eq!((same.change_error, same.correlation, same.l1_error), (0.0, 1.0, 0.0));
        let none = of((&[0.5, 0.5, 0.5], &[0.5, 0.5, 0.5]));
        assert_eq!((none.change, none.correlation), (0.0, 0.0));
        assert!((none.truth_change - 1.0 / 3.0).abs() < 1e-8 && none.change_error == none.truth_change);
        let opposite = of((&[0.5, 0.5, 0.5], &[0.0, 0.5, 1.0]));
        assert_eq!(opposite.correlation, -1.0);
    }
}
