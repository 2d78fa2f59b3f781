//! The truth: the fraction of the light that a receiver does not see, by shadow rays.

use random_stream::Random;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::area_light::PlacedLight;
use crate::rays::{LastOccluder, Segment, Triangles};
use crate::samples::ScrambledNet;

/// Independent nets; their spread is the standard error, known to about 1 / sqrt(2 x 15) = 18 %.
const REPLICATES: usize = 16;

/// Fewest rays a net: fewer say little about each other.
const FIRST_RAYS: usize = 16;

/// When rays stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthSettings {
    /// Rays go on until the standard error is at most this, a fraction of the light.
    pub standard_error: f64,
    /// Or until so many were sent.
    pub most_rays: usize,
    /// Of the nets and their shifts.
    pub seed: u64,
}

/// Settings that make no sense.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum TruthError {
    /// No error can be reached.
    #[error("standard_error = {value}: must lie in (0, 1)")]
    StandardError {
        /// The value.
        value: f64,
    },
    /// Too few or too many rays.
    #[error("most_rays = {value}: must lie from {least} to {limit}")]
    Rays {
        /// The value.
        value: usize,
        /// Least.
        least: usize,
        /// Most.
        limit: usize,
    },
}

/// What rays found.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct OccludedFraction {
    /// Fraction of the light's area that the receiver does not see; solid angle and cosine do not weigh.
    pub fraction: f64,
    /// Estimated standard error. It is never 0: where all n rays agree it is that of one dissenting ray,
    /// sqrt(p (1 - p) / (n + 2)) with p = 1 / (n + 2).
    pub standard_error: f64,
    /// Rays that were sent.
    pub rays: usize,
}

/// Nets for any number of receivers.
#[derive(Clone, Debug)]
pub struct AreaTruth {
    settings: TruthSettings,
    nets: Vec<ScrambledNet>,
}

impl AreaTruth {
    /// Makes the nets.
    ///
    /// # Errors
    /// [`TruthError`] for an error that cannot be reached and numbers of rays that make no sense.
    pub fn new(settings: TruthSettings) -> Result<Self, TruthError> {
        let TruthSettings { standard_error, most_rays, seed } = settings;
        if !(standard_error > 0.0 && standard_error < 1.0) {
            return Err(TruthError::StandardError { value: standard_error });
        }
        let (least, limit) = (REPLICATES * FIRST_RAYS, 1 << 24);
        if !(least..=limit).contains(&most_rays) {
            return Err(TruthError::Rays { value: most_rays, least, limit });
        }
        let count = most_rays / REPLICATES;
        let nets = (0..REPLICATES as u64).map(|stream| ScrambledNet::new(count, seed, stream)).collect();
        Ok(Self { settings, nets })
    }

    /// Asks for a receiver at a world position, on the triangle `from` if it lies on one. Receivers of different
    /// `stream` have independent samples; the answer depends on nothing else.
    pub fn occluded_fraction(
        &self,
        scene: &Triangles,
        light: &PlacedLight,
        receiver: [f64; 3],
        from: Option<u32>,
        stream: u64,
    ) -> OccludedFraction {
        let mut last = LastOccluder::default();
        self.fraction(stream, |point| {
            let direction = light.towards(receiver, point);
            let segment = Segment { origin: receiver, direction, endless: light.at_infinity, from };
            scene.occludes_again(&segment, &mut last)
        })
    }

    /// The fraction of the unit square for which rays are occluded. Different `stream`s have independent points.
    pub fn fraction(&self, stream: u64, mut is_occluded: impl FnMut([f64; 2]) -> bool) -> OccludedFraction {
        let mut random = Random::stream(self.settings.seed, stream);
        let shifts: [u64; REPLICATES] = std::array::from_fn(|_| random.next_bits());
        let most = self.nets[0].len();
        let mut hits = [0usize; REPLICATES];
        let (mut sent, mut next) = (0, FIRST_RAYS);
        loop {
            for ((net, &shift), hits) in self.nets.iter().zip(&shifts).zip(&mut hits) {
                for index in sent..next {
                    *hits += usize::from(is_occluded(net.shifted(index, shift)));
                }
            }
            sent = next;
            let found = summary(&hits, sent);
            if found.standard_error <= self.settings.standard_error || sent == most {
                return found;
            }
            // Nets are even at powers of two.
            next = (2 * sent).min(most);
        }
    }
}

fn summary(hits: &[usize; REPLICATES], per_net: usize) -> OccludedFraction {
    let rays = per_net * REPLICATES;
    let fraction = hits.iter().sum::<usize>() as f64 / rays as f64;
    let spread: f64 = hits.iter().map(|&h| (h as f64 / per_net as f64 - fraction).powi(2)).sum();
    let estimated = (spread / ((REPLICATES - 1) * REPLICATES) as f64).sqrt();
    let count = rays as f64 + 2.0;
    let least = 1.0 / count;
    let floor = (least * (1.0 - least) / count).sqrt();
    OccludedFraction { fraction, standard_error: estimated.max(floor), rays }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenes::{AreaLight, Outline};

    const SETTINGS: TruthSettings = TruthSettings { standard_error: 1e-3, most_rays: 1 << 15, seed: 4 };

    /// A half plane at height 2 of 4 above the receiver, whose edge is at `edge` as seen on the light.
    fn half_plane(edge: f32) -> Triangles {
        let x = 0.5 * edge;
        let far = 100.0;
        let positions = [[x, 2.0, -far], [x, 2.0, far], [-far, 2.0, -far], [-far, 2.0, far]];
        Triangles::new(&positions, &[[0, 1, 2], [2, 1, 3]]).unwrap()
    }

    #[test]
    fn half_planes_cover_what_geometry_says() {
        let truth = AreaTruth::new(SETTINGS).unwrap();
        let axes = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        for edge in [-0.9f32, -0.3, 0.0, 0.25, 0.7] {
            let t = f64::from(edge);
            let segment = 0.5 + (t * (1.0 - t * t).sqrt() + t.asin()) / std::f64::consts::PI;
            for (outline, expected) in [(Outline::Rectangle, 0.5 * (1.0 + t)), (Outline::Disc, segment)] {
                let light = AreaLight::local(outline, [0.0, 4.0, 0.0], axes).unwrap();
                let light = PlacedLight::new(&light, [[0.0; 3]; 3]);
                let found = truth.occluded_fraction(&half_plane(edge), &light, [0.0; 3], None, 1);
                let error = (found.fraction - expected).abs();
                assert!(found.standard_error <= SETTINGS.standard_error, "{found:?}");
                assert!(
                    error <= 5.0 * found.standard_error,
                    "{outline:?} {edge}: {found:?} against {expected}"
                );
            }
        }
    }

    /// The stated error is the actual one: over many receivers the ratio of both has variance 1, as far as 16 nets
    /// can tell.
    #[test]
    fn standard_errors_are_true() {
        let settings = TruthSettings { standard_error: 1e-9, most_rays: 1024, seed: 9 };
        let truth = AreaTruth::new(settings).unwrap();
        let light = AreaLight::local(Outline::Disc, [0.0, 4.0, 0.0], [[1.0, 0.0, 0.3], [0.0, 0.0, 1.0]]);
        let light = PlacedLight::new(&light.unwrap(), [[0.0; 3]; 3]);
        let scene = half_plane(0.37);
        let t = 0.37f32;
        let t = f64::from(t);
        let expected = 0.5 + (t * (1.0 - t * t).sqrt() + t.asin()) / std::f64::consts::PI;
        let count = 400;
        let squares: f64 = (0..count)
            .map(|stream| {
                let found = truth.occluded_fraction(&scene, &light, [0.0; 3], None, stream);
                ((found.fraction - expected) / found.standard_error).powi(2)
            })
            .sum();
        let variance = squares / count as f64;
        assert!((0.7..1.5).contains(&variance), "{variance}");
    }

    #[test]
    fn unanimous_rays_are_no_certainty() {
        let truth = AreaTruth::new(TruthSettings { standard_error: 4e-3, ..SETTINGS }).unwrap();
        let light: AreaLight = "sun:0.5".parse().unwrap();
        let light = PlacedLight::new(&light, [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]);
        for (edge, expected) in [(-2.0, 0.0), (2.0, 1.0)] {
            let found = truth.occluded_fraction(&half_plane(edge), &light, [0.0; 3], None, 0);
            assert_eq!((found.fraction, found.rays), (expected, 256));
            assert!(found.standard_error > 3.8e-3, "{found:?}");
        }
        // A point light needs no more than the least.
        let point: AreaLight = "sun:0".parse().unwrap();
        let point = PlacedLight::new(&point, [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]);
        assert_eq!(truth.occluded_fraction(&half_plane(0.1), &point, [0.0; 3], None, 0).fraction, 1.0);
    }

    #[test]
    fn impossible_settings_are_named() {
        let error = |settings| AreaTruth::new(settings).unwrap_err().to_string();
        assert!(error(TruthSettings { standard_error: 0.0, ..SETTINGS }).contains("standard_error = 0"));
        assert!(error(TruthSettings { standard_error: f64::NAN, ..SETTINGS }).contains("NaN"));
        assert!(error(TruthSettings { most_rays: 255, ..SETTINGS }).contains("most_rays = 255"));
    }
}
