//! A light view of a scene, ready to be evaluated: shadow map and classified fragments.

use super::settings::FilterableExperiment;
use crate::error::EvaluationError;
use crate::fragments::{Lit, LoadedScene, ViewRecord, chosen};
use crate::statistics::rounded;
use rayon::prelude::*;
use scenes::LightView;
use shadow_filtering::{DepthMap, Kernel, Receiver, SurfaceCounter};
use shadow_renderer::ShadowMapStack;

/// Surfaces in a kernel: 1, 2, 3 and more.
pub(crate) const CLASSES: usize = 4;

/// One sampled fragment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub(crate) receiver: Receiver,
    /// Number of surfaces minus one, at most 3.
    pub(crate) class: usize,
}

pub(crate) struct View {
    pub(crate) scene: String,
    pub(crate) name: String,
    pub(crate) map: DepthMap,
    pub(crate) texel_depth: f64,
    pub(crate) samples: Vec<Sample>,
    /// All fragments.
    pub(crate) receivers: Vec<Receiver>,
    stack_entries: usize,
    layers: u32,
}

impl View {
    /// Renders and samples. `number` selects the stream of random numbers.
    pub(crate) fn prepare(
        experiment: &FilterableExperiment,
        kernel: &Kernel,
        scene: &LoadedScene<'_>,
        light: &LightView,
        number: usize,
    ) -> Result<Self, EvaluationError> {
        let Lit { stack, map, texel_depth, receivers, .. } =
            scene.lit(light, experiment.scenery.size, kernel)?;
        let stack = stack.as_ref();
        let mut view = Self {
            scene: scene.label.to_owned(),
            name: light.name.clone(),
            map,
            texel_depth,
            samples: Vec::new(),
            receivers,
            stack_entries: stack.fragments(),
            layers: stack.layer_statistics().max,
        };
        let chosen =
            chosen(view.receivers.len(), experiment.scenery.fragments, experiment.scenery.seed, number);
        let counter = SurfaceCounter::new(experiment.surface_gap, experiment.scenery.plane_limit)
            .map_err(|error| EvaluationError::Value(error.to_string()))?;
        let slopes = slopes(stack);
        view.samples = chosen
            .into_par_iter()
            .map(|index| {
                let receiver = view.receivers[index];
                let surfaces = counter.count(&view.map, &slopes, kernel, receiver.x, receiver.y);
                Sample { receiver, class: surfaces.clamp(1, CLASSES) - 1 }
            })
            .collect();
        Ok(view)
    }

    /// Whether all fragments are evaluated.
    pub(crate) fn is_complete(&self) -> bool {
        self.samples.len() == self.receivers.len()
    }

    /// The row of views.csv; `reference` is F of the samples.
    pub(crate) fn record(&self, reference: &[f64]) -> ViewRecord {
        let mut slopes: Vec<f64> = self.samples.iter().map(|s| s.receiver.slope(f64::INFINITY)).collect();
        slopes.sort_by(f64::total_cmp);
        ViewRecord {
            scene: self.scene.clone(),
            view: self.name.clone(),
            stack_entries: Some(self.stack_entries),
            layers: Some(self.layers),
            fragments: self.receivers.len(),
            sampled: self.samples.len(),
            texel_depth: Some(rounded(self.texel_depth)),
            median_slope: Some(rounded(slopes[slopes.len() / 2])),
            clamped_depths: Some(self.map.clamped()),
            mean_reference: Some(rounded(reference.iter().sum::<f64>() / reference.len() as f64)),
            active: None,
        }
    }
}

/// |g_x| + |g_y| of layer 0; empty texels are flat.
fn slopes(stack: &ShadowMapStack) -> Vec<f32> {
    let slope = |w: &[u32]| {
        let gradient = if w[0] < w[1] { stack.gradients[w[0] as usize] } else { [0.0; 2] };
        gradient[0].abs() + gradient[1].abs()
    };
    stack.offsets.windows(2).map(slope).collect()
}
