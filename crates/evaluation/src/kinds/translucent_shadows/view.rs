//! A light view as methods see it, with the receivers that are judged.

use super::method::BlendOrder;
use super::records::TranslucentViewRecord;
use super::settings::TranslucentShadowsExperiment;
use crate::error::EvaluationError;
use crate::fragments::{LoadedScene, Source, TranslucentView, chosen};
use crate::statistics::rounded;
use applications::translucency::{LayeredMap, TranslucentShadow};
use scenes::{LightView, Scene};
use serde::{Deserialize, Serialize};
use shadow_filtering::{Kernel, Receiver};
use shadow_renderer::{LightFrame, ShadowMapStack, Spectrum};

/// What a receiver is grouped by.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub(super) struct Group {
    /// A translucent surface.
    pub(super) inside: bool,
    /// Translucent layers in front of it at its own texel, before the first opaque one.
    pub(super) layers: usize,
    /// Their mean opacity; 0 without any.
    pub(super) opacity: f64,
}

/// A receiver with its group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub(crate) receiver: Receiver,
    pub(super) group: Group,
}

/// A light view.
pub(crate) struct View {
    pub(crate) map: LayeredMap,
    pub(super) texel_depth: f64,
    /// Unknown for a stack.
    pub(super) frame: Option<LightFrame>,
    pub(crate) samples: Vec<Sample>,
    /// Centre and number of the triangle of each layer, where surfaces are translucent and known.
    unsorted: Option<Vec<f32>>,
    centres: Option<Vec<f32>>,
    entries: [usize; 2],
    layers: (f64, u32),
    /// Number of opaque and of translucent receivers.
    receivers: [usize; 2],
}

/// The surfaces of a stack.
pub(super) fn layered(stack: &ShadowMapStack) -> Result<LayeredMap, EvaluationError> {
    let layers = (0..stack.fragments()).map(|i| (f64::from(stack.depths[i]), f64::from(stack.opacity(i))));
    LayeredMap::new([stack.width as usize, stack.height as usize], stack.offsets.clone(), layers)
        .map_err(|error| EvaluationError::Value(error.to_string()))
}

impl View {
    /// Renders and samples. `number` selects the stream of random numbers.
    pub(crate) fn new(
        experiment: &TranslucentShadowsExperiment,
        kernel: &Kernel,
        (loaded, light): (&LoadedScene<'_>, &LightView),
        number: usize,
    ) -> Result<Self, EvaluationError> {
        let settings = &experiment.scenery;
        let TranslucentView { stack, triangles, texel_depth, frame } =
            loaded.translucent(light, settings.size, Spectrum::Luminance)?;
        let map = layered(&stack)?;
        let groups = receivers(&stack, kernel);
        let counts = [groups[0].len(), groups[1].len()];
        if counts == [0, 0] {
            let side = kernel.size();
            let reason = format!(
                "scene `{}`, view `{}`: no fragment has its {side}x{side} kernel inside a map of {}x{} texels",
                loaded.label, light.name, stack.width, stack.height
            );
            return Err(EvaluationError::key("kernel.size", reason));
        }
        let mut samples = Vec::new();
        for (class, receivers) in groups.into_iter().enumerate() {
            let places = chosen(receivers.len(), settings.fragments, settings.seed, 2 * number + class);
            samples.extend(places.into_iter().map(|place| sample(&map, receivers[place], class == 1)));
        }
        let scene = match &loaded.source {
            Source::Scene(scene) => Some(scene.as_ref()),
            Source::Stack(_) => None,
        };
        let known = !triangles.is_empty();
        let unsorted = known.then(|| triangles.iter().map(|&triangle| -(triangle as f32)).collect());
        let centres = scene.zip(frame.as_ref()).filter(|_| known);
        let centres = centres.map(|(scene, frame)| centre_depths(scene, frame, &triangles));
        let statistics = stack.layer_statistics();
        Ok(Self {
            map,
            texel_depth,
            frame,
            samples,
            unsorted,
            centres,
            entries: [stack.fragments(), stack.opacities.iter().filter(|&&opacity| opacity < 1.0).count()],
            layers: (statistics.mean, statistics.max),
            receivers: counts,
        })
    }

    /// The same view with other opacities, blended in the exact order.
    pub(super) fn with_map(&self, map: LayeredMap) -> Self {
        Self { map, frame: self.frame, samples: Vec::new(), unsorted: None, centres: None, ..*self }
    }

    /// What blending is ordered by; nothing for the exact order, and where all surfaces are opaque.
    ///
    /// # Errors
    /// The reason, for a stack whose triangles are unknown.
    pub(crate) fn ranks(&self, order: BlendOrder) -> Result<Option<&[f32]>, String> {
        let known = |ranks: &'_ Option<Vec<f32>>| ranks.is_some() || self.entries[1] == 0;
        let of = match order {
            BlendOrder::Exact => return Ok(None),
            BlendOrder::Unsorted => &self.unsorted,
            BlendOrder::Centre => &self.centres,
        };
        if known(of) {
            Ok(of.as_deref())
        } else {
            Err("a stack does not tell the triangles of its layers".into())
        }
    }

    pub(crate) fn shadow<'a>(
        &'a self,
        experiment: &TranslucentShadowsExperiment,
        kernel: &'a Kernel,
    ) -> TranslucentShadow<'a> {
        TranslucentShadow {
            map: &self.map,
            kernel,
            texel_depth: self.texel_depth,
            bias: experiment.bias,
            plane_limit: experiment.scenery.plane_limit,
        }
    }

    /// Whether light passes through anything.
    pub(crate) fn is_translucent(&self) -> bool {
        self.entries[1] > 0
    }

    /// Number of opaque and of translucent receivers, of which samples are drawn.
    pub(crate) fn counts(&self) -> [usize; 2] {
        self.receivers
    }

    /// Surfaces that are drawn into a texel on average: translucent ones and an opaque one.
    pub(crate) fn drawn(&self) -> f64 {
        let [width, height] = self.map.size();
        1.0 + self.entries[1] as f64 / (width * height) as f64
    }

    pub(super) fn record(&self, [scene, view]: [&str; 2], truths: &[f64]) -> TranslucentViewRecord {
        let count = truths.len().max(1) as f64;
        let partial = truths.iter().filter(|truth| (0.01..=0.99).contains(*truth)).count();
        TranslucentViewRecord {
            scene: scene.to_owned(),
            view: view.to_owned(),
            stack_entries: self.entries[0],
            translucent_entries: self.entries[1],
            mean_layers: rounded(self.layers.0),
            layers: self.layers.1,
            surfaces: self.receivers[0],
            inside: self.receivers[1],
            sampled: self.samples.len(),
            texel_depth: rounded(self.texel_depth),
            mean_truth: rounded(truths.iter().sum::<f64>() / count),
            partial: rounded(partial as f64 / count),
        }
    }
}

/// Opaque surfaces that face the light, and translucent surfaces of either side, whose kernel lies inside the map.
fn receivers(stack: &ShadowMapStack, kernel: &Kernel) -> [Vec<Receiver>; 2] {
    let (width, height) = (stack.width as usize, stack.height as usize);
    let mut groups = [Vec::new(), Vec::new()];
    for y in 0..height {
        for x in (0..width).filter(|&x| kernel.fits(width, height, x, y)) {
            for layer in stack.layers(x as u32, y as u32) {
                let inside = layer.opacity < 1.0;
                if inside || layer.light_facing {
                    let (depth, gradient) = (f64::from(layer.depth), layer.gradient.map(f64::from));
                    groups[usize::from(inside)].push(Receiver { x, y, depth, gradient });
                }
            }
        }
    }
    groups
}

fn sample(map: &LayeredMap, receiver: Receiver, inside: bool) -> Sample {
    let layers = map.layers(receiver.y * map.size()[0] + receiver.x);
    let in_front = layers
        .iter()
        .take_while(|layer| layer.depth() < receiver.depth && layer.opacity() < 1.0)
        .map(|layer| layer.opacity());
    let (count, sum) = in_front.fold((0, 0.0), |(count, sum), opacity| (count + 1, sum + opacity));
    let group = Group { inside, layers: count, opacity: sum / count.max(1) as f64 };
    Sample { receiver, group }
}

/// Depths of the centres of triangles.
fn centre_depths(scene: &Scene, frame: &LightFrame, triangles: &[u32]) -> Vec<f32> {
    let centre = |triangle: &[u32; 3]| {
        let corners = triangle.map(|i| scene.vertices[i as usize].position.map(f64::from));
        let middle = [0, 1, 2].map(|k| (corners[0][k] + corners[1][k] + corners[2][k]) / 3.0);
        frame.project(middle)[2] as f32
    };
    let centres: Vec<f32> = scene.triangles.iter().map(centre).collect();
    triangles.iter().map(|&triangle| centres[triangle as usize]).collect()
}
