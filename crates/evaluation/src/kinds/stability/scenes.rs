//! Inputs as scenes produce them: kernels of shadow maps and the depths of fragments.

use super::input::Input;
use super::settings::StabilityExperiment;
use crate::error::EvaluationError;
use crate::fragments::{Lit, LoadedScene, ViewRecord, chosen};
use rayon::prelude::*;
use shadow_filtering::Receiver;

/// All sampled fragments of all views, with the views.
pub(crate) fn inputs(
    experiment: &StabilityExperiment,
) -> Result<(Vec<Input>, Vec<ViewRecord>), EvaluationError> {
    let (mut inputs, mut views) = (Vec::new(), Vec::new());
    let kernel = experiment.scenery.filter()?;
    for scene in &LoadedScene::load_all(&experiment.scenery.scenes, &experiment.scenery.views)? {
        for light in &scene.lights {
            let Lit { map, receivers, texel_depth, .. } =
                scene.lit(light, experiment.scenery.size, &kernel)?;
            let indices =
                chosen(receivers.len(), experiment.scenery.fragments, experiment.scenery.seed, views.len());
            let (bias, limit) = (experiment.bias, experiment.scenery.plane_limit);
            views.push(ViewRecord {
                scene: scene.label.to_owned(),
                view: light.name.clone(),
                fragments: receivers.len(),
                sampled: indices.len(),
                ..ViewRecord::default()
            });
            inputs.par_extend(indices.into_par_iter().map(|index| {
                let receiver: &Receiver = &receivers[index];
                let z = kernel.distribution(&map, receiver.x, receiver.y);
                let weights = z.weights().iter().map(|w| w.to_f64());
                let atoms = z.depths().iter().copied().zip(weights).collect();
                Input::new(atoms, bias.compared(receiver, texel_depth, limit))
            }));
        }
    }
    Ok((inputs, views))
}

/// The range of depths in the kernel, and the distance of z_f from the nearest of them.
pub(crate) fn knobs(input: &Input) -> (f64, f64) {
    let depths = || input.atoms.iter().map(|a| a.0);
    let range = depths().fold(f64::NEG_INFINITY, f64::max) - depths().fold(f64::INFINITY, f64::min);
    let nearest = depths().map(|z| (z - input.z_f).abs()).fold(f64::INFINITY, f64::min);
    (range, nearest)
}
