//! View rays of a scene's cameras under its lights with everything that methods take, for whoever races them.

use super::cost;
use super::run::Plan;
use super::settings::SingleScatteringExperiment;
use super::shot::{Maps, Shot, Source};
use super::view::{LitScene, ScatteringScene};
use crate::error::EvaluationError;
use crate::fragments::LoadedScene;
use applications::scattering::ViewRay;
use applications::soft_shadow::BlueNoise;
use applications::truths;
use rayon::prelude::*;
use shadow_filtering::Technique;

/// A method that can be computed in a frame.
pub(crate) struct RayMethod {
    /// Place among the experiment's techniques.
    pub(crate) index: usize,
    pub(crate) name: String,
    /// In modelled bytes of a frame.
    pub(crate) cost: f64,
    /// Samples a ray; 0 for prefix sums.
    pub(crate) steps: usize,
    pub(crate) bits_per_texel: usize,
    pub(crate) map_bytes: u64,
}

/// Cameras under lights.
pub(crate) struct Rays<'a> {
    plan: &'a Plan<'a>,
    shots: &'a [(String, Shot<'a>, Maps)],
}

impl SingleScatteringExperiment {
    /// Renders a scene under the lights that it is loaded with, from the standpoints that are for it, and hands it on.
    pub(crate) fn on_rays<R>(
        &self,
        loaded: &LoadedScene<'_>,
        then: impl FnOnce(&Rays<'_>) -> Result<R, EvaluationError>,
    ) -> Result<R, EvaluationError> {
        let scene = ScatteringScene::new(self, 0, loaded)?;
        let source =
            self.source.build().map_err(|error| EvaluationError::Value(format!("source: {error}")))?;
        let plan = Plan {
            experiment: self,
            techniques: self.built()?,
            source,
            kernel: self.scenery.filter()?,
            noise: BlueNoise::new(self.scenery.seed),
            nets: self.truth.nets(self.scenery.seed)?,
        };
        let lit =
            |light| LitScene::new(loaded, &scene, light, (self.scenery.size, &plan.kernel, &plan.source));
        let lights: Vec<LitScene<'_>> = scene.lights.iter().map(lit).collect::<Result<_, _>>()?;
        let all: Vec<usize> = (0..self.technique.len()).collect();
        let mut shots = Vec::new();
        for lit in &lights {
            let source = Source { technique: &plan.source, stored: &lit.stored };
            for setting in self.standpoint.iter().filter(|setting| setting.is_in(scene.label)) {
                let camera = setting.camera(scene.scene, &scene.extent, lit.axes.light);
                let shot = Shot::new(lit, camera, self.camera, (&plan.noise, shots.len()))?;
                let maps = Maps::new(self, &shot, &source, &all)?;
                shots.push((format!("{}, camera {}", lit.light.name, setting.name), shot, maps));
            }
        }
        if shots.is_empty() {
            return Err(EvaluationError::key("standpoint", "no standpoint is for this scene"));
        }
        then(&Rays { plan: &plan, shots: &shots })
    }
}

impl Rays<'_> {
    /// Names of the cameras under their lights.
    pub(crate) fn names(&self) -> Vec<String> {
        self.shots.iter().map(|(name, ..)| name.clone()).collect()
    }

    /// Rays of each.
    pub(crate) fn counts(&self) -> impl Iterator<Item = usize> + '_ {
        self.shots.iter().map(|(_, shot, _)| shot.rays.len())
    }

    /// Methods that a frame can do, at their modelled cost.
    pub(crate) fn methods(&self) -> Vec<RayMethod> {
        let experiment = self.plan.experiment;
        let [columns, rows] = experiment.rectified.map(|side| side as u64);
        let method = |row: super::ScatteringCost| {
            let index = experiment.technique.iter().position(|technique| technique.name == row.technique)?;
            let method = &experiment.technique[index].method;
            let bits_per_texel = method.bits_per_texel(self.plan.techniques[index].as_ref());
            let side = u64::from(experiment.scenery.size);
            let texels = if method.steps.is_some() { side * side } else { columns * rows };
            Some(RayMethod {
                index,
                name: row.technique,
                cost: 1e6 * row.total,
                steps: row.steps,
                bits_per_texel,
                map_bytes: texels * bits_per_texel as u64 / 8,
            })
        };
        cost::records(self.plan).into_iter().filter_map(method).collect()
    }

    /// What the moment shadow map stores that is resampled with a filter.
    pub(crate) fn source(&self) -> &Technique {
        &self.plan.source
    }

    /// What a technique stores.
    fn technique(&self, index: usize) -> Option<&Technique> {
        self.plan.techniques[index].as_ref()
    }

    /// Lit shares of some rays of a camera.
    pub(crate) fn truths(&self, shot: usize, rays: &[usize]) -> Vec<f64> {
        let shot = &self.shots[shot].1;
        let rays: Vec<ViewRay> = rays.iter().map(|&ray| shot.rays[ray]).collect();
        truths(&shot.view, &rays)
    }

    /// What a method takes them for; NaN where it has no answer.
    pub(crate) fn estimates(
        &self,
        index: usize,
        shot: usize,
        rays: &[usize],
    ) -> Result<Vec<f64>, EvaluationError> {
        let experiment = self.plan.experiment;
        let (_, shot, maps) = &self.shots[shot];
        let settings = (experiment.guard_band, experiment.scenery.seed);
        let method = &experiment.technique[index].method;
        let prepared = method.prepare(shot, maps, self.technique(index), settings)?;
        Ok(rays.par_iter().map(|&ray| prepared.lit(&shot.view, &shot.rays[ray])).collect())
    }
}
