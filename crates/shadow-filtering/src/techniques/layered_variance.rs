//! Layered variance shadow maps: one variance shadow map for each part of the depth range (MSM15 section 2, after
//! Lauritzen and McCool).
//!
//! Layer i stores mean and square of clamp((z - p_i) / (p_(i+1) - p_i), 0, 1); a fragment uses the layer that it lies
//! in. The warp is monotone, so Cantelli's inequality in a layer is a bound for all depths. Layers do not overlap and
//! are of equal size; Lauritzen and McCool also place them by the scene's depths, which is left out here.

use super::variance::cantelli;
use crate::error::FilteringError;
use crate::technique::{Technique, unit};

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

    fn warp(&self, layer: usize, z: f64) -> f64 {
        (z * self.layers as f64 - layer as f64).clamp(0.0, 1.0)
    }
}

impl Technique for LayeredVariance {
    fn name(&self) -> String {
        format!("LVSM, {} layers", self.layers)
    }

    fn channels(&self) -> usize {
        2 * self.layers
    }

    fn encode(&self, depth: f64, out: &mut [f64]) {
        for (layer, pair) in out.chunks_exact_mut(2).enumerate() {
            let warped = self.warp(layer, unit(depth));
            pair.copy_from_slice(&[warped, warped * warped]);
        }
    }

    fn shade(&self, filtered: &[f64], z_f: f64) -> Result<f64, FilteringError> {
        let z_f = unit(z_f);
        let layer = ((z_f * self.layers as f64) as usize).min(self.layers - 1);
        Ok(cantelli(filtered[2 * layer], filtered[2 * layer + 1], self.warp(layer, z_f)))
    }

    fn is_lower_bound(&self) -> bool {
        true
    }
}
