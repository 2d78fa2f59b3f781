//! Light views of scenes with the shadow maps of all sizes, and their fragments.

use super::candidate::Candidate;
use super::settings::{Blend, SpeedAccuracyExperiment};
use crate::error::EvaluationError;
use crate::fragments::{LoadedScene, ReferenceRecord, chosen, reference_records};
use crate::statistics::Sums;
use applications::{Application, BiasSetting, HardShadow};
use rayon::prelude::*;
use scenes::LightView;
use shadow_filtering::{
    DepthBias, DepthMap, FilteringError, Kernel, KernelField, Position, Receiver, StoredField,
};
use shadow_renderer::LightFrame;

/// Filtering for one fragment alone costs as much as filtering this many times the kernel's size of texels of the whole
/// map: with four channels in 16 bits and a 9x9 kernel 5.4 us a fragment and 125 ns a texel were measured, one core.
const WHOLE_MAP: usize = 5;

/// What does not depend on scenes.
pub(crate) struct SpeedPlan<'a> {
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
    pub(crate) light: LightView,
    pub(crate) texel_depth: f64,
    /// From the world to the largest map; `None` for a stack, which does not tell.
    pub(crate) frame: Option<LightFrame>,
    pub(crate) layers: u32,
    /// All fragments, in texels of the largest map.
    pub(crate) receivers: Vec<Receiver>,
    /// The reference's map.
    pub(crate) map: DepthMap,
    /// By divisor; a stack from a file has only its own size.
    pub(crate) maps: Vec<Option<DepthMap>>,
}

impl<'a> SpeedPlan<'a> {
    pub(crate) fn new(experiment: &'a SpeedAccuracyExperiment) -> Result<Self, EvaluationError> {
        let value = |error: FilteringError| EvaluationError::Value(format!("kernel: {error}"));
        let candidates = experiment.technique.iter().enumerate();
        let divided = experiment.divisors.iter().map(|&divisor| {
            SpeedAccuracyExperiment::divided(experiment.scenery.kernel, divisor).build().map_err(value)
        });
        Ok(Self {
            experiment,
            candidates: candidates
                .map(|(i, setting)| {
                    let named = (setting.name.as_str(), &setting.method);
                    Candidate::new(named, experiment.scenery.seed, &format!("technique[{i}]"))
                })
                .collect::<Result<_, _>>()?,
            kernels: divided.collect::<Result<_, _>>()?,
            kernel: experiment.scenery.filter()?,
        })
    }

    /// All views of all scenes.
    pub(crate) fn scenery(&self) -> Result<Vec<SceneView>, EvaluationError> {
        let scenery = &self.experiment.scenery;
        self.views_of(&LoadedScene::load_all(&scenery.scenes, &scenery.views)?)
    }

    /// All views of scenes that are loaded.
    pub(crate) fn views_of(&self, scenes: &[LoadedScene<'_>]) -> Result<Vec<SceneView>, EvaluationError> {
        let experiment = self.experiment;
        let mut views = Vec::new();
        for scene in scenes {
            for light in &scene.lights {
                let lit = scene.lit(light, experiment.scenery.size, &self.kernel)?;
                let (width, height, size) =
                    (lit.map.width(), lit.map.height(), experiment.scenery.size as usize);
                if (width, height) != (size, size) {
                    let reason = format!(
                        "scene `{}`: its map has {width}x{height} texels, where size = {size} needs {size}x{size}",
                        scene.label
                    );
                    return Err(EvaluationError::Key { key: "size".to_owned(), reason });
                }
                let maps = experiment.divisors.iter().map(|&divisor| {
                    if divisor == 1 {
                        return Ok(Some(lit.map.clone()));
                    }
                    scene.divided_map(light, experiment.scenery.size, divisor)
                });
                views.push(SceneView {
                    scene: scene.label.to_owned(),
                    view: light.name.clone(),
                    light: light.clone(),
                    texel_depth: lit.texel_depth,
                    frame: lit.frame,
                    layers: lit.stack.layer_statistics().max,
                    maps: maps.collect::<Result<_, EvaluationError>>()?,
                    map: lit.map,
                    receivers: lit.receivers,
                });
            }
        }
        Ok(views)
    }

    /// The application on the reference's map, for techniques of some bias.
    pub(crate) fn hard_shadow<'b>(
        &'b self,
        map: &'b DepthMap,
        texel_depth: f64,
        technique: DepthBias,
    ) -> HardShadow<'b> {
        let bias = BiasSetting { reference: self.experiment.reference, technique };
        let plane_limit = self.experiment.scenery.plane_limit;
        HardShadow { map, kernel: &self.kernel, texel_depth, bias, plane_limit }
    }

    /// The rows of reference.csv of a view.
    pub(crate) fn reference_records(&self, view: &SceneView, fragments: &[u32]) -> Vec<ReferenceRecord> {
        reference_records((&view.scene, &view.view), self.experiment.reference, |bias| {
            let mut application = self.hard_shadow(&view.map, view.texel_depth, DepthBias::default());
            application.bias.reference = bias;
            let one = |&fragment: &u32| application.truth(&view.receivers[fragment as usize]);
            fragments.par_iter().map(one).collect()
        })
    }

    /// F of fragments of a view.
    pub(crate) fn reference(&self, view: &SceneView, fragments: &[u32]) -> Vec<f32> {
        let application = self.hard_shadow(&view.map, view.texel_depth, DepthBias::default());
        let one = |&fragment: &u32| application.truth(&view.receivers[fragment as usize]) as f32;
        fragments.par_iter().map(one).collect()
    }

    /// Variants of a candidate: moment biases times depth biases times blends, the blends in groups.
    pub(crate) fn variants(&self, candidate: usize) -> Vec<FreeParameters> {
        let technique = &self.candidates[candidate];
        let (biases, blends) = (&self.experiment.biases, &self.experiment.blends);
        let pairs = technique.biased.iter().enumerate();
        let pairs = pairs.flat_map(|(i, (alpha, _))| biases.iter().map(move |&bias| (i, *alpha, bias)));
        let usable = |blend: &&Blend| technique.has_upper() || blend.beta == 0.0;
        pairs
            .flat_map(|(index, alpha, bias)| {
                let all = blends.iter().filter(usable);
                all.map(move |&blend| FreeParameters { index, alpha, bias, blend })
            })
            .collect()
    }

    /// Sums of G - F over fragments of a view, for some variants of a candidate on a map.
    pub(crate) fn sums(
        &self,
        (candidate, divisor): (usize, usize),
        view: &SceneView,
        (fragments, truth): (&[u32], &[f32]),
        variants: &[FreeParameters],
    ) -> Result<Vec<Sums>, EvaluationError> {
        let mut sums = vec![Sums::default(); variants.len()];
        let Some(map) = &view.maps[divisor] else { return Ok(sums) };
        let kernel = &self.kernels[divisor];
        let candidate = &self.candidates[candidate];
        let technique = candidate.technique();
        let field: Box<dyn StoredField<f32, Region = Position>> =
            if fragments.len() * kernel.size() * WHOLE_MAP >= map.depths().len() {
                let fail = |error: FilteringError| {
                    EvaluationError::Value(format!("technique `{}`: {error}", candidate.name))
                };
                Box::new(technique.filtered(map, kernel).map_err(fail)?)
            } else {
                Box::new(KernelField::new(technique, map, kernel))
            };
        let scale = f64::from(self.experiment.divisors[divisor]);
        let limit = self.experiment.scenery.plane_limit;
        let of_chunk = |(fragments, truth): (&[u32], &[f32])| {
            let mut sums = vec![Sums::default(); variants.len()];
            let mut moments = vec![0.0; technique.channels()];
            for (&fragment, &truth) in fragments.iter().zip(truth) {
                let receiver = &view.receivers[fragment as usize];
                let centre = |texel: usize| (texel as f64 + 0.5) / scale;
                let at = Position { x: centre(receiver.x), y: centre(receiver.y) };
                // Kernels around points have an answer everywhere.
                let _ = technique.moments(field.as_ref(), at, &mut moments);
                let own = Receiver { gradient: receiver.gradient.map(|slope| slope * scale), ..*receiver };
                let mut last: Option<(&FreeParameters, [f32; 2])> = None;
                for (sums, variant) in sums.iter_mut().zip(variants) {
                    // The bounds of the variant before serve for all its blends.
                    let shared = last.filter(|(before, _)| before.shares_bounds(variant));
                    let pair = shared.map_or_else(
                        || {
                            let z = variant.bias.compared(&own, view.texel_depth * scale, limit);
                            candidate.bounds(&moments, variant.index, z as f32)
                        },
                        |(_, pair)| pair,
                    );
                    last = Some((variant, pair));
                    sums.push(variant.blend.apply(pair) - truth, truth);
                }
            }
            sums
        };
        // Sums of chunks of a fixed size are added in order: they do not depend on the number of threads.
        let chunks: Vec<Vec<Sums>> =
            fragments.par_chunks(CHUNK).zip(truth.par_chunks(CHUNK)).map(of_chunk).collect();
        for chunk in &chunks {
            sums.iter_mut().zip(chunk).for_each(|(sums, more)| sums.add(more));
        }
        Ok(sums)
    }
}

/// Fragments whose errors one task sums up.
const CHUNK: usize = 512;

/// The free parameters of a technique in a format.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FreeParameters {
    /// Place of the moment bias.
    pub(crate) index: usize,
    pub(crate) alpha: Option<f64>,
    pub(crate) bias: DepthBias,
    pub(crate) blend: Blend,
}

impl FreeParameters {
    fn shares_bounds(&self, other: &Self) -> bool {
        self.index == other.index && self.bias == other.bias
    }
}

impl SceneView {
    /// Side of a texel of the largest map in the scene's units.
    pub(crate) fn texel_side(&self) -> Option<f64> {
        self.frame.as_ref().map(|frame| {
            let [x, y] = frame.texels_per_unit;
            1.0 / x.min(y)
        })
    }

    /// A sample of fragments, spread evenly; 0 for all.
    pub(crate) fn sample(&self, wanted: usize, seed: u64, stream: usize) -> Vec<u32> {
        chosen(self.receivers.len(), wanted, seed, stream).into_iter().map(|index| index as u32).collect()
    }
}
