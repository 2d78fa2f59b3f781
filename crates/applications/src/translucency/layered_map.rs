//! All surfaces of a light's view by texel, and the truth that follows from them.

use super::{Layer, LayerError};
use crate::application::Application;
use crate::hard_shadow::BiasSetting;
use shadow_filtering::{Kernel, Receiver};

/// Surfaces of each texel, nearest first, with what they leave of the light.
#[derive(Clone, Debug, PartialEq)]
pub struct LayeredMap {
    width: usize,
    height: usize,
    offsets: Vec<u32>,
    layers: Vec<Layer>,
    /// Share of the light behind each layer.
    left: Vec<f64>,
}

impl LayeredMap {
    /// Texels row by row: texel t owns the layers `offsets[t]` to `offsets[t + 1]`, nearest first.
    ///
    /// # Errors
    /// [`LayerError`] for a layer that none can be, and offsets that do not fit the size or the layers.
    pub fn new(
        [width, height]: [usize; 2],
        offsets: Vec<u32>,
        layers: impl Iterator<Item = (f64, f64)>,
    ) -> Result<Self, LayerError> {
        let layers: Vec<Layer> =
            layers.map(|(depth, opacity)| Layer::new(depth, opacity)).collect::<Result<_, _>>()?;
        let is_list = offsets.len() == width * height + 1
            && offsets.first() == Some(&0)
            && offsets.last().is_some_and(|&end| end as usize == layers.len())
            && offsets.windows(2).all(|pair| pair[0] <= pair[1]);
        if !is_list {
            return Err(LayerError::Offsets { texels: width * height, layers: layers.len() });
        }
        let mut left = Vec::with_capacity(layers.len());
        for pair in offsets.windows(2) {
            let mut rest = 1.0;
            for layer in &layers[pair[0] as usize..pair[1] as usize] {
                rest *= 1.0 - layer.opacity();
                left.push(rest);
            }
        }
        Ok(Self { width, height, offsets, layers, left })
    }

    /// Width and height in texels.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Number of layers of all texels.
    pub fn count(&self) -> usize {
        self.layers.len()
    }

    /// Where the layers of a texel stand among all.
    pub fn range(&self, texel: usize) -> std::ops::Range<usize> {
        self.offsets[texel] as usize..self.offsets[texel + 1] as usize
    }

    /// The layers of a texel by its number, nearest first.
    pub fn layers(&self, texel: usize) -> &[Layer] {
        &self.layers[self.range(texel)]
    }

    /// The shadow of a texel's ray at a depth: what layers in front of it take; the far plane takes the rest.
    pub fn shadow(&self, texel: usize, z: f64) -> f64 {
        if z > 1.0 {
            return 1.0;
        }
        let range = self.range(texel);
        let in_front = self.layers[range.clone()].partition_point(|layer| layer.depth() < z);
        if in_front == 0 { 0.0 } else { 1.0 - self.left[range.start + in_front - 1] }
    }

    /// Mean over a kernel of the shadows of its rays, each at its own depth by its offset in texels; beyond the border those of
    /// the nearest texels.
    pub fn filtered(&self, kernel: &Kernel, [x, y]: [usize; 2], compared: impl Fn(f64, f64) -> f64) -> f64 {
        let inside = |t: isize, size: usize| t.clamp(0, size as isize - 1) as usize;
        let radius = kernel.radius() as isize;
        let mut total = 0.0;
        // In the order of percentage-closer filtering, so that opaque layers give the same sums.
        for (j, &v) in (-radius..).zip(kernel.weights()) {
            let row = inside(y as isize + j, self.height) * self.width;
            let mut line = 0.0;
            for (i, &w) in (-radius..).zip(kernel.weights()) {
                let texel = row + inside(x as isize + i, self.width);
                line += w * self.shadow(texel, compared(i as f64, j as f64));
            }
            total += v * line;
        }
        total.min(1.0)
    }
}

/// Filtered shadows of surfaces that let light through, on a lit view.
#[derive(Clone, Copy)]
pub struct TranslucentShadow<'a> {
    /// All surfaces.
    pub map: &'a LayeredMap,
    /// The filter.
    pub kernel: &'a Kernel,
    /// Unit of the constant biases, see [`shadow_filtering::DepthBias`].
    pub texel_depth: f64,
    /// Depth biases.
    pub bias: BiasSetting,
    /// As [`crate::HardShadow::plane_limit`].
    pub plane_limit: f64,
}

impl TranslucentShadow<'_> {
    /// The depth that methods compare at a receiver, in \[0, 1\].
    pub fn compared(&self, receiver: &Receiver) -> f64 {
        self.bias.technique.compared(receiver, self.texel_depth, self.plane_limit)
    }

    /// The mean of shadows at a depth, the same for all taps: what bounds are bounds of, and what deep shadow maps know.
    pub fn at_depth(&self, receiver: &Receiver, z: f64) -> f64 {
        self.map.filtered(self.kernel, [receiver.x, receiver.y], |_, _| z)
    }
}

impl Application for TranslucentShadow<'_> {
    type Receiver = Receiver;

    /// The kernel's mean of 1 - prod (1 - alpha_j) over surfaces in front of the receiver's plane, tap by tap.
    fn truth(&self, receiver: &Receiver) -> f64 {
        let bias = self.bias.reference.depth(receiver, self.texel_depth, self.plane_limit);
        let (base, limit) = (receiver.depth - bias, self.plane_limit);
        let [gx, gy] = receiver.gradient;
        self.map.filtered(self.kernel, [receiver.x, receiver.y], |i, j| {
            base + (gx * i + gy * j).clamp(-limit, limit)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::translucency::in_front;
    use random_stream::Random;
    use shadow_filtering::{DepthBias, DepthMap, Reference};

    const SIDE: usize = 24;

    fn random_map(random: &mut Random, opacity: impl Fn(&mut Random) -> f64) -> LayeredMap {
        let (mut offsets, mut layers) = (vec![0], Vec::new());
        for _ in 0..SIDE * SIDE {
            let mut depths: Vec<f64> =
                (0..random.below(6)).map(|_| f64::from(random.unit() as f32)).collect();
            depths.sort_by(f64::total_cmp);
            layers.extend(depths.into_iter().map(|depth| (depth, opacity(random))));
            offsets.push(layers.len() as u32);
        }
        LayeredMap::new([SIDE; 2], offsets, layers.into_iter()).unwrap()
    }

    fn bias(texels: f64) -> BiasSetting {
        let bias = DepthBias { texels, slopes: 0.5 };
        BiasSetting { reference: bias, technique: bias }
    }

    #[test]
    fn opaque_layers_are_percentage_closer_filtering() {
        let mut random = Random::new(5);
        let map = random_map(&mut random, |_| 1.0);
        let depths = (0..SIDE * SIDE).map(|t| map.layers(t).first().map_or(1.0, |l| l.depth() as f32));
        let depth_map = DepthMap::new(SIDE, SIDE, depths.collect()).unwrap();
        let kernel = Kernel::gaussian(9, 2.4).unwrap();
        let reference = Reference { bias: bias(1.0).reference, plane_limit: 0.05 };
        let view = TranslucentShadow {
            map: &map,
            kernel: &kernel,
            texel_depth: 1e-3,
            bias: bias(1.0),
            plane_limit: 0.05,
        };
        for _ in 0..400 {
            let receiver = Receiver {
                x: random.below(SIDE),
                y: random.below(SIDE),
                depth: random.unit(),
                gradient: [random.within(-0.02, 0.02), random.within(-0.02, 0.02)],
            };
            assert_eq!(view.truth(&receiver), reference.intensity(&depth_map, &kernel, &receiver, 1e-3));
        }
    }

    #[test]
    fn every_tap_multiplies_what_its_surfaces_let_through() {
        let mut random = Random::new(6);
        let map = random_map(&mut random, |random| random.unit());
        let kernel = Kernel::uniform(3).unwrap();
        for _ in 0..200 {
            let (x, y) = (1 + random.below(SIDE - 2), 1 + random.below(SIDE - 2));
            let z = random.unit();
            let taps = kernel.taps().map(|(i, j, weight)| {
                let texel = (y as isize + j) as usize * SIDE + (x as isize + i) as usize;
                weight * in_front(map.layers(texel), z)
            });
            let expected: f64 = taps.sum();
            let found = map.filtered(&kernel, [x, y], |_, _| z);
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
    }

    #[test]
    fn ten_thousand_layers_and_none() {
        let layers = (0..10_000).map(|i| (f64::from(i) / 1e4, 1e-3));
        let map = LayeredMap::new([2, 1], vec![0, 10_000, 10_000], layers).unwrap();
        let expected = 1.0 - 0.999f64.powi(5_000);
        assert!((map.shadow(0, 0.5) - expected).abs() < 1e-12);
        assert_eq!((map.shadow(1, 1.0), map.shadow(1, 1.1)), (0.0, 1.0));
        for offsets in [vec![0, 1], vec![0, 2, 1], vec![1, 1, 1]] {
            assert!(LayeredMap::new([2, 1], offsets, [(0.5, 0.5)].into_iter()).is_err());
        }
    }
}
