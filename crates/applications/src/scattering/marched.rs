//! Ray marching: the midpoint rule with equal steps, moved by noise.

use random_stream::Random;
use serde::{Deserialize, Serialize};
use shadow_filtering::FilteringError;

use super::{SingleScattering, ViewRay};
use crate::Estimate;

/// How samples are moved from the middles of their steps.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Jitter {
    /// Not at all.
    None,
    /// All samples of a ray by the noise of its pixel.
    #[default]
    Ray,
    /// Each on its own.
    Step,
}

/// Ray marching with so many steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marched {
    /// Samples a ray.
    pub steps: usize,
    /// How they are moved.
    pub jitter: Jitter,
    /// Of the noise of steps.
    pub seed: u64,
}

impl Estimate<SingleScattering<'_>> for Marched {
    /// The lit share up to the end of what changes, weighted by the samples' own transmittance, and what is lit beyond.
    fn estimate(&self, view: &SingleScattering<'_>, ray: &ViewRay) -> Result<f64, FilteringError> {
        let (origin, direction) = view.in_light_space(ray);
        let end = view.end(ray);
        let step = end / self.steps as f64;
        let mut random = Random::stream(self.seed, ray.stream);
        let (mut lit, mut all) = (0.0, 0.0);
        for i in 0..self.steps {
            let offset = match self.jitter {
                Jitter::None => 0.5,
                Jitter::Ray => ray.noise,
                Jitter::Step => random.unit(),
            };
            let t = (i as f64 + offset) * step;
            let weight = view.medium.transmittance(t);
            all += weight;
            if view.light.is_lit([0, 1, 2].map(|k| origin[k] + t * direction[k])) {
                lit += weight;
            }
        }
        // All light is lost before the first sample: the air at the camera counts.
        let share = if all > 0.0 { lit / all } else { f64::from(u8::from(view.light.is_lit(origin))) };
        Ok(view.joined(ray, share, end, view.is_lit_beyond(ray, end)))
    }
}
