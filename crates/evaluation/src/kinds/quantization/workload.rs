//! Fragments of all views, each with F and the depth that techniques compare.

use super::settings::QuantizationExperiment;
use crate::error::EvaluationError;
use crate::fragments::{Lit, LoadedScene, ViewRecord, chosen};
use crate::statistics::rounded;
use applications::{BiasSetting, HardShadow, truths};
use rayon::prelude::*;
use shadow_filtering::{DepthMap, Kernel, Receiver};

/// A light view: its shadow map and its sampled fragments.
pub(crate) struct StoredView {
    pub(crate) map: DepthMap,
    pub(crate) receivers: Vec<Receiver>,
    /// Depth that techniques compare.
    pub(crate) depths: Vec<f64>,
    texel_depth: f64,
    bias: BiasSetting,
    plane_limit: f64,
    scene: String,
    view: String,
    fragments: usize,
}

impl StoredView {
    /// All views of all scenes.
    pub(crate) fn all(experiment: &QuantizationExperiment) -> Result<Vec<Self>, EvaluationError> {
        let kernel = experiment.scenery.filter()?;
        let mut views = Vec::new();
        if experiment.technique.is_empty() {
            return Ok(views);
        }
        for scene in &LoadedScene::load_all(&experiment.scenery.scenes, &experiment.scenery.views)? {
            for light in &scene.lights {
                let Lit { map, receivers, texel_depth, .. } =
                    scene.lit(light, experiment.scenery.size, &kernel)?;
                let fragments = receivers.len();
                let indices =
                    chosen(fragments, experiment.scenery.fragments, experiment.scenery.seed, views.len());
                let receivers: Vec<Receiver> = indices.into_iter().map(|index| receivers[index]).collect();
                let mut view = Self {
                    map,
                    receivers,
                    depths: Vec::new(),
                    texel_depth,
                    bias: experiment.bias,
                    plane_limit: experiment.scenery.plane_limit,
                    scene: scene.label.to_owned(),
                    view: light.name.clone(),
                    fragments,
                };
                let application = view.hard_shadow(&kernel);
                view.depths = view.receivers.iter().map(|r| application.compared(r)).collect();
                views.push(view);
            }
        }
        Ok(views)
    }

    fn hard_shadow<'a>(&'a self, kernel: &'a Kernel) -> HardShadow<'a> {
        let Self { map, texel_depth, bias, plane_limit, .. } = self;
        HardShadow { map, kernel, texel_depth: *texel_depth, bias: *bias, plane_limit: *plane_limit }
    }

    /// F of all sampled fragments for one kernel.
    pub(crate) fn reference(&self, kernel: &Kernel) -> Vec<f64> {
        truths(&self.hard_shadow(kernel), &self.receivers)
    }

    /// PCF of all sampled fragments at the depth that techniques compare, without a receiver plane.
    pub(crate) fn plain(&self, kernel: &Kernel) -> Vec<f64> {
        let application = self.hard_shadow(kernel);
        self.receivers.par_iter().map(|receiver| application.bounded(receiver)).collect()
    }

    /// The row of views.csv; `reference` is F of the samples.
    pub(crate) fn record(&self, reference: &[f64]) -> ViewRecord {
        ViewRecord {
            scene: self.scene.clone(),
            view: self.view.clone(),
            fragments: self.fragments,
            sampled: self.receivers.len(),
            mean_reference: Some(rounded(reference.iter().sum::<f64>() / reference.len() as f64)),
            ..ViewRecord::default()
        }
    }
}
