//! A few taps in place of every texel: Poisson discs, and percentage-closer soft shadows with so many lookups.

use moment_problem::arithmetic::Real;
use random_stream::Random;

use crate::field::Fit;
use crate::region::Region;
use crate::soft_shadow::{Blockers, DepthField};

/// Where taps lie.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum TapShape {
    /// Within the unit disc.
    Disc,
    /// Within \[-1, 1\]^2.
    Square,
}

/// Points that keep their distance: each is the one of many candidates that is farthest from those before it (Mitchell's best
/// candidate), the first lies at random.
#[derive(Clone, Debug, PartialEq)]
pub struct PoissonTaps(Vec<[f64; 2]>);

/// Candidates a point and point before it.
const CANDIDATES: usize = 32;

impl PoissonTaps {
    /// So many points; those of different streams are independent.
    pub fn new(shape: TapShape, count: usize, seed: u64, stream: u64) -> Self {
        let mut random = Random::stream(seed, stream);
        let mut points: Vec<[f64; 2]> = Vec::with_capacity(count);
        while points.len() < count {
            let mut best = ([0.0; 2], f64::NEG_INFINITY);
            for _ in 0..CANDIDATES * (points.len() + 1) {
                let candidate = [random.within(-1.0, 1.0), random.within(-1.0, 1.0)];
                if shape == TapShape::Disc && candidate[0].hypot(candidate[1]) > 1.0 {
                    continue;
                }
                let distance = |p: &[f64; 2]| (p[0] - candidate[0]).hypot(p[1] - candidate[1]);
                let nearest = points.iter().map(distance).fold(f64::INFINITY, f64::min);
                if nearest > best.1 {
                    best = (candidate, nearest);
                }
            }
            points.push(best.0);
        }
        Self(points)
    }

    /// The points.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.0
    }
}

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

    #[test]
    fn taps_keep_their_distance_and_lie_inside() {
        for shape in [TapShape::Disc, TapShape::Square] {
            let taps = PoissonTaps::new(shape, 16, 1, 0);
            assert_eq!(taps.points().len(), 16);
            assert_ne!(taps, PoissonTaps::new(shape, 16, 1, 1));
            let mut nearest = f64::INFINITY;
            for (i, a) in taps.points().iter().enumerate() {
                assert!(shape == TapShape::Square || a[0].hypot(a[1]) <= 1.0);
                for b in &taps.points()[..i] {
                    nearest = nearest.min((a[0] - b[0]).hypot(a[1] - b[1]));
                }
            }
            // 16 random points of the disc come as near as 0.08 on average.
            assert!(nearest > 0.25, "{shape:?}: {nearest}");
        }
    }

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
