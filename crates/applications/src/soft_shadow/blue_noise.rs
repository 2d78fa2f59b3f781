//! Blue noise by void and cluster (Ulichney, *The void-and-cluster method for dither array generation*, 1993), for
//! [`super::Filter::dithered`].

use random_stream::Random;

/// Texels along an edge of the tile, which repeats.
const SIDE: usize = 32;

/// Width in texels of the bell that tells voids from clusters, as Ulichney recommends.
const BELL: f64 = 1.5;

/// One in so many texels belongs to the pattern that is evened out first.
const INITIAL: usize = 10;

/// Swaps after which an uneven pattern is taken as it is; evening out ends sooner.
const MOST_SWAPS: usize = 10_000;

/// A tile of ranks in which near thresholds lie far apart.
#[derive(Clone, Debug, PartialEq)]
pub struct BlueNoise {
    /// Row-major, each of 0 to SIDE^2 - 1 once.
    ranks: Vec<usize>,
}

/// Points on a torus with the sum of their bells.
struct Pattern {
    bell: Vec<f64>,
    set: Vec<bool>,
    density: Vec<f64>,
}

impl Pattern {
    fn toggle(&mut self, texel: usize) {
        self.set[texel] = !self.set[texel];
        let sign = if self.set[texel] { 1.0 } else { -1.0 };
        let (x, y) = (texel % SIDE, texel / SIDE);
        for (i, density) in self.density.iter_mut().enumerate() {
            let (dx, dy) = ((i % SIDE + SIDE - x) % SIDE, (i / SIDE + SIDE - y) % SIDE);
            *density += sign * self.bell[dy * SIDE + dx];
        }
    }

    /// The set texel of greatest density, or the free one of least; the first of equal ones.
    fn extreme(&self, set: bool) -> usize {
        let sign = if set { 1.0 } else { -1.0 };
        let candidates = (0..SIDE * SIDE).filter(|&i| self.set[i] == set);
        let better = |best: usize, i: usize| {
            if sign * self.density[i] > sign * self.density[best] { i } else { best }
        };
        candidates.reduce(better).unwrap_or_default()
    }
}

impl BlueNoise {
    /// The tile of a seed.
    pub fn new(seed: u64) -> Self {
        let mut random = Random::stream(seed, 0);
        let bell = (0..SIDE * SIDE).map(|i| {
            let near = |t: usize| t.min(SIDE - t) as f64;
            (-(near(i % SIDE).powi(2) + near(i / SIDE).powi(2)) / (2.0 * BELL * BELL)).exp()
        });
        let count = SIDE * SIDE;
        let mut pattern =
            Pattern { bell: bell.collect(), set: vec![false; count], density: vec![0.0; count] };
        for _ in 0..count / INITIAL {
            let texel = random.below(count);
            if !pattern.set[texel] {
                pattern.toggle(texel);
            }
        }
        for _ in 0..MOST_SWAPS {
            let cluster = pattern.extreme(true);
            pattern.toggle(cluster);
            let void = pattern.extreme(false);
            pattern.toggle(void);
            if void == cluster {
                break;
            }
        }
        let (set, density) = (pattern.set.clone(), pattern.density.clone());
        let points = set.iter().filter(|&&set| set).count();
        let mut ranks = vec![0; count];
        for rank in (0..points).rev() {
            let cluster = pattern.extreme(true);
            pattern.toggle(cluster);
            ranks[cluster] = rank;
        }
        pattern = Pattern { set, density, ..pattern };
        for rank in points..count {
            let void = pattern.extreme(false);
            pattern.toggle(void);
            ranks[void] = rank;
        }
        Self { ranks }
    }

    /// Two numbers in (0, 1) for a pixel; the second one is the first of a pixel half a tile away.
    pub fn at(&self, x: usize, y: usize) -> [f64; 2] {
        let one = |x: usize, y: usize| {
            (self.ranks[(y % SIDE) * SIDE + x % SIDE] as f64 + 0.5) / (SIDE * SIDE) as f64
        };
        [one(x, y), one(x + SIDE / 2, y + SIDE / 2)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Neighbours differ more than in white noise, and every value occurs once.
    #[test]
    fn neighbours_differ() {
        let noise = BlueNoise::new(1);
        let mut ranks = noise.ranks.clone();
        ranks.sort_unstable();
        assert!(ranks.iter().enumerate().all(|(i, &rank)| i == rank));
        let differences = (0..SIDE * SIDE).map(|i| {
            let (x, y) = (i % SIDE, i / SIDE);
            (noise.at(x, y)[0] - noise.at(x + 1, y)[0]).abs()
        });
        let mean = differences.sum::<f64>() / (SIDE * SIDE) as f64;
        // White noise: 1/3.
        assert!(mean > 0.4, "{mean}");
        // Windows of 4 x 4 have nearly the mean of all; white noise has a deviation of 0.072.
        let windows = (0..SIDE * SIDE).map(|i| {
            let cells = (0..16).map(|k| noise.at(i % SIDE + k % 4, i / SIDE + k / 4)[0]);
            (cells.sum::<f64>() / 16.0 - 0.5).powi(2)
        });
        let deviation = (windows.sum::<f64>() / (SIDE * SIDE) as f64).sqrt();
        assert!(deviation < 0.036, "{deviation}");
        assert_eq!(noise, BlueNoise::new(1));
        assert_ne!(noise, BlueNoise::new(2));
    }
}
