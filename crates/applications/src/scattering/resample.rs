//! A filtered texel of a moment shadow map as moments of rectified depth (BHS16 section 2.3).

use std::f64::consts::PI;

use super::{TwoDepths, two_depths};
use crate::field::Means;

/// What became of a texel on its way into the rectified map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resampled {
    /// The two depths that the moments were taken for.
    pub two: TwoDepths<f64>,
    /// pi - theta of each.
    pub flipped: [f64; 2],
    /// Normalised and clamped to \[0, 1\].
    pub depths: [f64; 2],
}

/// Depths from here on are those of empty texels, cleared to 1, and rounded: nothing is there, however far light travels.
const EMPTY: f64 = 1.0 - 1e-4;

/// Two depths of light space, seen from the camera at distance `r` from the light ray: `near` and `far` are z of depths 0 and 1
/// relative to the camera, `flipped` the range of pi - theta that is normalised. The moments must not be biased before.
pub fn resample(b: [f64; 3], range: [f64; 2], r: f64, flipped: [f64; 2]) -> Resampled {
    Resampled::new(two_depths(b), range, r, flipped)
}

impl Resampled {
    /// The same for two depths that are known.
    pub fn new(two: TwoDepths<f64>, [near, far]: [f64; 2], r: f64, flipped: [f64; 2]) -> Self {
        let angles = two.depths.map(|depth| r.atan2(-(near + depth * (far - near))));
        let depths = angles.map(|angle| ((angle - flipped[0]) / (flipped[1] - flipped[0])).clamp(0.0, 1.0));
        Self { two, flipped: angles, depths }
    }

    /// The same where depth 1 means that nothing is there.
    pub(super) fn of_cleared(two: TwoDepths<f64>, range: [f64; 2], r: f64, flipped: [f64; 2]) -> Self {
        let mut resampled = Self::new(two, range, r, flipped);
        for k in 0..2 {
            if two.depths[k] >= EMPTY {
                (resampled.flipped[k], resampled.depths[k]) = (PI, 1.0);
            }
        }
        resampled
    }

    /// Power moments of the rectified depths, the first `order`.
    pub fn moments(&self, order: usize) -> Means<f64> {
        let mut means = [0.0; crate::field::MAX_CHANNELS];
        for (depth, weight) in self.depths.into_iter().zip(self.two.weights) {
            let mut power = weight;
            for mean in means.iter_mut().take(order) {
                power *= depth;
                *mean += power;
            }
        }
        means
    }
}
