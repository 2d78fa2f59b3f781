//! Soft shadows from area lights: their truth by shadow rays, and what shadow maps make of them.

mod blue_noise;
mod filterable;
mod penumbra;
mod percentage_closer;
mod reconstruction;
mod shaders;
mod storage;
mod truth;
mod view;

pub use blue_noise::BlueNoise;
pub use filterable::{filterable_blockers, filterable_soft_shadow, filtered_hard_shadow};
pub use penumbra::Penumbra;
pub use percentage_closer::{DepthField, percentage_closer_blockers, percentage_closer_soft_shadow};
pub use reconstruction::{Blockers, Reconstruction, ReconstructionError, Warp};
pub use shaders::{
    FilterSize, filterable_shader, penumbra_uniform, percentage_closer_shader, prefix_sums_shader,
};
pub use storage::Storage;
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
    /// A number in \[0, 1) for each axis by which dithered corners are rounded, see [`Filter::dithered`].
    pub noise: [R; 2],
}

impl<R: Real> Fragment<R> {
    /// The same in another precision.
    pub fn cast<S: Real>(&self) -> Fragment<S> {
        let cast = |value: R| S::from_f64(value.to_f64());
        Fragment {
            position: self.position.map(cast),
            depth: cast(self.depth),
            bias: cast(self.bias),
            noise: self.noise.map(cast),
        }
    }
}

/// How the filtered region is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filter<R> {
    /// How the region falls on texels.
    pub fit: Fit,
    /// Whether both ends t of each axis become floor(t + u) first, with u the fragment's noise: over all u every texel is
    /// counted as often as it is covered, by whole texels and one region instead of nine (the author's remedy of 2017,
    /// with blue noise over the screen).
    pub dithered: bool,
    /// Least full width in texels. 0 lets it shrink to the texel itself.
    pub least_width: R,
    /// Full width in texels from which on a fragment's whole bias is taken, less for smaller filters, but a tenth at
    /// least: wide filters see more of a slope. 0 takes all of it always.
    pub full_bias_width: R,
}

impl<R: Real> Filter<R> {
    /// The same in another precision.
    pub fn cast<S: Real>(&self) -> Filter<S> {
        let cast = |value: R| S::from_f64(value.to_f64());
        Filter {
            fit: self.fit,
            dithered: self.dithered,
            least_width: cast(self.least_width),
            full_bias_width: cast(self.full_bias_width),
        }
    }

    /// As BHS16 publishes it: interpolated, one bias for all sizes.
    pub fn published() -> Self {
        Self { fit: Fit::Covered, dithered: false, least_width: R::zero(), full_bias_width: R::zero() }
    }

    /// Region and compared depth of a filter of the given full widths.
    fn applied(&self, fragment: &Fragment<R>, widths: [R; 2]) -> (Region<R>, R) {
        let widths = widths.map(|width| width.max(self.least_width));
        let share = if self.full_bias_width > R::zero() {
            (widths[0].max(widths[1]) / self.full_bias_width).max(R::from_f64(LEAST_BIAS_SHARE)).min(R::one())
        } else {
            R::one()
        };
        let region = Region::around(fragment.position, widths);
        let region = if self.dithered { region.rounded(fragment.noise) } else { region };
        (region, fragment.depth - share * fragment.bias)
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
    /// Share of the fragment's bias by which the compared depth moves towards the light: 1 where texels are compared, and
    /// as BHS16 publishes it. The author's later code takes 0: blockers near the receiver make the filter small.
    pub bias_share: R,
    /// Full width in texels that neither the search nor the filter exceeds, infinite where both are as large as the light
    /// wants them.
    pub most_width: R,
}

impl<R: Real> BlockerSearch<R> {
    /// The same in another precision.
    pub fn cast<S: Real>(&self) -> BlockerSearch<S> {
        let cast = |value: R| S::from_f64(value.to_f64());
        BlockerSearch {
            epsilon: cast(self.epsilon),
            umbra: cast(self.umbra),
            fit: self.fit,
            bias_share: cast(self.bias_share),
            most_width: cast(self.most_width),
        }
    }

    /// As BHS16 publishes it.
    pub fn published() -> Self {
        Self {
            epsilon: R::from_f64(0.01),
            umbra: R::from_f64(0.99),
            fit: Fit::Outwards,
            bias_share: R::one(),
            most_width: R::from_f64(f64::INFINITY),
        }
    }

    /// Every texel is asked, nothing is skipped.
    pub fn percentage_closer() -> Self {
        Self { epsilon: R::zero(), umbra: R::one(), ..Self::published() }
    }

    /// The searched region and the depth that is compared there.
    fn applied(&self, penumbra: &Penumbra<R>, fragment: &Fragment<R>) -> (Region<R>, R) {
        let widths = penumbra.search(fragment.depth).map(|width| width.min(self.most_width));
        let compared = fragment.depth - self.bias_share * fragment.bias;
        (Region::around(fragment.position, widths), compared)
    }

    fn is_umbra(&self, blockers: &Blockers<R>) -> bool {
        blockers.mass > self.umbra
    }

    fn widths(&self, penumbra: &Penumbra<R>, depth: R, blockers: &Blockers<R>) -> [R; 2] {
        let widths = penumbra.filter(depth, blockers.average(depth, self.epsilon));
        widths.map(|width| width.min(self.most_width))
    }
}

#[cfg(test)]
mod closed_forms;
#[cfg(test)]
mod tests;
