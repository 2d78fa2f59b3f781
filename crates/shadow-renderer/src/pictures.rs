//! Pictures of a stack: depth and number of layers.

use image::{Rgb, RgbImage};

use crate::ShadowMapStack;
use crate::glyphs::{self, GLYPH_HEIGHT, GLYPH_WIDTH};

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
pub fn ramp_color(t: f32) -> Rgb<u8> {
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
/// grey, with a scale bar to the right. The picture is wider than the map, and at least 96 pixels high.
pub fn layer_count_image(stack: &ShadowMapStack) -> RgbImage {
    const GAP: u32 = 8;
    const BAR: u32 = 16;
    let max = stack.layer_statistics().max;
    let color = |count: u32| match count {
        0 => EMPTY_LAYERS,
        1 => ramp_color(if max == 1 { 1.0 } else { 0.0 }),
        _ => ramp_color((count - 1) as f32 / (max - 1) as f32),
    };
    let label_width = max.max(1).to_string().len() as u32 * (GLYPH_WIDTH + 2);
    let height = stack.height.max(96);
    let bar_x = stack.width + GAP;
    let mut picture = RgbImage::from_pixel(bar_x + BAR + 4 + label_width + GAP, height, PAPER);
    for (texel, count) in stack.layer_counts().enumerate() {
        let (x, y) = (texel as u32 % stack.width, texel as u32 / stack.width);
        picture.put_pixel(x, y, color(count));
    }
    // One equal piece of the bar a count, the largest on top, emptiness at the bottom.
    let (top, bottom) = (GLYPH_HEIGHT, height - GLYPH_HEIGHT);
    let pieces = max + 1;
    let length = bottom - top;
    for y in top..bottom {
        let count = (u64::from(bottom - 1 - y) * u64::from(pieces) / u64::from(length)) as u32;
        for x in bar_x..bar_x + BAR {
            picture.put_pixel(x, y, color(count));
        }
    }
    for count in (0..pieces).step_by(tick_step(max, length) as usize) {
        let from_bottom = (f64::from(count) + 0.5) * f64::from(length) / f64::from(pieces);
        let middle = bottom - 1 - from_bottom as u32;
        for x in bar_x + BAR..bar_x + BAR + 3 {
            picture.put_pixel(x, middle, INK);
        }
        glyphs::draw_number(&mut picture, bar_x + BAR + 5, middle - GLYPH_HEIGHT / 2, count, INK);
    }
    picture
}

/// Least of 1, 2, 5, 10, 20, .. that keeps the labels of a scale of `length` pixels apart.
fn tick_step(max: u32, length: u32) -> u32 {
    let most_labels = (length / (GLYPH_HEIGHT + 4)).clamp(2, 12);
    let mut power = 1u32;
    loop {
        for factor in [1, 2, 5] {
            let step = power.saturating_mul(factor);
            if max / step < most_labels {
                return step;
            }
        }
        power = power.saturating_mul(10);
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
        for color in [EMPTY_LAYERS, ramp_color(0.0), ramp_color(0.5), ramp_color(1.0), INK] {
            assert!(image.enumerate_pixels().any(|(x, _, p)| x > 3 && *p == color), "{color:?}");
        }
    }

    #[test]
    fn tick_steps_are_round_and_few() {
        assert_eq!([0, 5, 11, 12, 25, 130, 4000].map(|max| tick_step(max, 1000)), [1, 1, 1, 2, 5, 20, 500]);
        assert!((1..200).all(|length| tick_step(u32::MAX, length) > 0));
    }
}
