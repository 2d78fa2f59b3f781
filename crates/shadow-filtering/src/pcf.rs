//! Percentage-closer filtering, the ground truth F and, with other kernels and biases, a technique.

use crate::depth_map::DepthMap;
use crate::error::FilteringError;
use crate::kernel::Kernel;
use serde::{Deserialize, Serialize};

/// A shaded point: an entry of the layered shadow map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// Column of its texel.
    pub x: usize,
    /// Row of its texel.
    pub y: usize,
    /// Depth in \[0, 1\].
    pub depth: f64,
    /// d depth / d texel x, d texel y of its plane.
    pub gradient: [f64; 2],
}

impl Receiver {
    /// Depth change of its plane from a texel to its diagonal neighbour: |g_x| + |g_y|, at most `limit`.
    pub fn slope(&self, limit: f64) -> f64 {
        (self.gradient[0].abs() + self.gradient[1].abs()).min(limit)
    }
}

/// A depth bias. It moves the compared depth towards the light.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct DepthBias {
    /// Constant part, in texel depths: the depth by which a plane at 45 degrees to the light changes from one texel
    /// to the next, the same number for all fragments of a view.
    pub texels: f64,
    /// Part that grows with the receiver's own slope |g_x| + |g_y|.
    #[serde(default)]
    pub slopes: f64,
}

impl DepthBias {
    /// Rejects NaN, infinities and biases away from the light.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] with key and value.
    pub fn check(&self) -> Result<(), FilteringError> {
        for (key, value) in [("texels", self.texels), ("slopes", self.slopes)] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(FilteringError::parameter(key, value, "must be finite and not negative"));
            }
        }
        Ok(())
    }

    /// The bias as a depth. `texel_depth` is the view's unit, `slope_limit` caps the receiver's slope.
    pub fn depth(&self, receiver: &Receiver, texel_depth: f64, slope_limit: f64) -> f64 {
        self.texels * texel_depth + self.slopes * receiver.slope(slope_limit)
    }

    /// The depth that techniques compare at a receiver: its own minus the bias, within \[0, 1\].
    pub fn compared(&self, receiver: &Receiver, texel_depth: f64, slope_limit: f64) -> f64 {
        (receiver.depth - self.depth(receiver, texel_depth, slope_limit)).clamp(0.0, 1.0)
    }
}

/// How F is computed: each tap is compared with the receiver's tangent plane at that tap, moved by a bias.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// Bias towards the light.
    pub bias: DepthBias,
    /// The plane's depth at a tap differs from the receiver's by at most this: slivers seen edge-on have gradients of
    /// any size, and their plane means nothing beyond them. Fraction of the depth range.
    pub plane_limit: f64,
}

impl Reference {
    /// Rejects values that make no sense.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] with key and value.
    pub fn check(&self) -> Result<(), FilteringError> {
        if !(self.plane_limit >= 0.0 && self.plane_limit <= 1.0) {
            return Err(FilteringError::parameter("plane_limit", self.plane_limit, "must lie in [0, 1]"));
        }
        self.bias.check()
    }

    /// F: the weight of the taps whose depth is less than the biased tangent plane there (MSM15 section 3.2).
    pub fn intensity(&self, map: &DepthMap, kernel: &Kernel, receiver: &Receiver, texel_depth: f64) -> f64 {
        let base = receiver.depth - self.bias.depth(receiver, texel_depth, self.plane_limit);
        let limit = self.plane_limit;
        let [gx, gy] = receiver.gradient;
        sum(map, kernel, receiver, |i, j| base + (gx * i + gy * j).clamp(-limit, limit))
    }
}

impl Kernel {
    /// F_Z(z): the weight of the taps around (x, y) with a depth less than `z`, the same for all taps (MSM15
    /// section 3). This is what the bounds are bounds of.
    pub fn percentage_closer(&self, map: &DepthMap, x: usize, y: usize, z: f64) -> f64 {
        sum(map, self, &Receiver { x, y, depth: z, gradient: [0.0; 2] }, |_, _| z)
    }
}

#[inline(always)]
fn sum(map: &DepthMap, kernel: &Kernel, at: &Receiver, compared: impl Fn(f64, f64) -> f64) -> f64 {
    let radius = kernel.radius();
    let inside = kernel.fits(map.width(), map.height(), at.x, at.y);
    let mut total = 0.0;
    for (j, &v) in kernel.weights().iter().enumerate() {
        let dy = j as f64 - radius as f64;
        let mut line = 0.0;
        if inside {
            let start = (at.y + j - radius) * map.width() + at.x - radius;
            let depths = &map.depths()[start..start + kernel.size()];
            for (i, (&w, &depth)) in kernel.weights().iter().zip(depths).enumerate() {
                let dx = i as f64 - radius as f64;
                line += if f64::from(depth) < compared(dx, dy) { w } else { 0.0 };
            }
        } else {
            let row = (at.y + j) as isize - radius as isize;
            for (i, &w) in kernel.weights().iter().enumerate() {
                let dx = i as f64 - radius as f64;
                let depth = map.at((at.x + i) as isize - radius as isize, row);
                line += if f64::from(depth) < compared(dx, dy) { w } else { 0.0 };
            }
        }
        total += v * line;
    }
    total.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(gx: f32, gy: f32, at: f32) -> DepthMap {
        let depths = (0..32 * 32).map(|t| at + gx * (t % 32 - 16) as f32 + gy * (t / 32 - 16) as f32);
        DepthMap::new(32, 32, depths.collect()).unwrap()
    }

    #[test]
    fn a_plane_does_not_shadow_itself_and_a_plain_comparison_does() {
        let map = plane(0.01, -0.005, 0.5);
        let kernel = Kernel::gaussian(9, 2.4).unwrap();
        let receiver = Receiver { x: 16, y: 16, depth: f64::from(map.at(16, 16)), gradient: [0.01, -0.005] };
        let reference = Reference { bias: DepthBias { texels: 0.01, slopes: 0.0 }, plane_limit: 0.25 };
        assert_eq!(reference.intensity(&map, &kernel, &receiver, 0.001), 0.0);
        let plain = kernel.percentage_closer(&map, 16, 16, receiver.depth);
        assert!(plain > 0.4 && plain < 0.5, "{plain}");
        // A bias of the kernel's reach along the slope removes it: 4 texels of |g_x| + |g_y|.
        let bias = DepthBias { texels: 0.0, slopes: 4.01 };
        let moved = receiver.depth - bias.depth(&receiver, 0.001, 1.0);
        assert_eq!(kernel.percentage_closer(&map, 16, 16, moved), 0.0);
    }

    #[test]
    fn a_limited_plane_is_the_plain_comparison() {
        let map = plane(0.02, 0.0, 0.5);
        let kernel = Kernel::gaussian(9, 2.4).unwrap();
        let reference = Reference { bias: DepthBias::default(), plane_limit: 0.0 };
        for x in [0, 3, 16, 31] {
            let receiver = Receiver { x, y: 7, depth: 0.52, gradient: [0.02, 0.0] };
            let plain = kernel.percentage_closer(&map, x, 7, 0.52);
            assert_eq!(reference.intensity(&map, &kernel, &receiver, 0.0), plain);
            let z = kernel.distribution(&map, x, 7);
            assert!((z.cdf(0.52) - plain).abs() < 1e-14);
        }
    }

    #[test]
    fn impossible_biases_name_their_key() {
        let error = |bias: DepthBias| bias.check().unwrap_err().to_string();
        assert!(error(DepthBias { texels: -1.0, slopes: 0.0 }).contains("texels = -1"));
        assert!(error(DepthBias { texels: 0.0, slopes: f64::NAN }).contains("slopes = NaN"));
        let reference = Reference { bias: DepthBias::default(), plane_limit: 2.0 };
        assert!(reference.check().unwrap_err().to_string().contains("plane_limit = 2"));
    }
}
