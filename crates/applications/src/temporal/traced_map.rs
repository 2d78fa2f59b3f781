//! A shadow map whose texels are found by rays when they are first asked for: the same numbers as those of a map that was
//! drawn whole, at the price of those that are read.

use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};

use crate::rays::PosedTriangles;

/// What a shadow map sees through the centre of a texel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapTexel {
    /// Depth of the first surface in \[0, 1\], 1 where there is none.
    pub depth: f64,
    /// Whether that surface moves. It is stored as the sign of the depth (TC09 section 3.4).
    pub moving: bool,
}

/// From texel coordinates to a ray through the depth range, at depth 0 and 1 of which it begins and ends: origin, direction.
type RayOfTexel<'a> = Box<dyn Fn([f64; 2]) -> [[f64; 3]; 2] + Sync + 'a>;

/// The map of one frame, seen from one point of the light. It has no border: texels off the grid are traced, too, but not
/// kept.
pub struct TracedMap<'a> {
    scene: PosedTriangles<'a>,
    /// What stands still, where another map of the same rays knows it.
    known: Option<&'a TracedMap<'a>>,
    ray: RayOfTexel<'a>,
    size: [usize; 2],
    /// Bits of single-precision depths; [`UNKNOWN`] where no ray was sent yet. Whoever comes first writes, all write the same.
    texels: Vec<AtomicU32>,
    traced: AtomicUsize,
}

/// A NaN, which no depth is.
const UNKNOWN: u32 = u32::MAX;

impl<'a> TracedMap<'a> {
    /// A map of so many texels. Its memory may come from a map that is no longer needed.
    pub fn new(
        scene: PosedTriangles<'a>,
        size: [usize; 2],
        ray: impl Fn([f64; 2]) -> [[f64; 3]; 2] + Sync + 'a,
        memory: Vec<AtomicU32>,
    ) -> Self {
        let mut texels = memory;
        texels.iter_mut().for_each(|texel| *texel.get_mut() = UNKNOWN);
        texels.resize_with(size[0] * size[1], || AtomicU32::new(UNKNOWN));
        Self { scene, known: None, ray: Box::new(ray), size, texels, traced: AtomicUsize::new(0) }
    }

    /// The same map where `still`, of the same rays, already knows everything that stands still.
    pub fn over(self, still: &'a TracedMap<'a>) -> Self {
        Self { known: Some(still), ..self }
    }

    /// The memory, for the next map.
    pub fn into_memory(self) -> Vec<AtomicU32> {
        self.texels
    }

    /// Rays sent; where two threads ask for one texel at the same time it counts twice.
    pub fn traced(&self) -> usize {
        self.traced.load(Ordering::Relaxed)
    }

    /// The texel that holds a position in texel coordinates.
    pub fn at(&self, position: [f64; 2]) -> MapTexel {
        let [x, y] = position.map(f64::floor);
        let on_grid = x >= 0.0 && y >= 0.0 && x < self.size[0] as f64 && y < self.size[1] as f64;
        if !on_grid {
            return of_bits(self.trace([x + 0.5, y + 0.5]));
        }
        let texel = &self.texels[y as usize * self.size[0] + x as usize];
        let mut bits = texel.load(Ordering::Relaxed);
        if bits == UNKNOWN {
            bits = self.trace([x + 0.5, y + 0.5]);
            texel.store(bits, Ordering::Relaxed);
        }
        of_bits(bits)
    }

    fn trace(&self, centre: [f64; 2]) -> u32 {
        self.traced.fetch_add(1, Ordering::Relaxed);
        let [origin, direction] = (self.ray)(centre);
        let first = match self.known {
            None => self.scene.first(origin, direction),
            Some(known) => {
                let still = known.at(centre).depth;
                let nearer = |at: &f64| *at < still;
                let moving = self.scene.first_moving(origin, direction).filter(nearer);
                Some(moving.map_or((still, false), |at| (at, true)))
            }
        };
        let (depth, moving) = first.unwrap_or((1.0, false));
        let depth = depth as f32;
        (if moving { -depth } else { depth }).to_bits()
    }
}

fn of_bits(bits: u32) -> MapTexel {
    let stored = f32::from_bits(bits);
    MapTexel { depth: f64::from(stored.abs()), moving: stored.is_sign_negative() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::Triangles;

    #[test]
    fn texels_are_traced_once_and_tell_what_moves() {
        // A square of side 4 at height 2 over one of side 40 at height 0; the smaller one moves.
        let square = |half: f32, y: f32| {
            let positions = [[-half, y, -half], [half, y, -half], [-half, y, half], [half, y, half]];
            Triangles::new(&positions, &[[0, 1, 2], [1, 3, 2]]).unwrap()
        };
        let (ground, plate) = (square(20.0, 0.0), square(2.0, 2.0));
        let scene = PosedTriangles { still: &ground, moving: Some((&plate, scenes::Pose::IDENTITY)) };
        let ray = |[x, y]: [f64; 2]| [[x - 8.0, 5.0, y - 8.0], [0.0, -10.0, 0.0]];
        let map = TracedMap::new(scene, [16, 16], ray, Vec::new());
        let (high, low) = (map.at([8.2, 7.9]), map.at([1.0, 1.0]));
        assert_eq!((high.moving, low), (true, MapTexel { depth: 0.5, moving: false }));
        assert!((high.depth - 0.3).abs() < 1e-7);
        assert_eq!((map.at([8.9, 7.1]), map.traced()), (high, 2));
        // Off the grid there is ground, and beyond it nothing.
        assert_eq!(map.at([-3.0, 4.0]).depth, 0.5);
        assert_eq!(map.at([500.0, 4.0]), MapTexel { depth: 1.0, moving: false });
        let still = TracedMap::new(PosedTriangles { moving: None, ..scene }, [16, 16], ray, Vec::new());
        let over = TracedMap::new(scene, [16, 16], ray, Vec::new()).over(&still);
        assert_eq!([over.at([8.2, 7.9]), over.at([1.0, 1.0]), over.at([-3.0, 4.0])], [high, low, low]);
        let again = TracedMap::new(scene, [4, 4], ray, map.into_memory());
        assert_eq!((again.at([1.0, 1.0]), again.traced()), (low, 1));
    }
}
