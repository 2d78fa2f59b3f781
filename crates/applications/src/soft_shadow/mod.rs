//! Soft shadows from area lights: their truth by shadow rays, and what shadow maps make of them.

mod filterable;
mod penumbra;
mod percentage_closer;
mod reconstruction;
mod truth;

pub use filterable::{filterable_soft_shadow, filtered_hard_shadow};
pub use penumbra::Penumbra;
pub use percentage_closer::{DepthField, percentage_closer_soft_shadow};
pub use reconstruction::{Blockers, Reconstruction, ReconstructionError, Warp};
pub use truth::{AreaTruth, OccludedFraction, TruthError, TruthSettings};

use moment_problem::arithmetic::Real;

use crate::field::Fit;

/// A point to be shaded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment<R> {
    /// On the map, in texels.
    pub position: [R; 2],
    /// Depth in \[0, 1\].
    pub depth: R,
    /// The depth that is compared when filtering: `depth` moved towards the light by a bias.
    pub compared: R,
}

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
    /// Least full width of the filter in texels. 0 lets it shrink to the texel itself.
    pub least_width: R,
}

impl<R: Real> BlockerSearch<R> {
    /// As BHS16 publishes it.
    pub fn published() -> Self {
        Self {
            epsilon: R::from_f64(0.01),
            umbra: R::from_f64(0.99),
            fit: Fit::Outwards,
            bias: R::zero(),
            least_width: R::zero(),
        }
    }

    /// Every texel is asked, nothing is skipped.
    pub fn percentage_closer() -> Self {
        Self { epsilon: R::zero(), umbra: R::one(), ..Self::published() }
    }

    fn is_umbra(&self, blockers: &Blockers<R>) -> bool {
        blockers.mass > self.umbra
    }

    fn widths(&self, penumbra: &Penumbra<R>, depth: R, blockers: &Blockers<R>) -> [R; 2] {
        penumbra.filter(depth, blockers.average(depth, self.epsilon)).map(|width| width.max(self.least_width))
    }
}

#[cfg(test)]
mod tests;
