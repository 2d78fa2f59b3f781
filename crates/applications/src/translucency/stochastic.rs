//! Stochastic shadow maps (Enderton et al. 2010): each sample of a texel keeps a surface with the probability of its opacity.

use random_stream::Random;
use rayon::prelude::*;
use shadow_filtering::Kernel;

use super::LayeredMap;

/// Depths of the nearest kept surface of each sample; 1 where none was kept.
pub struct StochasticMap {
    width: usize,
    height: usize,
    samples: usize,
    depths: Vec<f32>,
}

impl StochasticMap {
    /// Draws `samples` samples a texel. Of n samples a surface is kept in alpha n, rounded up or down at random, so that
    /// their mean is alpha and noise is as small as it can be; which samples these are is random too.
    pub fn new(map: &LayeredMap, samples: usize, seed: u64) -> Self {
        let [width, height] = map.size();
        let mut depths = vec![1.0f32; width * height * samples];
        depths.par_chunks_mut(samples).enumerate().for_each(|(texel, nearest)| {
            let mut random = Random::substream(seed, texel as u64, samples as u64);
            let mut places: Vec<usize> = (0..samples).collect();
            let mut open = samples;
            let mut is_open = vec![true; samples];
            for layer in map.layers(texel) {
                let kept = (layer.opacity() * samples as f64 + random.unit()).floor() as usize;
                for k in 0..kept.min(samples) {
                    let other = k + random.below(samples - k);
                    places.swap(k, other);
                    if is_open[places[k]] {
                        is_open[places[k]] = false;
                        nearest[places[k]] = layer.depth() as f32;
                        open -= 1;
                    }
                }
                if open == 0 {
                    break;
                }
            }
        });
        Self { width, height, samples, depths }
    }

    /// Samples a texel.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Percentage-closer filtering of all samples at a depth; beyond the border those of the nearest texels.
    pub fn shadow(&self, kernel: &Kernel, [x, y]: [usize; 2], z: f64) -> f64 {
        let inside = |t: isize, size: usize| t.clamp(0, size as isize - 1) as usize;
        let taps = kernel.taps().map(|(i, j, weight)| {
            let texel = inside(y as isize + j, self.height) * self.width + inside(x as isize + i, self.width);
            let of_texel = &self.depths[texel * self.samples..(texel + 1) * self.samples];
            let in_front = of_texel.iter().filter(|&&depth| f64::from(depth) < z).count();
            weight * in_front as f64 / self.samples as f64
        });
        taps.sum::<f64>().min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 40;

    #[test]
    fn shadows_are_right_in_the_mean_and_noise_falls_with_samples() {
        let texel = [(0.2, 0.3), (0.5, 0.6), (0.7, 1.0)];
        let offsets = (0..=(SIDE * SIDE) as u32).map(|t| 3 * t).collect();
        let layers = texel.into_iter().cycle().take(3 * SIDE * SIDE);
        let map = LayeredMap::new([SIDE; 2], offsets, layers).unwrap();
        let kernel = Kernel::uniform(1).unwrap();
        let mut spreads = Vec::new();
        for samples in [1, 4, 16] {
            let drawn = StochasticMap::new(&map, samples, 9);
            for (z, expected) in [(0.1, 0.0), (0.3, 0.3), (0.6, 0.72), (0.8, 1.0)] {
                let all: Vec<f64> =
                    (0..SIDE * SIDE).map(|t| drawn.shadow(&kernel, [t % SIDE, t / SIDE], z)).collect();
                let mean = all.iter().sum::<f64>() / all.len() as f64;
                // Five standard deviations of a single sample.
                assert!((mean - expected).abs() < 5.0 * 0.5 / SIDE as f64, "{samples}, {z}: {mean}");
                if z == 0.6 {
                    spreads.push(all.iter().map(|value| (value - mean).abs()).sum::<f64>());
                }
            }
        }
        assert!(spreads[0] > 2.0 * spreads[1] && spreads[1] > 1.5 * spreads[2], "{spreads:?}");
    }
}
