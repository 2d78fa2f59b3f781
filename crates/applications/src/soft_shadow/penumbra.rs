//! How large the searched and the filtered region must be (Fernando, *Percentage-Closer Soft Shadows*, 2005).
//!
//! For a light of half size a parallel to the map, a receiver at distance d_r and a blocker at distance d_b, similar
//! triangles give the penumbra's width w = 2 a (d_r - d_b) / d_b on the receiver. On the map, which lies at the near
//! distance n, it is w n / d_r, and blockers can lie within 2 a (d_r - n) / d_r. For a light at infinity of angular
//! diameter 2 t both are measured on planes of one scale: 2 tan(t) (d_r - d_b) and 2 tan(t) (d_r - n).

use moment_problem::arithmetic::Real;

/// How a light of finite size, its map and depths hang together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penumbra<R> {
    /// Half the light's size along the map's x and y axis: world units, or the tangent of half the angle.
    pub half_size: [R; 2],
    /// Distance of depth 0 from the light; `None` for a light at infinity.
    pub near: Option<R>,
    /// World distance from depth 0 to depth 1.
    pub depth_range: R,
    /// Texels per world unit on the map.
    pub texels_per_unit: [R; 2],
}

impl<R: Real> Penumbra<R> {
    /// Full widths in texels of the region in which blockers of a receiver at depth `z` can lie.
    pub fn search(&self, z: R) -> [R; 2] {
        let reach = z * self.depth_range;
        self.widths(match self.near {
            Some(near) => reach / (near + reach),
            None => reach,
        })
    }

    /// Full widths in texels of the filter for a receiver at depth `z` and blockers at `blocker`, which is clamped to
    /// what lies between the map and the receiver: reconstructed depths may lie anywhere.
    pub fn filter(&self, z: R, blocker: R) -> [R; 2] {
        let blocker = blocker.max(R::zero()).min(z);
        let apart = (z - blocker) * self.depth_range;
        self.widths(match self.near {
            Some(near) => {
                let distance = |z: R| near + z * self.depth_range;
                apart * near / (distance(z) * distance(blocker))
            }
            None => apart,
        })
    }

    /// Full widths in world units of the penumbra on the receiver.
    pub fn on_receiver(&self, z: R, blocker: R) -> [R; 2] {
        let blocker = blocker.max(R::zero()).min(z);
        let apart = (z - blocker) * self.depth_range;
        let share = match self.near {
            Some(near) => apart / (near + blocker * self.depth_range),
            None => apart,
        };
        self.half_size.map(|half| (half + half) * share)
    }

    /// The same in another precision.
    pub fn cast<S: Real>(&self) -> Penumbra<S> {
        let cast = |value: R| S::from_f64(value.to_f64());
        Penumbra {
            half_size: self.half_size.map(cast),
            near: self.near.map(cast),
            depth_range: cast(self.depth_range),
            texels_per_unit: self.texels_per_unit.map(cast),
        }
    }

    fn widths(&self, share: R) -> [R; 2] {
        [0, 1].map(|k| (self.half_size[k] + self.half_size[k]) * share * self.texels_per_unit[k])
    }

    /// N: texels of the largest region that a map of the given size is asked for, extended to whole texels.
    pub fn largest_region(&self, size: [usize; 2]) -> u32 {
        let widths = self.search(R::one());
        let texels = |k: usize| (widths[k].to_f64().ceil() + 1.0).clamp(1.0, size[k] as f64);
        (texels(0) * texels(1)) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn similar_triangles() {
        let lamp = Penumbra {
            half_size: [0.5, 0.25],
            near: Some(1.0),
            depth_range: 3.0,
            texels_per_unit: [100.0; 2],
        };
        // Light at 0, blocker at 2, receiver at 4.
        assert_eq!(lamp.on_receiver(1.0, 1.0 / 3.0), [1.0, 0.5]);
        assert_eq!(lamp.filter(1.0, 1.0 / 3.0), [25.0, 12.5]);
        assert_eq!(lamp.search(1.0), [75.0, 37.5]);
        assert_eq!(lamp.largest_region([1024; 2]), 76 * 39);
        assert_eq!(lamp.largest_region([64, 16]), 64 * 16);
        let sun = Penumbra { near: None, ..lamp };
        assert_eq!(sun.filter(1.0, 0.5), [150.0, 75.0]);
        // A blocker at the map is as far as the search goes.
        for light in [lamp, sun] {
            assert_eq!(light.filter(0.8, 0.0), light.search(0.8));
            assert_eq!(light.filter(0.8, -7.0), light.search(0.8));
            assert_eq!(light.filter(0.8, 0.9), [0.0; 2]);
        }
    }
}
