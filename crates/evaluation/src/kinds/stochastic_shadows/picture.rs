//! Scenes from their cameras: the truth, then each technique, with magnified parts below, and grey maps of shadow - truth.

use super::method::Choice;
use super::records::StochasticPictureRecord;
use super::settings::{StochasticPicture, StochasticShadowsExperiment};
use super::shading::Traced;
use crate::error::EvaluationError;
use crate::kinds::filterable::map_name;
use crate::lit_frames::{Lit, Ready, Seen, Stage, largest_coordinate, middle_map};
use crate::pictures::{png, side_by_side, signed_grey};
use crate::run_directory::RecordedFile;
use crate::statistics::rounded;
use applications::soft_shadow::AreaTruth;
use image::{DynamicImage, GrayImage};
use rayon::prelude::*;

/// Rejects pictures of scenes or views that are not evaluated.
pub(super) fn check(
    experiment: &StochasticShadowsExperiment,
    stages: &[Stage],
) -> Result<(), EvaluationError> {
    for (i, picture) in experiment.picture.iter().enumerate() {
        let fail = |key: &str, reason: String| {
            EvaluationError::key(format!("picture[{i}].{key}"), format!("picture `{}`: {reason}", picture.id))
        };
        let stage = stages.iter().find(|stage| stage.label == picture.scene);
        let stage =
            stage.ok_or_else(|| fail("scene", format!("scene `{}` is not evaluated", picture.scene)))?;
        if experiment.view_of(stage, &picture.view)?.is_none() {
            return Err(fail("view", format!("view `{}` is not evaluated", picture.view)));
        }
    }
    Ok(())
}

/// All pictures with their error maps and pictures.csv.
pub(super) fn draw(
    experiment: &StochasticShadowsExperiment,
    stages: &[Stage],
    truth: &AreaTruth,
) -> Result<Vec<RecordedFile>, EvaluationError> {
    let (mut files, mut rows) = (Vec::new(), Vec::new());
    for (index, picture) in experiment.picture.iter().enumerate() {
        let Some(stage) = stages.iter().find(|stage| stage.label == picture.scene) else { continue };
        draw_one(experiment, (index, picture), stage, truth, (&mut files, &mut rows))?;
    }
    if !rows.is_empty() {
        files.push(RecordedFile::csv("pictures.csv", &rows)?);
    }
    Ok(files)
}

fn draw_one(
    experiment: &StochasticShadowsExperiment,
    (index, picture): (usize, &StochasticPicture),
    stage: &Stage,
    truth: &AreaTruth,
    (files, rows): (&mut Vec<RecordedFile>, &mut Vec<StochasticPictureRecord>),
) -> Result<(), EvaluationError> {
    let fail = |reason: String| EvaluationError::Value(format!("picture `{}`: {reason}", picture.id));
    let [width, height] = picture.output;
    let scenery = stage.on(false);
    let sight = experiment.sight(&scenery, picture.output, picture.zoom, 0)?;
    let view = experiment.view_of(stage, &picture.view)?.ok_or_else(|| fail("has no view".to_owned()))?;
    let light = experiment.light.iter().find(|light| light.name == picture.light);
    let light = light.ok_or_else(|| fail("has no light".to_owned()))?;
    let lit = experiment.lit_frame(&scenery, 0, (light.of(view)?, &sight))?;
    let whole = scenery.whole(0)?;
    let largest = largest_coordinate(&scenery.scene.at(0));
    let shadows = |shade: &(dyn Fn(&Seen) -> f64 + Sync)| -> Vec<Option<f64>> {
        lit.seen.par_iter().map(|seen| seen.as_ref().map(shade)).collect()
    };
    let shaded = |shadows: &[Option<f64>]| {
        // Surfaces that face away from the light are dark by their cosine.
        let visibility: Vec<f32> = shadows.iter().map(|shadow| 1.0 - shadow.unwrap_or(0.0) as f32).collect();
        sight.frame.shade(&lit.light.view, &visibility)
    };
    let occluded = |(pixel, seen): (usize, &Option<Seen>)| {
        let sample =
            experiment.sample(&lit, (whole.triangles(), largest), truth, seen.as_ref()?, pixel as u64);
        Some(sample.truth.fraction)
    };
    let known: Vec<Option<f64>> = lit.seen.par_iter().enumerate().map(occluded).collect();
    let techniques = experiment.named(&picture.techniques, &format!("picture[{index}].techniques"))?;
    // A stream of its own: pictures need no other map than these.
    let groups =
        lit.groups(&experiment.filtered(&techniques), (u64::MAX >> 2) - index as u64, &mut Traced::new())?;
    let map = middle_map(&scenery, &lit.light, 0)?;
    let lit_by = Lit { map: &map, light: &lit.light, truth, triangles: whole.triangles() };
    let mut columns = vec![shaded(&known)];
    for technique in techniques {
        let (of, bias) = (&experiment.technique[technique], experiment.bias(technique));
        let shadow = match of.choice() {
            Some(Choice::Stochastic(_)) => {
                let place = groups.iter().find_map(|group| {
                    let mut members = group.techniques();
                    members.find(|(_, index)| *index == technique).map(|(member, _)| (group, member))
                });
                let Some((group, member)) = place else { continue };
                shadows(&|seen| group.shadow(member, bias, seen).ok().flatten().unwrap_or(0.0))
            }
            Some(Choice::Anew(method)) => {
                let ready = Ready::new(method, &lit_by, experiment.scenery.seed);
                let ready = ready.map_err(|error| fail(format!("technique `{}`: {error}", of.name)))?;
                shadows(&|seen| ready.shadow(&lit_by, bias, seen, seen.position).unwrap_or(0.0))
            }
            None => continue,
        };
        columns.push(shaded(&shadow));
        let pairs = known.iter().zip(&shadow);
        let errors: Vec<Option<f64>> =
            pairs.map(|(truth, shadow)| truth.zip(*shadow).map(|(truth, shadow)| shadow - truth)).collect();
        let grey = GrayImage::from_fn(width, height, |x, y| {
            signed_grey(errors[(y * width + x) as usize].unwrap_or(0.0))
        });
        files.push(png(map_name(&picture.id, &picture.light, &of.name), grey.into())?);
        let magnitudes: Vec<f64> = errors.iter().flatten().map(|error| error.abs()).collect();
        rows.push(StochasticPictureRecord {
            picture: picture.id.clone(),
            technique: of.name.clone(),
            pixels: magnitudes.len(),
            l1_error: rounded(magnitudes.iter().sum::<f64>() / magnitudes.len().max(1) as f64),
        });
    }
    let all = side_by_side(&columns, picture.output, &picture.insets);
    files.push(png(format!("{}.png", picture.id), DynamicImage::from(all).to_rgb8().into())?);
    Ok(())
}
