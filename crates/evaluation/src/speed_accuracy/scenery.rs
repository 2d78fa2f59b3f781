//! Light views of scenes with the shadow maps of all sizes, and their fragments.

use super::candidate::Candidate;
use super::settings::SpeedAccuracyExperiment;
use crate::error::EvaluationError;
use crate::filterable::view::{LoadedScene, chosen};
use rayon::prelude::*;
use shadow_filtering::{DepthBias, DepthMap, FilteringError, Kernel, Position, Receiver};

/// What does not depend on scenes.
pub(crate) struct Plan<'a> {
    pub(crate) experiment: &'a SpeedAccuracyExperiment,
    pub(crate) candidates: Vec<Candidate>,
    /// By divisor.
    pub(crate) kernels: Vec<Kernel>,
    /// The reference's.
    pub(crate) kernel: Kernel,
}

/// A light view.
pub(crate) struct SceneView {
    pub(crate) scene: String,
    pub(crate) view: String,
    pub(crate) texel_depth: f64,
    pub(crate) layers: u32,
    /// All fragments, in texels of the largest map.
    pub(crate) receivers: Vec<Receiver>,
    /// The reference's map.
    pub(crate) map: DepthMap,
    /// By divisor; a stack from a file has only its own size.
    pub(crate) maps: Vec<Option<DepthMap>>,
}

impl<'a> Plan<'a> {
    pub(crate) fn new(experiment: &'a SpeedAccuracyExperiment) -> Result<Self, EvaluationError> {
        let value = |error: FilteringError| EvaluationError::Value(format!("kernel: {error}"));
        let candidates = experiment.candidate.iter().enumerate();
        let divided = experiment.divisors.iter().map(|&divisor| {
            SpeedAccuracyExperiment::divided(experiment.kernel, divisor).build().map_err(value)
        });
        Ok(Self {
            experiment,
            candidates: candidates
                .map(|(i, setting)| Candidate::new(setting, experiment.seed, &format!("candidate[{i}]")))
                .collect::<Result<_, _>>()?,
            kernels: divided.collect::<Result<_, _>>()?,
            kernel: experiment.kernel.build().map_err(value)?,
        })
    }

    /// All views of all scenes.
    pub(crate) fn scenery(&self) -> Result<Vec<SceneView>, EvaluationError> {
        let experiment = self.experiment;
        let scenes = LoadedScene::load_all(&experiment.scenes, &experiment.views)?;
        let mut views = Vec::new();
        for scene in &scenes {
            for light in &scene.lights {
                let lit = scene.lit(light, experiment.size, &self.kernel)?;
                let maps = experiment.divisors.iter().map(|&divisor| match divisor {
                    1 => Ok(Some(lit.map.clone())),
                    _ => scene.divided_map(light, experiment.size, divisor),
                });
                views.push(SceneView {
                    scene: scene.label.to_owned(),
                    view: light.name.clone(),
                    texel_depth: lit.texel_depth,
                    layers: lit.stack.layer_statistics().max,
                    maps: maps.collect::<Result<_, EvaluationError>>()?,
                    map: lit.map,
                    receivers: lit.receivers,
                });
            }
        }
        Ok(views)
    }

    /// F of fragments of a view.
    pub(crate) fn reference(&self, view: &SceneView, fragments: &[u32]) -> Vec<f32> {
        let reference = self.experiment.reference_of();
        let one = |&fragment: &u32| {
            let receiver = &view.receivers[fragment as usize];
            reference.intensity(&view.map, &self.kernel, receiver, view.texel_depth) as f32
        };
        fragments.par_iter().map(one).collect()
    }

    /// Variants of a candidate: moment biases times depth biases.
    pub(crate) fn variants(&self, candidate: usize) -> usize {
        self.candidates[candidate].biased.len() * self.experiment.biases.len()
    }

    /// Moment bias and depth bias of a variant.
    pub(crate) fn variant(&self, candidate: usize, variant: usize) -> (Option<f64>, DepthBias) {
        let biases = &self.experiment.biases;
        (self.candidates[candidate].biased[variant / biases.len()].0, biases[variant % biases.len()])
    }

    /// G - F of fragments of a view, for some variants of a candidate on a map, fragment after fragment.
    pub(crate) fn errors(
        &self,
        (candidate, divisor): (usize, usize),
        view: &SceneView,
        (fragments, truth): (&[u32], &[f32]),
        variants: &[usize],
    ) -> Result<Vec<f32>, EvaluationError> {
        let Some(map) = &view.maps[divisor] else { return Ok(Vec::new()) };
        let (kernel, biases) = (&self.kernels[divisor], &self.experiment.biases);
        let technique = &self.candidates[candidate];
        // Filtering a texel of the whole map costs about a kernel's size less than filtering for one fragment alone.
        let whole = if fragments.len() * kernel.size() >= map.depths().len() {
            let fail = |error: FilteringError| {
                EvaluationError::Value(format!("candidate `{}`: {error}", technique.name))
            };
            Some(technique.stored.filtered(map, kernel).map_err(fail)?)
        } else {
            None
        };
        let scale = f64::from(self.experiment.divisors[divisor]);
        let limit = self.experiment.plane_limit;
        let mut errors = vec![0.0; fragments.len() * variants.len()];
        let items = errors.par_chunks_exact_mut(variants.len()).zip(fragments).zip(truth);
        items.for_each_init(
            || (vec![0.0; technique.channels()], vec![0.0; technique.channels()]),
            |(sample, moments), ((out, &fragment), &truth)| {
                let receiver = &view.receivers[fragment as usize];
                let centre = |texel: usize| (texel as f64 + 0.5) / scale;
                let at = Position { x: centre(receiver.x), y: centre(receiver.y) };
                match &whole {
                    Some(filtered) => technique.stored.sample(filtered, at, sample),
                    None => technique.stored.sample_unfiltered(map, kernel, at, sample),
                }
                technique.stored.decode(sample, moments);
                let own = Receiver { gradient: receiver.gradient.map(|slope| slope * scale), ..*receiver };
                for (out, &variant) in out.iter_mut().zip(variants) {
                    let bias = &biases[variant % biases.len()];
                    let z = receiver.depth - bias.depth(&own, view.texel_depth * scale, limit);
                    *out = technique.shade(moments, variant / biases.len(), z as f32) - truth;
                }
            },
        );
        Ok(errors)
    }
}

impl SceneView {
    /// A sample of fragments, spread evenly; 0 for all.
    pub(crate) fn sample(&self, wanted: usize, seed: u64, stream: usize) -> Vec<u32> {
        chosen(self.receivers.len(), wanted, seed, stream).into_iter().map(|index| index as u32).collect()
    }
}
