//! A few taps in place of every texel: percentage-closer soft shadows with so many lookups.

use moment_problem::arithmetic::Real;

use crate::field::Fit;
use crate::region::Region;
use crate::samples::PoissonTaps;
use crate::soft_shadow::{Blockers, DepthField};

/// A depth map of which a region is known by a few taps. `depth` gives that of the texel at a position.
pub struct SampledField<'a, D> {
    /// Depth at texel coordinates.
    pub depth: D,
    /// Where the taps lie in a region, which is scaled to \[-1, 1\]^2.
    pub taps: &'a PoissonTaps,
}

impl<D: Fn([f64; 2]) -> f64> SampledField<'_, D> {
    /// Depths of all taps of a region.
    pub fn depths<R: Real>(&self, region: &Region<R>) -> impl Iterator<Item = f64> {
        let at = |k: usize, t: f64| {
            let (low, high) = (region.low[k].to_f64(), region.high[k].to_f64());
            0.5 * (low + high) + 0.5 * t * (high - low)
        };
        self.taps.points().iter().map(move |&[x, y]| (self.depth)([at(0, x), at(1, y)]))
    }
}

impl<R: Real, D: Fn([f64; 2]) -> f64> DepthField<R> for SampledField<'_, D> {
    /// How the region falls on texels does not matter to taps.
    fn in_front(&self, region: &Region<R>, _fit: Fit, z: R) -> Blockers<R> {
        let weight = R::one() / R::from_f64(self.taps.points().len() as f64);
        let mut found = Blockers::none();
        for depth in self.depths(region).map(R::from_f64).filter(|&depth| depth < z) {
            found = found.with(depth, weight);
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::TapShape;

    #[test]
    fn taps_see_the_share_of_a_region_that_lies_in_front() {
        let taps = PoissonTaps::new(TapShape::Square, 64, 1, 0);
        let field = SampledField { depth: |[x, _]: [f64; 2]| if x < 5.0 { 0.25 } else { 0.75 }, taps: &taps };
        let region = Region { low: [3.0, 1.0], high: [7.0, 9.0] };
        let found: Blockers<f64> = field.in_front(&region, Fit::Covered, 0.5);
        assert!((found.mass - 0.5).abs() < 0.1, "{found:?}");
        assert!((found.depth_sum / found.mass - 0.25).abs() < 1e-12);
        let none: Blockers<f64> = field.in_front(&region, Fit::Covered, 0.25);
        assert_eq!(none.mass, 0.0);
    }
}
