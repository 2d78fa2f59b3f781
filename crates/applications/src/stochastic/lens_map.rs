//! The stochastic soft shadow map: a ray a texel, from anywhere on the light through the texel on the plane in focus, with
//! the distance of the first surface (SSSM15 section 7.1).
//!
//! Distances are those from the light's plane. A texel is a direction from the light's middle. A ray that starts `u` off the
//! middle and goes through a texel of the plane in focus f meets the plane at distance d in the texel that lies
//! u t (1 / d - 1 / f) off, where t are texels times distance per unit of length.

use moment_problem::arithmetic::Real;
use random_stream::Random;
use rayon::prelude::*;

/// A light and the map that its middle sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Columns and rows.
    pub size: [usize; 2],
    /// t: texels that a unit of length takes on a plane, times the plane's distance.
    pub texels: [f64; 2],
    /// Half sizes of the light along columns and rows in world units; of a disc that stands for a rectangle those of the disc
    /// of equal area.
    pub half_size: [f64; 2],
}

/// A ray of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensSample {
    /// u t: where the ray starts, in texels times distance.
    pub start: [f32; 2],
    /// Distance of the first surface; infinite where there is none.
    pub distance: f32,
}

/// The map.
#[derive(Clone, Debug, PartialEq)]
pub struct LensMap {
    lens: Lens,
    focus: f64,
    samples: Vec<LensSample>,
}

/// Strata of the light along each axis: neighbouring texels of a square of so many sample different ones.
pub const STRATA: usize = 4;

/// The order in which strata follow each other within the square: its rows are far apart on the light.
const ORDER: [usize; STRATA * STRATA] = [0, 10, 7, 13, 9, 3, 14, 4, 6, 12, 1, 11, 15, 5, 8, 2];

impl LensMap {
    /// Sends the rays. `first` gets the middle of a texel and a point of \[0, 1)^2 for the light, and says where on the light
    /// that is in world units along columns and rows, and how far the first surface is on the way through the texel at the
    /// distance `focus`. The light's points depend on seed and stream alone.
    pub fn trace(
        lens: Lens,
        focus: f64,
        (seed, stream): (u64, u64),
        first: impl Fn([f64; 2], [f64; 2]) -> ([f64; 2], Option<f64>) + Sync,
    ) -> Self {
        let [width, height] = lens.size;
        let sample = |index: usize| {
            let (x, y) = (index % width, index / width);
            let mut random = Random::substream(seed, stream, index as u64);
            let stratum = ORDER[(y % STRATA) * STRATA + x % STRATA];
            let within = |cell: usize, random: &mut Random| (cell as f64 + random.unit()) / STRATA as f64;
            let point = [within(stratum % STRATA, &mut random), within(stratum / STRATA, &mut random)];
            let (u, distance) = first([x as f64 + 0.5, y as f64 + 0.5], point);
            let start = [0, 1].map(|k| (u[k] * lens.texels[k]) as f32);
            LensSample { start, distance: distance.map_or(f32::INFINITY, |distance| distance as f32) }
        };
        Self { lens, focus, samples: (0..width * height).into_par_iter().map(sample).collect() }
    }

    /// Light and size.
    pub fn lens(&self) -> &Lens {
        &self.lens
    }

    /// Distance of the plane in focus.
    pub fn focus(&self) -> f64 {
        self.focus
    }

    /// Rays, row by row.
    pub fn samples(&self) -> &[LensSample] {
        &self.samples
    }

    /// What a ray's start is multiplied by for its offset on the plane at a distance: 1 / distance - 1 / focus.
    pub(super) fn lever<R: Real>(&self, distance: R) -> R {
        R::one() / distance - R::from_f64(1.0 / self.focus)
    }

    /// Where a ray is on the plane of a lever, in texel coordinates.
    pub(super) fn position<R: Real>(&self, index: usize, lever: R) -> [R; 2] {
        let width = self.lens.size[0];
        let centre = [(index % width) as f64 + 0.5, (index / width) as f64 + 0.5];
        let LensSample { start, .. } = self.samples[index];
        [0, 1].map(|k| R::from_f64(centre[k]) + R::from_f64(f64::from(start[k])) * lever)
    }

    /// Where the light's middle sees the surface of a ray: its centre of confusion on every plane.
    pub(super) fn projected<R: Real>(&self, index: usize) -> [R; 2] {
        self.position(index, self.lever(R::from_f64(f64::from(self.samples[index].distance))))
    }
}

impl Lens {
    /// c of a surface on a plane in texels (SSSM15 equation 6): t R |1 / d - 1 / plane|.
    pub fn circle<R: Real>(&self, plane: f64, distance: R) -> R {
        R::from_f64(self.mean_reach()) * (R::one() / distance - R::from_f64(1.0 / plane)).abs()
    }

    /// t R, the geometric mean of both axes.
    pub(super) fn mean_reach(&self) -> f64 {
        (self.reach()[0] * self.reach()[1]).sqrt()
    }

    /// Both axes over their geometric mean.
    pub(super) fn aspect(&self) -> [f64; 2] {
        let mean = self.mean_reach();
        if mean > 0.0 { self.reach().map(|reach| reach / mean) } else { [1.0; 2] }
    }

    fn reach(&self) -> [f64; 2] {
        [0, 1].map(|k| self.half_size[k] * self.texels[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stochastic::circle_of_confusion;

    #[test]
    fn strata_are_all_sampled_and_rays_go_where_geometry_says() {
        let mut order = ORDER;
        order.sort_unstable();
        assert!(order.iter().enumerate().all(|(i, &stratum)| i == stratum));
        let lens = Lens { size: [8, 8], texels: [40.0, 20.0], half_size: [0.5, 0.5] };
        let seen = std::sync::Mutex::new(Vec::new());
        let map = LensMap::trace(lens, 4.0, (1, 0), |texel, [x, y]| {
            seen.lock().unwrap().push((texel, [x, y]));
            ([x - 0.5, y - 0.5], Some(2.0))
        });
        let mut strata = [0; 16];
        for ([x, y], [u, v]) in seen.into_inner().unwrap() {
            if x < 4.0 && y < 4.0 {
                strata[(v * 4.0) as usize * 4 + (u * 4.0) as usize] += 1;
            }
        }
        assert_eq!(strata, [1; 16]);
        // In focus a ray is in its texel; the middle of the light sees the surface, which lies halfway between the light and the texel.
        assert_eq!(map.position(9, map.lever(4.0)), [1.5, 1.5]);
        let start = map.samples()[9].start.map(f64::from);
        let [x, y]: [f64; 2] = map.projected(9);
        assert!((x - 1.5 - 0.25 * start[0]).abs() < 1e-12 && (y - 1.5 - 0.25 * start[1]).abs() < 1e-12);
        // m = 40 / 4 and 20 / 4 texels a unit.
        let c = circle_of_confusion((10.0f64 * 5.0).sqrt(), 0.5, 4.0, 2.0);
        assert!((lens.circle(4.0, 2.0) - c).abs() < 1e-12);
        assert_eq!(map, LensMap::trace(lens, 4.0, (1, 0), |_, [x, y]| ([x - 0.5, y - 0.5], Some(2.0))));
        let other = LensMap::trace(lens, 4.0, (1, 1), |_, [x, y]| ([x - 0.5, y - 0.5], None));
        assert!(
            other.samples()[0].start != map.samples()[0].start && other.samples()[0].distance.is_infinite()
        );
    }
}
