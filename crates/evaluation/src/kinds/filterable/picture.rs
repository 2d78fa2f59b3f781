//! The picture of a single kernel: F and the techniques over all fragment depths (MSM15 Figure 2).

use super::plan::FilterablePlan;
use super::records::{CurveRecord, PictureRecord};
use super::settings::Picture;
use super::view::View;
use crate::error::EvaluationError;
use crate::fragments::LoadedScene;
use crate::statistics::rounded;
use applications::{Application, Estimate};
use serde::{Deserialize, Serialize};

/// Fragment depths from 0 to 1.
const DEPTHS: usize = 241;

#[derive(Clone, Default, Deserialize, Serialize)]
pub(crate) struct Tables {
    pub(crate) kernels: Vec<PictureRecord>,
    pub(crate) curves: Vec<CurveRecord>,
}

/// Rejects pictures of scenes or views that are not evaluated; an empty view means the first.
pub(crate) fn check(
    (index, picture): (usize, &Picture),
    scenes: &[LoadedScene<'_>],
) -> Result<(), EvaluationError> {
    let fits = |scene: &LoadedScene<'_>| {
        scene.label == picture.scene
            && (picture.view.is_empty() || scene.lights.iter().any(|light| light.name == picture.view))
    };
    if scenes.iter().any(fits) {
        return Ok(());
    }
    let (id, scene, view) = (&picture.id, &picture.scene, &picture.view);
    Err(EvaluationError::Key {
        key: format!("picture[{index}].view"),
        reason: format!("picture `{id}`: view `{view}` of scene `{scene}` is not evaluated"),
    })
}

/// Adds the pictures of a view to the tables.
pub(crate) fn draw(
    plan: &FilterablePlan<'_>,
    view: &View,
    tables: &mut Tables,
) -> Result<(), EvaluationError> {
    for (index, picture) in plan.experiment.picture.iter().enumerate() {
        let drawn = tables.kernels.iter().any(|record| record.picture == picture.id);
        let named = picture.view == view.name || (picture.view.is_empty() && !drawn);
        if picture.scene == view.scene && named {
            draw_one(plan, view, (index, picture), tables)?;
        }
    }
    Ok(())
}

fn draw_one(
    plan: &FilterablePlan<'_>,
    view: &View,
    (index, picture): (usize, &Picture),
    tables: &mut Tables,
) -> Result<(), EvaluationError> {
    let mut shaders = Vec::new();
    for name in &picture.techniques {
        let both = plan.experiment.technique.iter().zip(&plan.methods);
        for (settings, method) in both.filter(|(settings, _)| settings.name == *name) {
            let shader = method.prepare(&view.map, &plan.kernel).map_err(|error| settings.failure(error))?;
            shaders.push((name, shader));
        }
    }
    let (width, height) = (view.map.width(), view.map.height());
    let (x, y, receiver) = match picture.texel {
        Some([x, y]) => (x as usize, y as usize, None),
        None => {
            let error = |sample: &super::view::Sample| {
                let application = plan.hard_shadow(view, 0);
                let g = shaders[0].1.estimate(&application, &sample.receiver).unwrap_or_default();
                (g - application.truth(&sample.receiver)).abs()
            };
            let worst = view.samples.iter().max_by(|a, b| error(a).total_cmp(&error(b)));
            worst.map_or((0, 0, None), |sample| {
                let r = &sample.receiver;
                (r.x, r.y, Some(r.depth))
            })
        }
    };
    if !plan.kernel.fits(width, height, x, y) {
        let (id, size) = (&picture.id, plan.kernel.size());
        return Err(EvaluationError::Key {
            key: format!("picture[{index}].texel"),
            reason: format!(
                "picture `{id}`: texel = [{x}, {y}] has no {size}x{size} kernel inside the {width}x{height} map"
            ),
        });
    }
    let radius = plan.kernel.radius() as isize;
    tables.kernels.extend(plan.kernel.taps().map(|(i, j, weight)| PictureRecord {
        picture: picture.id.clone(),
        x_texel: x,
        y_texel: y,
        x_kernel: (i + radius) as usize,
        y_kernel: (j + radius) as usize,
        depth: f64::from(view.map.at(x as isize + i, y as isize + j)),
        weight,
        receiver,
    }));
    for (name, shader) in &shaders {
        for step in 0..DEPTHS {
            let z_f = step as f64 / (DEPTHS - 1) as f64;
            tables.curves.push(CurveRecord {
                picture: picture.id.clone(),
                technique: (*name).clone(),
                z_f: rounded(z_f),
                // A millionth of intensity is far below what a line shows.
                intensity: shader.shade(x, y, z_f).ok().map(|g| (g * 1e6).round() / 1e6 + 0.0),
            });
        }
    }
    Ok(())
}
