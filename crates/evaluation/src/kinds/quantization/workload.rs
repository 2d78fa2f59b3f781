//! Fragments of all views, each with F and the depth that techniques compare.

use super::records::QuantizationViewRecord;
use super::settings::QuantizationExperiment;
use crate::error::EvaluationError;
use crate::kinds::filterable::records::rounded;
use crate::kinds::filterable::view::{Lit, LoadedScene, chosen};
use rayon::prelude::*;
use shadow_filtering::{DepthMap, Kernel, Receiver};

/// A light view: its shadow map and its sampled fragments.
pub(crate) struct StoredView {
    pub(crate) map: DepthMap,
    pub(crate) receivers: Vec<Receiver>,
    /// Depth that techniques compare.
    pub(crate) depths: Vec<f64>,
    texel_depth: f64,
    scene: String,
    view: String,
    fragments: usize,
}

impl StoredView {
    /// All views of all scenes.
    pub(crate) fn all(experiment: &QuantizationExperiment) -> Result<Vec<Self>, EvaluationError> {
        let kernel =
            experiment.kernel.build().map_err(|error| EvaluationError::Value(format!("kernel: {error}")))?;
        let mut views = Vec::new();
        if experiment.technique.is_empty() {
            return Ok(views);
        }
        for scene in &LoadedScene::load_all(&experiment.scenes, &experiment.views)? {
            for light in &scene.lights {
                let Lit { map, receivers, texel_depth, .. } = scene.lit(light, experiment.size, &kernel)?;
                let fragments = receivers.len();
                let indices = chosen(fragments, experiment.fragments, experiment.seed, views.len());
                let receivers: Vec<Receiver> = indices.into_iter().map(|index| receivers[index]).collect();
                let (bias, limit) = (experiment.bias.technique, experiment.plane_limit);
                let compared = |r: &Receiver| (r.depth - bias.depth(r, texel_depth, limit)).clamp(0.0, 1.0);
                views.push(Self {
                    depths: receivers.iter().map(compared).collect(),
                    map,
                    receivers,
                    texel_depth,
                    scene: scene.label.to_owned(),
                    view: light.name.clone(),
                    fragments,
                });
            }
        }
        Ok(views)
    }

    /// F of all sampled fragments for one kernel.
    pub(crate) fn reference(&self, experiment: &QuantizationExperiment, kernel: &Kernel) -> Vec<f64> {
        let reference = experiment.reference();
        let of = |r: &Receiver| reference.intensity(&self.map, kernel, r, self.texel_depth);
        self.receivers.par_iter().map(of).collect()
    }

    /// PCF of all sampled fragments at the depth that techniques compare, without a receiver plane.
    pub(crate) fn plain(&self, kernel: &Kernel) -> Vec<f64> {
        let rows = self.receivers.par_iter().zip(&self.depths);
        rows.map(|(r, &z)| kernel.percentage_closer(&self.map, r.x, r.y, z)).collect()
    }

    /// The row of views.csv; `reference` is F of the samples.
    pub(crate) fn record(&self, reference: &[f64]) -> QuantizationViewRecord {
        QuantizationViewRecord {
            scene: self.scene.clone(),
            view: self.view.clone(),
            fragments: self.fragments,
            sampled: self.receivers.len(),
            mean_reference: rounded(reference.iter().sum::<f64>() / reference.len() as f64),
        }
    }
}
