//! Layered variance shadow maps: one variance shadow map for each part of the depth range (MSM15 section 2, after
//! Lauritzen and McCool).
//!
//! Layer i stores mean and square of clamp((z - p_i) / (p_(i+1) - p_i), 0, 1); a fragment uses the layer that it lies
//! in. The warp is monotone, so Cantelli's inequality in a layer is a bound for all depths. Layers do not overlap and
//! are of equal size; Lauritzen and McCool also place them by the scene's depths, which is left out here.

use super::variance::cantelli;
use crate::error::FilteringError;
use crate::real_time::{RealTime, in_real_time};
use crate::technique::{Technique, unit};
use moment_problem::arithmetic::Real;

/// Most layers that make sense: more channels than any texture array is given for this.
const MAX_LAYERS: usize = 64;

/// Layered variance shadow map with layers of equal size on \[0, 1\].
#[derive(Clone, Copy, Debug)]
pub struct LayeredVariance {
    layers: usize,
}

impl LayeredVariance {
    /// Two channels a layer.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] for no or more than 64 layers.
    pub fn new(layers: usize) -> Result<Self, FilteringError> {
        if !(1..=MAX_LAYERS).contains(&layers) {
            return Err(FilteringError::parameter("layers", layers, format!("must be 1 to {MAX_LAYERS}")));
        }
        Ok(Self { layers })
    }

    fn warp<R: Real>(&self, layer: usize, z: R) -> R {
        unit(z * R::from_f64(self.layers as f64) - R::from_f64(layer as f64))
    }

    fn encode_in<R: Real>(&self, depth: R, out: &mut [R]) {
        for (layer, pair) in out.chunks_exact_mut(2).enumerate() {
            let warped = self.warp(layer, unit(depth));
            pair.copy_from_slice(&[warped, warped * warped]);
        }
    }

    fn shade_in<R: Real>(&self, filtered: &[R], z_f: R) -> R {
        let z_f = unit(z_f);
        let layer = ((z_f * R::from_f64(self.layers as f64)).to_f64() as usize).min(self.layers - 1);
        cantelli(filtered[2 * layer], filtered[2 * layer + 1], self.warp(layer, z_f))
    }
}

in_real_time!(LayeredVariance, |technique| shaders::layered_variance(technique.layers));

impl Technique for LayeredVariance {
    fn name(&self) -> String {
        format!("LVSM, {} layers", self.layers)
    }

    fn channels(&self) -> usize {
        2 * self.layers
    }

    fn encode(&self, depth: f64, out: &mut [f64]) {
        self.encode_in(depth, out);
    }

    fn shade(&self, filtered: &[f64], z_f: f64) -> Result<f64, FilteringError> {
        Ok(self.shade_in(filtered, z_f))
    }

    fn real_time(&self) -> Option<&dyn RealTime> {
        Some(self)
    }

    fn is_lower_bound(&self) -> bool {
        true
    }
}
