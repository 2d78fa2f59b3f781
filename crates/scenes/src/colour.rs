//! Textures of colour for pictures, sampled with mip maps; shadows do not depend on them.

use std::sync::Arc;

use image::RgbaImage;

/// What lies beside a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The texture again.
    #[default]
    Repeat,
    /// Its outermost texels.
    Clamp,
    /// The texture again, every other time mirrored.
    Mirror,
}

/// One level of a [`Texture`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MipLevel {
    /// Width in texels, at least 1.
    pub width: u32,
    /// Height in texels, at least 1.
    pub height: u32,
    /// Row-major sRGB.
    pub texels: Vec<[u8; 3]>,
}

/// A texture with its mip maps, each half as wide and high as the one before, down to a single texel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texture {
    /// From the finest to one texel; never empty.
    pub levels: Arc<Vec<MipLevel>>,
    /// Along u and v.
    pub wrap: [Wrap; 2],
}

/// Linear light of an sRGB value (IEC 61966-2-1).
pub(crate) fn linear_from_srgb(value: u8) -> f64 {
    let s = f64::from(value) / 255.0;
    if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}

fn srgb_from_linear(linear: f64) -> u8 {
    let c = linear.clamp(0.0, 1.0);
    let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded + 0.5) as u8
}

/// The texels from `from` on that become texel `i` of `to`.
fn span(i: u32, from: u32, to: u32) -> std::ops::Range<u32> {
    let at = |i: u32| (u64::from(i) * u64::from(from) / u64::from(to)) as u32;
    at(i)..at(i + 1).max(at(i) + 1)
}

impl Texture {
    /// An image in a size that is at most its own, with mip maps; repeating. Texels count by their alpha, as what is
    /// transparent has any colour.
    pub(crate) fn reduced(image: &RgbaImage, [width, height]: [u32; 2]) -> Self {
        let linear: [f64; 256] = std::array::from_fn(|i| linear_from_srgb(i as u8));
        let mut finest = MipLevel { width, height, texels: Vec::with_capacity((width * height) as usize) };
        let whole = image.dimensions() == (width, height);
        for y in 0..height {
            for x in 0..width {
                if whole {
                    let [r, g, b, _] = image.get_pixel(x, y).0;
                    finest.texels.push([r, g, b]);
                    continue;
                }
                let (mut sum, mut plain, mut weight, mut count) = ([0.0; 3], [0.0; 3], 0.0, 0.0);
                for v in span(y, image.height(), height) {
                    for u in span(x, image.width(), width) {
                        let [r, g, b, a] = image.get_pixel(u, v).0;
                        let colour = [r, g, b].map(|c| linear[usize::from(c)]);
                        (0..3).for_each(|k| sum[k] += f64::from(a) * colour[k]);
                        (0..3).for_each(|k| plain[k] += colour[k]);
                        (weight, count) = (weight + f64::from(a), count + 1.0);
                    }
                }
                let (sum, weight) = if weight > 0.0 { (sum, weight) } else { (plain, count) };
                finest.texels.push(sum.map(|c| srgb_from_linear(c / weight)));
            }
        }
        let mut levels = vec![finest];
        while let Some(last) = levels.last().filter(|last| last.width > 1 || last.height > 1) {
            levels.push(last.halved(&linear));
        }
        Self { levels: Arc::new(levels), wrap: [Wrap::Repeat; 2] }
    }

    /// Width and height of the finest level.
    pub fn size(&self) -> [u32; 2] {
        self.levels.first().map_or([1; 2], |level| [level.width, level.height])
    }

    /// Linear RGB at texture coordinates, (0, 0) being the first texel's outer corner, filtered between the four nearest
    /// texels and the two nearest levels; level 0 is the finest.
    pub fn sample(&self, uv: [f64; 2], level: f64) -> [f32; 3] {
        let last = self.levels.len() - 1;
        let level = level.clamp(0.0, last as f64);
        let (below, share) = (level.floor() as usize, level.fract());
        let fine = self.levels[below].bilinear(uv, self.wrap);
        let coarse =
            if share > 0.0 { self.levels[(below + 1).min(last)].bilinear(uv, self.wrap) } else { fine };
        [0, 1, 2].map(|k| (fine[k] + share * (coarse[k] - fine[k])) as f32)
    }
}

impl MipLevel {
    fn halved(&self, linear: &[f64; 256]) -> Self {
        let [width, height] = [self.width, self.height].map(|side| (side / 2).max(1));
        let mut texels = Vec::with_capacity((width * height) as usize);
        for y in 0..height {
            for x in 0..width {
                let (mut sum, mut count) = ([0.0; 3], 0.0);
                for v in span(y, self.height, height) {
                    for u in span(x, self.width, width) {
                        let texel = self.texels[(v * self.width + u) as usize];
                        (0..3).for_each(|k| sum[k] += linear[usize::from(texel[k])]);
                        count += 1.0;
                    }
                }
                texels.push(sum.map(|c| srgb_from_linear(c / count)));
            }
        }
        Self { width, height, texels }
    }

    fn bilinear(&self, uv: [f64; 2], wrap: [Wrap; 2]) -> [f64; 3] {
        let ([x0, x1], s) = neighbours(uv[0], self.width, wrap[0]);
        let ([y0, y1], t) = neighbours(uv[1], self.height, wrap[1]);
        let at = |x: u32, y: u32| self.texels[(y * self.width + x) as usize].map(linear_from_srgb);
        let mix = |a: [f64; 3], b: [f64; 3], t: f64| [0, 1, 2].map(|k| a[k] + t * (b[k] - a[k]));
        mix(mix(at(x0, y0), at(x1, y0), s), mix(at(x0, y1), at(x1, y1), s), t)
    }
}

/// The two texels around a coordinate along a side, and how far it is from the first to the second.
fn neighbours(coordinate: f64, size: u32, wrap: Wrap) -> ([u32; 2], f64) {
    let side = f64::from(size);
    // Whole repetitions are taken off while numbers are small.
    let within = match wrap {
        Wrap::Repeat => coordinate.rem_euclid(1.0),
        Wrap::Clamp => coordinate.clamp(0.0, 1.0),
        Wrap::Mirror => {
            let t = coordinate.rem_euclid(2.0);
            if t > 1.0 { 2.0 - t } else { t }
        }
    };
    let at = within * side - 0.5;
    let first = at.floor();
    let place = |i: f64| match wrap {
        Wrap::Repeat => i.rem_euclid(side) as u32 % size,
        Wrap::Clamp | Wrap::Mirror => i.clamp(0.0, side - 1.0) as u32,
    };
    ([place(first), place(first + 1.0)], at - first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgba;

    fn stripes() -> Texture {
        let image = RgbaImage::from_fn(4, 2, |x, _| Rgba([if x < 2 { 0 } else { 255 }; 4]));
        Texture::reduced(&image, [4, 2])
    }

    #[test]
    fn wrapping_decides_what_lies_beside() {
        let red = |wrap: Wrap, u: f64| Texture { wrap: [wrap; 2], ..stripes() }.sample([u, 0.5], 0.0)[0];
        assert_eq!([0.25, 0.75].map(|u| red(Wrap::Repeat, u)), [0.0, 1.0]);
        assert_eq!([1.25, -0.25].map(|u| red(Wrap::Repeat, u)), [0.0, 1.0]);
        assert_eq!([1.25, -0.25].map(|u| red(Wrap::Clamp, u)), [1.0, 0.0]);
        assert_eq!([1.25, 1.75, -0.25].map(|u| red(Wrap::Mirror, u)), [1.0, 0.0, 0.0]);
        assert_eq!([0.0, 0.5, 1.0].map(|u| red(Wrap::Repeat, u)), [0.5; 3]);
        assert_eq!(red(Wrap::Clamp, 1.0), 1.0);
    }

    #[test]
    fn coarse_levels_are_means_in_linear_light() {
        let texture = stripes();
        assert_eq!(texture.levels.len(), 3);
        let mean = texture.sample([0.1, 0.9], 9.0);
        assert!((mean[0] - 0.5).abs() < 0.005, "{mean:?}");
        let half = Texture::reduced(&RgbaImage::from_pixel(5, 3, Rgba([200, 10, 0, 255])), [2, 1]);
        assert_eq!(half.levels[0].texels, [[200, 10, 0]; 2]);
    }

    #[test]
    fn what_is_transparent_lends_no_colour() {
        let image = RgbaImage::from_fn(2, 1, |x, _| {
            Rgba([if x == 0 { 255 } else { 0 }, 0, 0, if x == 0 { 255 } else { 0 }])
        });
        assert_eq!(Texture::reduced(&image, [1, 1]).levels[0].texels, [[255, 0, 0]]);
    }
}
