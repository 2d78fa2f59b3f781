//! What pictures do while the camera moves by parts of a pixel (BHS16 Figure 6): the truth changes little, and what changes
//! beside it flickers.

use super::records::AliasingRecord;
use super::run::Plan;
use super::shot::{Maps, Shot, Source};
use super::view::{LitScene, ScatteringScene};
use crate::error::EvaluationError;
use crate::fragments::spread;
use crate::statistics::{percentile, rounded};
use applications::scattering::ViewRay;
use applications::truths;
use rayon::prelude::*;
use scenes::Camera;
use scenes::vector::{minus, norm};
use shadow_renderer::ViewRays;

/// How a camera moves.
#[derive(Clone, Copy)]
enum Motion {
    /// To the side, as far as the point looked at moves by part of a pixel.
    Moved,
    /// About its eye, by the same part.
    Turned,
}

impl Motion {
    fn name(self) -> &'static str {
        match self {
            Self::Moved => "moved",
            Self::Turned => "turned",
        }
    }

    fn applied(self, camera: &Camera, size: [u32; 2], shift: f64) -> Result<Camera, EvaluationError> {
        let through =
            ViewRays::new(camera, size).map_err(|error| EvaluationError::Value(error.to_string()))?;
        let [a, b] = [0.0, 1.0].map(|x| through.through([x, 0.0]));
        let distance = norm(minus(camera.target.map(f64::from), camera.eye.map(f64::from)));
        let step = minus(b, a).map(|c| (c * distance * shift) as f32);
        let beside = |point: [f32; 3]| [0, 1, 2].map(|k| point[k] + step[k]);
        let eye = match self {
            Self::Moved => beside(camera.eye),
            Self::Turned => camera.eye,
        };
        Ok(Camera { eye, target: beside(camera.target), ..*camera })
    }
}

/// The lit shares of pixels by the truth and by each technique.
fn pictures(
    plan: &Plan<'_>,
    (shot, maps): (&Shot<'_>, &Maps),
    techniques: &[usize],
    pixels: &[usize],
) -> Result<Vec<Vec<f64>>, EvaluationError> {
    let experiment = plan.experiment;
    let rays: Vec<ViewRay> = pixels.iter().map(|&pixel| shot.rays[pixel]).collect();
    let mut all = vec![truths(&shot.view, &rays)];
    for &index in techniques {
        let settings = (experiment.guard_band, experiment.scenery.seed);
        let method = experiment.technique[index].method.prepare(
            shot,
            maps,
            plan.techniques[index].as_ref(),
            settings,
        )?;
        all.push(rays.par_iter().map(|ray| method.lit(&shot.view, ray)).collect());
    }
    Ok(all)
}

/// Rows of one view, seen from its first standpoint.
pub(super) fn records(
    plan: &Plan<'_>,
    scene: &ScatteringScene<'_>,
    (lit, source): (&LitScene<'_>, &Source<'_>),
    first: &Shot<'_>,
) -> Result<Vec<AliasingRecord>, EvaluationError> {
    let experiment = plan.experiment;
    let Some(setting) = &experiment.aliasing else { return Ok(Vec::new()) };
    let techniques = experiment.named(&setting.techniques, "aliasing.techniques")?;
    let pixels = spread(first.rays.len(), setting.rays);
    let maps = Maps::new(experiment, first, source, &techniques)?;
    let before = pictures(plan, (first, &maps), &techniques, &pixels)?;
    let mut records = Vec::new();
    for motion in [Motion::Moved, Motion::Turned] {
        for &shift in &setting.shifts {
            let camera = motion.applied(&first.camera, experiment.camera, shift)?;
            let shot = Shot::new(lit, camera, experiment.camera, (&plan.noise, 0))?;
            let maps = Maps::new(experiment, &shot, source, &techniques)?;
            let after = pictures(plan, (&shot, &maps), &techniques, &pixels)?;
            let changes = |picture: usize| -> Vec<f64> {
                after[picture].iter().zip(&before[picture]).map(|(after, before)| after - before).collect()
            };
            let mean =
                |values: &[f64]| values.iter().map(|v| v.abs()).sum::<f64>() / values.len().max(1) as f64;
            let truth = changes(0);
            for (place, &index) in techniques.iter().enumerate() {
                let own = changes(place + 1);
                let mut flicker: Vec<f64> =
                    own.iter().zip(&truth).map(|(own, truth)| (own - truth).abs()).collect();
                flicker.sort_by(f64::total_cmp);
                records.push(AliasingRecord {
                    scene: scene.label.to_owned(),
                    view: lit.light.name.clone(),
                    technique: experiment.technique[index].name.clone(),
                    motion: motion.name().to_owned(),
                    shift,
                    rays: pixels.len(),
                    truth_change: rounded(mean(&truth)),
                    change: rounded(mean(&own)),
                    flicker: rounded(mean(&flicker)),
                    flicker_p95: rounded(percentile(&flicker, 0.95)),
                });
            }
        }
    }
    Ok(records)
}
