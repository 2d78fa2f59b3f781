//! Soft shadows from area lights: their truth by shadow rays, and what shadow maps make of them.

mod filterable;
mod penumbra;
mod percentage_closer;
mod reconstruction;
mod shaders;
mod truth;
mod view;

pub use filterable::{filterable_soft_shadow, filtered_hard_shadow};
pub use penumbra::Penumbra;
pub use percentage_closer::{DepthField, percentage_closer_soft_shadow};
pub use reconstruction::{Blockers, Reconstruction, ReconstructionError, Warp};
pub use shaders::{
    FilterSize, filterable_shader, penumbra_uniform, percentage_closer_shader, prefix_sums_shader,
};
pub use truth::{AreaTruth, OccludedFraction, TruthError, TruthSettings};
pub use view::{SoftMethod, SoftReceiver, SoftShadow};

use moment_problem::arithmetic::Real;

use crate::field::Fit;
use crate::region::Region;

/// A point to be shaded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment<R> {
    /// On the map, in texels.
    pub position: [R; 2],
    /// Depth in \[0, 1\].
    pub depth: R,
    /// By how much the depth that is compared when filtering lies nearer to the light.
    pub bias: R,
}

/// How the filtered region is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filter<R> {
    /// How the region falls on texels.
    pub fit: Fit,
    /// Least full width in texels. 0 lets it shrink to the texel itself.
    pub least_width: R,
    /// Full width in texels from which on a fragment's whole bias is taken, less for smaller filters, but a tenth at
    /// least: wide filters see more of a slope. 0 takes all of it always.
    pub full_bias_width: R,
}

impl<R: Real> Filter<R> {
    /// As BHS16 publishes it: interpolated, one bias for all sizes.
    pub fn published() -> Self {
        Self { fit: Fit::Covered, least_width: R::zero(), full_bias_width: R::zero() }
    }

    /// Region and compared depth of a filter of the given full widths.
    fn applied(&self, fragment: &Fragment<R>, widths: [R; 2]) -> (Region<R>, R) {
        let widths = widths.map(|width| width.max(self.least_width));
        let share = if self.full_bias_width > R::zero() {
            (widths[0].max(widths[1]) / self.full_bias_width).max(R::from_f64(LEAST_BIAS_SHARE)).min(R::one())
        } else {
            R::one()
        };
        (Region::around(fragment.position, widths), fragment.depth - share * fragment.bias)
    }
}

/// As in the author's code of 2017.
const LEAST_BIAS_SHARE: f64 = 0.1;

/// How blockers are looked for, and what is made of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockerSearch<R> {
    /// Weight of the receiver's own depth in the average (BHS16: 0.01, the author's later code: 0.001). 0 in
    /// percentage-closer soft shadows.
    pub epsilon: R,
    /// Share of blockers above which the fragment counts as umbra without filtering (BHS16: 0.99); 1 switches that off.
    pub umbra: R,
    /// How the search region falls on texels.
    pub fit: Fit,
    /// By how much the compared depth moves towards the light. 0 is right for reconstructions: blockers near the
    /// receiver make the filter small.
    pub bias: R,
}

impl<R: Real> BlockerSearch<R> {
    /// As BHS16 publishes it.
    pub fn published() -> Self {
        Self { epsilon: R::from_f64(0.01), umbra: R::from_f64(0.99), fit: Fit::Outwards, bias: R::zero() }
    }

    /// Every texel is asked, nothing is skipped.
    pub fn percentage_closer() -> Self {
        Self { epsilon: R::zero(), umbra: R::one(), ..Self::published() }
    }

    fn is_umbra(&self, blockers: &Blockers<R>) -> bool {
        blockers.mass > self.umbra
    }

    fn widths(&self, penumbra: &Penumbra<R>, depth: R, blockers: &Blockers<R>) -> [R; 2] {
        penumbra.filter(depth, blockers.average(depth, self.epsilon))
    }
}

#[cfg(test)]
mod closed_forms;
#[cfg(test)]
mod tests;
