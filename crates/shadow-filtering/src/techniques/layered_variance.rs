//! Layered variance shadow maps: one variance shadow map for each part of the depth range (MSM15 section 2, after
//! Lauritzen and McCool).
//!
//! Layer i stores mean and square of clamp((z - p_i) / (p_(i+1) - p_i), 0, 1); a fragment uses the layer that it lies
//! in. The warp is monotone, so Cantelli's inequality in a layer is a bound for all depths. Layers do not overlap and
//! are of equal size; Lauritzen and McCool also place them by the scene's depths, which is left out here.

use super::variance::cantelli;
use super::{Parts, count_of};
use crate::basis::DepthBasis;
use crate::bound::{ShadowBound, unit};
use crate::error::FilteringError;
use crate::spec::TechniqueSpec;
use crate::wgsl;
use moment_problem::arithmetic::Real;

/// Most layers that make sense: more channels than any texture array is given for this.
const MAX_LAYERS: usize = 64;

/// Layers of equal size on \[0, 1\], two values each.
#[derive(Clone, Copy)]
struct Layers {
    layers: usize,
}

impl Layers {
    fn warp<R: Real>(self, layer: usize, z: R) -> R {
        unit(z * R::from_f64(self.layers as f64) - R::from_f64(layer as f64))
    }
}

impl DepthBasis for Layers {
    fn channels(&self) -> usize {
        2 * self.layers
    }

    fn evaluate<R: Real>(&self, z: R, out: &mut [R]) {
        for (layer, pair) in out.chunks_exact_mut(2).enumerate() {
            let warped = self.warp(layer, z);
            pair.copy_from_slice(&[warped, warped * warped]);
        }
    }
}

impl ShadowBound for Layers {
    fn name(&self) -> String {
        format!("LVSM, {} layers", self.layers)
    }

    fn shade<R: Real>(&self, b: &[R], z_f: R) -> R {
        let layer = ((z_f * R::from_f64(self.layers as f64)).to_f64() as usize).min(self.layers - 1);
        cantelli(b[2 * layer], b[2 * layer + 1], self.warp(layer, z_f))
    }

    fn shader(&self) -> Option<String> {
        wgsl::layered_variance(self.layers)
    }
}

/// `layers`, 1 to 64.
pub(crate) fn parts(spec: &TechniqueSpec) -> Result<Parts, FilteringError> {
    let layers = count_of("layers", spec.layers, MAX_LAYERS)?;
    Ok(Parts::new(Layers { layers }, Layers { layers }))
}
