//! Depth complexity: how many surfaces a kernel sees.

use crate::depth_map::DepthMap;
use crate::error::FilteringError;
use crate::kernel::Kernel;

/// Counts surfaces in a kernel: groups of texels whose sorted depths follow each other without a gap. Two neighbours in
/// that order belong together if they differ by no more than `gap` plus the larger slope |g_x| + |g_y| of the two,
/// which is the step from texel to texel within one plane.
///
/// This counts levels of depth, which is what moments see, not patches: a floor on both sides of a pole counts once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceCounter {
    gap: f64,
    slope_limit: f64,
}

impl SurfaceCounter {
    /// `gap` is a depth; slopes count up to `slope_limit`.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] for numbers outside \[0, 1\].
    pub fn new(gap: f64, slope_limit: f64) -> Result<Self, FilteringError> {
        for (key, value) in [("surface_gap", gap), ("plane_limit", slope_limit)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(FilteringError::parameter(key, value, "must lie in [0, 1]"));
            }
        }
        Ok(Self { gap, slope_limit })
    }

    /// Number of surfaces around a texel, at least 1. `slopes` holds |g_x| + |g_y| of each texel of the map.
    ///
    /// # Panics
    /// If the kernel does not lie inside the map.
    pub fn count(&self, map: &DepthMap, slopes: &[f32], kernel: &Kernel, x: usize, y: usize) -> usize {
        let radius = kernel.radius();
        let mut texels: Vec<(f32, f32)> = Vec::with_capacity(kernel.size() * kernel.size());
        for row in y - radius..=y + radius {
            let start = row * map.width() + x - radius;
            let range = start..start + kernel.size();
            texels.extend(map.depths()[range.clone()].iter().copied().zip(slopes[range].iter().copied()));
        }
        texels.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let separate = |pair: &[(f32, f32)]| {
            let slope = f64::from(pair[0].1.max(pair[1].1)).min(self.slope_limit);
            f64::from(pair[1].0) - f64::from(pair[0].0) > self.gap + slope
        };
        1 + texels.windows(2).filter(|pair| separate(pair)).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_count_once_whatever_their_slope() {
        let kernel = Kernel::uniform(9).unwrap();
        let counter = SurfaceCounter::new(0.004, 0.1).unwrap();
        let slope = 0.02f32;
        let depths: Vec<f32> = (0..81).map(|t| 0.2 + slope * (t % 9) as f32).collect();
        let map = DepthMap::new(9, 9, depths.clone()).unwrap();
        assert_eq!(counter.count(&map, &[slope; 81], &kernel, 4, 4), 1);
        // A pole at 0.1 and another at 0.05 in front of it.
        let mut depths = depths;
        depths[40] = 0.1;
        depths[41] = 0.05;
        let mut slopes = vec![slope; 81];
        (slopes[40], slopes[41]) = (0.0, 0.0);
        let map = DepthMap::new(9, 9, depths).unwrap();
        assert_eq!(counter.count(&map, &slopes, &kernel, 4, 4), 3);
    }
}
