//! Random distributions of the kinds that filter kernels have, from a seed.

use moment_problem::DepthDistribution;
use random_stream::Random;

/// A distribution on [0, 1] and a fragment depth.
#[derive(Clone, Debug)]
pub struct Sample {
    pub z: DepthDistribution,
    pub z_f: f64,
}

/// Few surfaces, slanted surfaces, clusters, thin weights, atoms at the ends; z_f anywhere, near or on an atom.
pub fn sample(random: &mut Random) -> Sample {
    let kind = random.below(5);
    let surfaces = 1 + random.below(4);
    let mut depths = Vec::new();
    let mut weights = Vec::new();
    for _ in 0..surfaces {
        let (centre, weight) = (random.unit(), 0.05 + random.unit());
        match kind {
            // Slanted surfaces: a fan of depths, or a narrow cluster.
            0 | 1 => {
                let spread = if kind == 0 { 0.1 } else { 0.003 };
                for _ in 0..4 {
                    depths.push((centre + spread * (random.unit() - 0.5)).clamp(0.0, 1.0));
                    weights.push(weight * (0.1 + random.unit()));
                }
            }
            // One surface barely visible.
            2 => {
                depths.push(centre);
                weights.push(if depths.len() == 1 { 1e-3 * weight } else { weight });
            }
            // Surfaces at the ends of the depth range.
            3 => {
                depths.push(if random.below(3) == 0 { (random.below(2)) as f64 } else { centre });
                weights.push(weight);
            }
            _ => {
                depths.push(centre);
                weights.push(weight);
            }
        }
    }
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|w| *w /= sum);
    let z_f = match random.below(6) {
        0 => depths[random.below(depths.len())],
        1 => (depths[random.below(depths.len())] + 1e-3 * (random.unit() - 0.5)).clamp(0.0, 1.0),
        2 if random.below(4) == 0 => random.below(2) as f64,
        _ => random.unit(),
    };
    Sample { z: DepthDistribution::new(&depths, &weights).unwrap(), z_f }
}
