//! Pictures of a stack: depth and number of layers.

use image::{Rgb, RgbImage};

use crate::ShadowMapStack;
use crate::stack::glyphs::{self, GLYPH_HEIGHT, GLYPH_WIDTH};

/// Colour of empty texels in the depth image: a dark blue, which no depth is.
const EMPTY_DEPTH: Rgb<u8> = Rgb([24, 32, 96]);
/// Colour of empty texels in the layer image: a light grey, which no layer count is.
const EMPTY_LAYERS: Rgb<u8> = Rgb([224, 224, 224]);
const PAPER: Rgb<u8> = Rgb([255, 255, 255]);
const INK: Rgb<u8> = Rgb([0, 0, 0]);

/// Corners of the ramp for layer counts, from few to many: lightness rises throughout, and hue runs from blue over
/// green to yellow, which stays apart under all common colour vision deficiencies.
const RAMP: [[f32; 3]; 6] = [
    [0.16, 0.07, 0.33],
    [0.19, 0.25, 0.52],
    [0.15, 0.43, 0.55],
    [0.18, 0.62, 0.51],
    [0.53, 0.79, 0.33],
    [0.97, 0.91, 0.20],
];

/// Colour of `t` in [0, 1] (clamped) on the ramp from dark blue to bright yellow.
fn ramp_color(t: f32) -> Rgb<u8> {
    let position = t.clamp(0.0, 1.0) * (RAMP.len() - 1) as f32;
    let lower = (position as usize).min(RAMP.len() - 2);
    let fraction = position - lower as f32;
    let channel = |k: usize| RAMP[lower][k] + fraction * (RAMP[lower + 1][k] - RAMP[lower][k]);
    Rgb([0, 1, 2].map(|k| (255.0 * channel(k) + 0.5) as u8))
}

/// Layer 0 as grey values, one pixel a texel: white at depth 0 (nearest to the light) to a grey of 16 at depth 1;
/// empty texels are dark blue.
pub fn depth_image(stack: &ShadowMapStack) -> RgbImage {
    let depths = stack.shadow_map();
    RgbImage::from_fn(stack.width, stack.height, |x, y| {
        depths[y as usize * stack.width as usize + x as usize].map_or(EMPTY_DEPTH, |depth| {
            let grey = (255.0 - 239.0 * depth + 0.5) as u8;
            Rgb([grey; 3])
        })
    })
}

/// Number of layers as colours from dark blue (1) to yellow (the maximum), one pixel a texel, empty texels light
/// grey, with a scale bar to the right. Colours and scale are logarithmic: few texels have many layers. The picture is
/// wider than the map, and at least 96 pixels high.
pub fn layer_count_image(stack: &ShadowMapStack) -> RgbImage {
    const GAP: u32 = 8;
    const BAR: u32 = 16;
    let max = stack.layer_statistics().max;
    let color = |count: u32| match count {
        0 => EMPTY_LAYERS,
        1 if max == 1 => ramp_color(1.0),
        _ => ramp_color((count as f32).ln() / (max as f32).ln()),
    };
    let label_width = max.to_string().len() as u32 * (GLYPH_WIDTH + 2);
    let height = stack.height.max(96);
    let bar_x = stack.width + GAP;
    let mut picture = RgbImage::from_pixel(bar_x + BAR + 4 + label_width + GAP, height, PAPER);
    for (texel, count) in stack.layer_counts().enumerate() {
        let (x, y) = (texel as u32 % stack.width, texel as u32 / stack.width);
        picture.put_pixel(x, y, color(count));
    }
    // Emptiness at the bottom, the largest count on top.
    let scale = Scale { top: GLYPH_HEIGHT, bottom: height - 3 * GLYPH_HEIGHT, max };
    for y in scale.top..height - GLYPH_HEIGHT {
        for x in bar_x..bar_x + BAR {
            picture.put_pixel(x, y, color(scale.count(y)));
        }
    }
    for (count, middle) in scale.labels() {
        for x in bar_x + BAR..bar_x + BAR + 3 {
            picture.put_pixel(x, middle, INK);
        }
        glyphs::draw_number(&mut picture, bar_x + BAR + 5, middle - GLYPH_HEIGHT / 2, count, INK);
    }
    picture
}

/// Counts from 1 to `max` along a bar of the pixel rows from `top` to `bottom`, each from ln(count) to ln(count + 1).
struct Scale {
    top: u32,
    bottom: u32,
    max: u32,
}

impl Scale {
    /// The count that a row stands for; 0 below the bottom, and everywhere if there is no other.
    fn count(&self, y: u32) -> u32 {
        if y >= self.bottom || self.max == 0 {
            return 0;
        }
        let part = (f64::from(self.bottom - y) - 0.5) / f64::from(self.bottom - self.top);
        ((f64::from(self.max) + 1.0).powf(part) as u32).clamp(1, self.max)
    }

    /// Labelled counts and their rows: 0, the maximum, then round numbers first, as many as there is room for.
    fn labels(&self) -> Vec<(u32, u32)> {
        let mut labels = vec![(0, self.bottom + GLYPH_HEIGHT)];
        let decades = (0..10).flat_map(|power| [1, 2, 5].map(|factor| factor * 10_u64.pow(power)));
        let round = decades.filter_map(|count| u32::try_from(count).ok());
        for count in [self.max].into_iter().chain(round).chain(1..20).filter(|c| (1..=self.max).contains(c)) {
            let position = |count: f64| count.ln() / (f64::from(self.max) + 1.0).ln();
            let part = 0.5 * (position(f64::from(count)) + position(f64::from(count) + 1.0));
            let row = self.bottom - 1 - (part * f64::from(self.bottom - self.top)) as u32;
            if labels.iter().all(|&(_, other)| row.abs_diff(other) >= GLYPH_HEIGHT + 4) {
                labels.push((count, row));
            }
        }
        labels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lightness(c: Rgb<u8>) -> f32 {
        let [r, g, b] = c.0.map(f32::from);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    fn stack() -> ShadowMapStack {
        // Texels with 0, 1 and 3 layers.
        ShadowMapStack {
            width: 3,
            height: 1,
            offsets: vec![0, 0, 1, 4],
            depths: vec![0.0, 1.0, 1.0, 1.0],
            gradients: vec![[0.0; 2]; 4],
            light_facing: [true; 4].into_iter().collect(),
            opacities: Vec::new(),
        }
    }

    #[test]
    fn ramp_grows_lighter() {
        let values: Vec<f32> = (0..=100).map(|i| lightness(ramp_color(i as f32 / 100.0))).collect();
        assert!(values.windows(2).all(|w| w[0] <= w[1]));
        assert!(values[0] < 50.0 && values[100] > 200.0);
    }

    #[test]
    fn depth_is_bright_near_the_light() {
        let image = depth_image(&stack());
        let pixels: Vec<_> = image.pixels().copied().collect();
        assert_eq!(pixels, [EMPTY_DEPTH, Rgb([255; 3]), Rgb([16; 3])]);
    }

    #[test]
    fn layer_counts_have_a_legend() {
        let image = layer_count_image(&stack());
        assert!(image.width() > 40 && image.height() == 96);
        let row: Vec<_> = (0..3).map(|x| *image.get_pixel(x, 0)).collect();
        assert_eq!(row, [EMPTY_LAYERS, ramp_color(0.0), ramp_color(1.0)]);
        // The bar shows every count's colour, and there is ink for ticks and digits.
        for color in [EMPTY_LAYERS, ramp_color(0.0), ramp_color(2f32.ln() / 3f32.ln()), ramp_color(1.0), INK]
        {
            assert!(image.enumerate_pixels().any(|(x, _, p)| x > 3 && *p == color), "{color:?}");
        }
    }

    #[test]
    fn scales_label_their_ends_without_overlap() {
        for max in [0, 1, 2, 7, 38, 113, 4000, u32::MAX] {
            for bottom in [66, 1000, 8000] {
                let scale = Scale { top: 10, bottom, max };
                let labels = scale.labels();
                assert!(labels.iter().any(|l| l.0 == 0) && labels.iter().any(|l| l.0 == max), "{labels:?}");
                let mut rows: Vec<u32> = labels.iter().map(|l| l.1).collect();
                rows.sort();
                assert!(rows.windows(2).all(|w| w[1] - w[0] > GLYPH_HEIGHT), "{max}: {labels:?}");
                assert!(rows[0] >= 10, "{labels:?}");
                if max < 4000 && bottom == 1000 {
                    assert!(labels.iter().all(|&(count, row)| scale.count(row) == count), "{labels:?}");
                }
            }
        }
    }

    #[test]
    fn an_empty_stack_has_a_picture() {
        let empty = ShadowMapStack { width: 2, height: 1, offsets: vec![0; 3], ..Default::default() };
        assert!(layer_count_image(&empty).pixels().any(|p| *p == INK));
    }
}
