//! Synthetic filter kernels: what a square of shadow-map texels sees of a few surfaces.

use crate::error::EvaluationError;
use moment_problem::DepthDistribution;
use random_stream::Random;
use serde::{Deserialize, Serialize};

/// Largest accepted number of texels along a side.
const MAX_SIZE: usize = 256;

/// A square of equally weighted texels; each holds the depth of the nearest surface that covers its centre.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Kernel {
    /// Name in records and figures.
    pub id: String,
    /// Texels along a side.
    pub size: usize,
    /// The surfaces, in any order.
    pub surface: Vec<Surface>,
}

/// A plane piece, possibly rough, seen from the light.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Surface {
    /// Depth at the centre of the kernel, 0 at the light, 1 at the far plane.
    pub depth: f64,
    /// Change of depth across the kernel's width and height.
    #[serde(default)]
    pub slope: [f64; 2],
    /// Half-width of a uniform random change of depth, drawn for each texel.
    #[serde(default)]
    pub roughness: f64,
    /// Where the surface is.
    #[serde(default)]
    pub covers: Region,
}

/// A part of the kernel, whose corners are (0, 0) and (1, 1).
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Region {
    /// All of it.
    #[default]
    Everything,
    /// Points p with normal . p < offset.
    HalfPlane {
        /// Normal vector, any length.
        normal: [f64; 2],
        /// Offset in units of the normal's length.
        offset: f64,
    },
    /// A disc.
    Disc {
        /// Its centre.
        centre: [f64; 2],
        /// Its radius.
        radius: f64,
    },
    /// Each texel with this probability: leaves.
    Scattered {
        /// The probability.
        share: f64,
    },
}

impl Kernel {
    /// Depths of the texels, row by row. Random numbers depend on `seed` and `index` (of the kernel) only.
    pub fn depths(&self, seed: u64, index: usize) -> Result<Vec<f64>, EvaluationError> {
        let fail = |reason: String| EvaluationError::Value(format!("kernel `{}`: {reason}", self.id));
        if !(1..=MAX_SIZE).contains(&self.size) {
            return Err(fail(format!("size = {} is not between 1 and {MAX_SIZE}", self.size)));
        }
        let mut depths = vec![f64::INFINITY; self.size * self.size];
        for (number, surface) in self.surface.iter().enumerate() {
            let mut random = Random::substream(seed, index as u64, number as u64);
            for (texel, nearest) in depths.iter_mut().enumerate() {
                let centre = |i: usize| (i as f64 + 0.5) / self.size as f64;
                let (x, y) = (centre(texel % self.size), centre(texel / self.size));
                let (offset, chance) = (2.0 * random.unit() - 1.0, random.unit());
                if surface.covers.contains(x, y, chance) {
                    let plane = surface.depth + surface.slope[0] * (x - 0.5) + surface.slope[1] * (y - 0.5);
                    *nearest = nearest.min(plane + surface.roughness * offset);
                }
            }
        }
        match depths.iter().position(|z| !(0.0..=1.0).contains(z)) {
            None => Ok(depths),
            Some(texel) => {
                let (x, y, z) = (texel % self.size, texel / self.size, depths[texel]);
                let what = if z == f64::INFINITY { "no surface" } else { "a depth outside [0, 1]" };
                Err(fail(format!("texel ({x}, {y}) has {what} ({z})")))
            }
        }
    }
}

impl Region {
    fn contains(&self, x: f64, y: f64, chance: f64) -> bool {
        match *self {
            Self::Everything => true,
            Self::HalfPlane { normal, offset } => normal[0] * x + normal[1] * y < offset,
            Self::Disc { centre, radius } => (x - centre[0]).hypot(y - centre[1]) < radius,
            Self::Scattered { share } => chance < share,
        }
    }
}

/// The distribution Z of equally weighted depths.
pub fn uniform_distribution(depths: &[f64]) -> Result<DepthDistribution, EvaluationError> {
    let weights = vec![1.0 / depths.len() as f64; depths.len()];
    DepthDistribution::new(depths, &weights).map_err(|error| EvaluationError::Value(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kernel(text: &str) -> Kernel {
        toml::from_str(text).unwrap()
    }

    #[test]
    fn the_nearest_covering_surface_wins() {
        let half = "covers = { half_plane = { normal = [1.0, 0.0], offset = 0.5 } }";
        let kernel = kernel(&format!(
            "id = 'k'\nsize = 4\n[[surface]]\ndepth = 0.7\n[[surface]]\ndepth = 0.2\n{half}"
        ));
        let depths = kernel.depths(1, 0).unwrap();
        assert_eq!(depths[..4], [0.2, 0.2, 0.7, 0.7]);
        let z = uniform_distribution(&depths).unwrap();
        assert_eq!((z.cdf(0.2), z.cdf(0.7), z.cdf(0.8)), (0.0, 0.5, 1.0));
    }

    #[test]
    fn roughness_depends_on_the_seed_and_stays_within_its_width() {
        let kernel = kernel("id = 'k'\nsize = 16\n[[surface]]\ndepth = 0.5\nroughness = 0.1");
        let depths = kernel.depths(1, 0).unwrap();
        assert_eq!(depths, kernel.depths(1, 0).unwrap());
        assert_ne!(depths, kernel.depths(2, 0).unwrap());
        assert_ne!(depths, kernel.depths(1, 1).unwrap());
        assert!(depths.iter().all(|z| (z - 0.5).abs() <= 0.1));
        let mean = depths.iter().sum::<f64>() / 256.0;
        // Standard error 0.1 / sqrt(3 * 256) = 0.0036.
        assert!((mean - 0.5).abs() < 0.015, "{mean}");
    }

    #[test]
    fn uncovered_texels_and_depths_outside_are_errors() {
        let disc = "covers = { disc = { centre = [0.5, 0.5], radius = 0.2 } }";
        let error = kernel(&format!("id = 'k'\nsize = 4\n[[surface]]\ndepth = 0.7\n{disc}")).depths(1, 0);
        assert!(error.unwrap_err().to_string().contains("texel (0, 0) has no surface"));
        let error = kernel("id = 'k'\nsize = 4\n[[surface]]\ndepth = 1.5").depths(1, 0);
        assert!(error.unwrap_err().to_string().contains("1.5"));
    }
}
