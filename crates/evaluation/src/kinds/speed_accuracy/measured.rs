//! Frame times on this machine's graphics processor in place of modelled costs, for one scene.

use super::frames::SAMPLES;
use super::scenery::{SceneView, SpeedPlan};
use crate::fragments::{LoadedScene, Source};
use crate::timing::GpuRecord;
use graphics_device::GraphicsDevice;
use shadow_renderer::{FrameRenderer, FrameSettings, Route, WHOLE_FRAME};
use std::collections::HashMap;
use std::time::Duration;

/// Frames of each candidate, of which the least time counts, after as many milliseconds of others.
const FRAMES: usize = 10;
const WARM_UP: Duration = Duration::from_millis(50);

/// Milliseconds of whole frames.
pub(crate) struct MeasuredFrames {
    pub(crate) adapter: String,
    /// By candidate and divisor.
    times: HashMap<(usize, usize), f64>,
}

impl SpeedPlan<'_> {
    /// Times a frame with every candidate on every map size: the first view from the scene's camera.
    ///
    /// # Errors
    /// Why there are no times: no graphics processor, a software driver unless it is allowed, a stack, a light in space.
    pub(crate) fn measured(
        &self,
        loaded: &LoadedScene<'_>,
        view: &SceneView,
        software: bool,
    ) -> Result<MeasuredFrames, String> {
        let adapter = &GraphicsDevice::shared().map_err(|error| error.to_string())?.name;
        let gpu = GpuRecord::of(adapter);
        if gpu.is_software() && !software {
            return Err(format!("{} is a software driver", gpu.adapter));
        }
        let Source::Scene(scene) = &loaded.source else { return Err("a stack has no triangles".to_owned()) };
        if view.light.light.front().is_some() {
            return Err("frames are drawn under directional lights only".to_owned());
        }
        let renderer =
            FrameRenderer::new(scene, view.light.direction).map_err(|error| format!("stopped: {error}"))?;
        let (experiment, frame) = (self.experiment, self.experiment.frame);
        let mut times = HashMap::new();
        for (divisor, kernel) in self.kernels.iter().enumerate() {
            for (index, candidate) in self.candidates.iter().enumerate() {
                let Some(shaders) = candidate.technique().passes(kernel, SAMPLES) else { continue };
                let settings = FrameSettings {
                    map_size: experiment.scenery.size / experiment.divisors[divisor],
                    width: frame.width,
                    height: frame.height,
                    samples: SAMPLES,
                    mip_maps: false,
                    bias: 0.002,
                    leak_reduction: 0.0,
                    route: Route::Compute,
                };
                // Others may still work, for example where this format cannot be filtered.
                let Ok(passes) = renderer.time(&shaders, &settings, WARM_UP, FRAMES) else { continue };
                let whole =
                    passes.iter().filter(|pass| pass.pass == WHOLE_FRAME).flat_map(|pass| &pass.times);
                if let Some(least) = whole.min() {
                    times.insert((index, divisor), 1e3 * least.as_secs_f64());
                }
            }
        }
        if !times.contains_key(&(0, 0)) {
            return Err("the unit of costs, the first candidate, could not be timed".to_owned());
        }
        Ok(MeasuredFrames { adapter: gpu.adapter, times })
    }
}

impl MeasuredFrames {
    /// Milliseconds of the unit of costs.
    pub(crate) fn unit(&self) -> f64 {
        self.times.get(&(0, 0)).copied().unwrap_or(1.0)
    }

    /// Those of a candidate over the unit's; `None` where there is no shader or the adapter cannot render it.
    pub(crate) fn relative(&self, candidate: usize, divisor: usize) -> Option<f64> {
        self.times.get(&(candidate, divisor)).map(|time| time / self.unit())
    }

    /// How many were timed.
    pub(crate) fn count(&self) -> usize {
        self.times.len()
    }

    /// What separates modelled from measured costs, both in units of the same candidate: the factor that two thirds of
    /// them stay within, and the largest.
    pub(crate) fn error_of_model(&self, plan: &SpeedPlan<'_>) -> [f64; 2] {
        let factor = |(&(candidate, divisor), time): (&(usize, usize), &f64)| {
            let modelled = plan.cost(candidate, divisor).total() / plan.unit_cost();
            let ratio = modelled / (time / self.unit()).max(f64::MIN_POSITIVE);
            ratio.max(1.0 / ratio)
        };
        let mut factors: Vec<f64> = self.times.iter().map(factor).collect();
        factors.sort_by(f64::total_cmp);
        let at = |place: usize| factors.get(place).copied().unwrap_or(1.0);
        [at(2 * factors.len() / 3), at(factors.len().saturating_sub(1))]
    }
}

#[cfg(test)]
mod tests {
    use super::super::{FrameSetting, SpeedAccuracyExperiment};
    use super::*;

    #[test]
    fn candidates_are_timed_in_units_of_the_first_one() {
        let mut experiment = SpeedAccuracyExperiment::of_candidates(None, None).unwrap();
        experiment.technique.truncate(2);
        experiment.scenery.size = 64;
        experiment.divisors = vec![1, 2];
        experiment.frame = FrameSetting { width: 64, height: 64 };
        let plan = SpeedPlan::new(&experiment).unwrap();
        let names = ["stairs", "oblique"].map(str::to_owned);
        let loaded = LoadedScene::load_all(&names[..1], &names[1..]).unwrap();
        let views = plan.views_of(&loaded).unwrap();
        match plan.measured(&loaded[0], &views[0], true) {
            Ok(measured) => {
                assert_eq!(measured.relative(0, 0), Some(1.0));
                assert!(measured.count() <= 2 * plan.candidates.len() && measured.unit() > 0.0);
                assert!(measured.error_of_model(&plan).iter().all(|factor| *factor >= 1.0));
            }
            Err(reason) => assert!(GraphicsDevice::shared().is_err(), "{reason}"),
        }
        if let Ok(measured) = plan.measured(&loaded[0], &views[0], false) {
            assert!(!measured.adapter.contains("llvmpipe"), "a software driver gave times");
        }
    }
}
