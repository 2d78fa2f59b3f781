//! Pictures in fewer bytes for the page.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use image::RgbImage;
use rayon::prelude::*;
use std::collections::HashMap;
use webp::{Encoder, WebPConfig};

const PNG: &str = "data:image/png;base64,";

/// Pictures of scenes are recorded with three channels; maps of errors have a palette or one channel. The byte of a PNG's
/// header that says so, and its value for three channels.
const COLOUR_TYPE: (usize, u8) = (25, 2);

/// Channels of pictures of scenes are rounded to multiples of this: at most two steps of 255 are lost, less than can be seen,
/// and half the bytes. Equal pixels stay equal, so that differences between techniques remain what they are.
const STEP: u8 = 4;

/// Effort: four times as much saves a hundredth.
const METHOD: i32 = 1;
const QUALITY: f32 = 50.0;

/// The page with every PNG as WebP without loss, apart from [`STEP`].
pub(super) fn compact(page: &str) -> String {
    let mut pieces = page.split(PNG);
    let first = pieces.next().unwrap_or_default();
    let pieces: Vec<(&str, &str)> =
        pieces.map(|piece| piece.split_at(piece.find(|c| !is_digit(c)).unwrap_or(piece.len()))).collect();
    let mut distinct: Vec<&str> = pieces.iter().map(|(picture, _)| *picture).collect();
    distinct.sort_unstable();
    distinct.dedup();
    let smaller: HashMap<&str, String> =
        distinct.par_iter().filter_map(|picture| Some((*picture, smaller(picture)?))).collect();
    let mut out = first.to_owned();
    for (picture, rest) in pieces {
        match smaller.get(picture) {
            Some(address) => out += address,
            None => out.extend([PNG, picture]),
        }
        out += rest;
    }
    out
}

/// Whether a character is one of base 64.
fn is_digit(c: char) -> bool {
    c.is_ascii_alphanumeric() || matches!(c, '+' | '/' | '=')
}

/// Nothing where it would not be smaller, or is no picture.
fn smaller(picture: &str) -> Option<String> {
    let png = STANDARD.decode(picture).ok()?;
    let decoded = image::load_from_memory(&png).ok()?;
    let webp = if decoded.color().has_alpha() {
        let pixels = decoded.into_rgba8();
        encoded(&Encoder::from_rgba(&pixels, pixels.width(), pixels.height()))
    } else {
        let mut pixels = decoded.into_rgb8();
        if png.get(COLOUR_TYPE.0) == Some(&COLOUR_TYPE.1) {
            round(&mut pixels);
        }
        encoded(&Encoder::from_rgb(&pixels, pixels.width(), pixels.height()))
    }?;
    (webp.len() < png.len()).then(|| format!("data:image/webp;base64,{}", STANDARD.encode(webp)))
}

fn encoded(encoder: &Encoder<'_>) -> Option<Vec<u8>> {
    let mut config = WebPConfig::new().ok()?;
    config.lossless = 1;
    config.method = METHOD;
    config.quality = QUALITY;
    config.exact = 1;
    Some(encoder.encode_advanced(&config).ok()?.to_vec())
}

fn round(pixels: &mut RgbImage) {
    for channel in pixels.iter_mut() {
        let step = u16::from(STEP);
        // White stays white.
        *channel = ((u16::from(*channel) + step / 2) / step * step).min(u16::from(u8::MAX)) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{GrayImage, ImageFormat, Luma, Rgb};
    use std::io::Cursor;

    fn png(picture: &image::DynamicImage) -> String {
        let mut bytes = Vec::new();
        picture.write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png).unwrap();
        format!("{PNG}{}", STANDARD.encode(bytes))
    }

    fn shown(page: &str) -> RgbImage {
        let data = page.split("base64,").nth(1).unwrap().split(|c| !is_digit(c)).next().unwrap();
        image::load_from_memory(&STANDARD.decode(data).unwrap()).unwrap().to_rgb8()
    }

    /// Noise, so that no format is much smaller.
    fn value(x: u32, y: u32) -> u8 {
        (x.wrapping_mul(2_654_435_761) ^ y.wrapping_mul(40_503)).to_le_bytes()[1]
    }

    #[test]
    fn maps_of_errors_are_kept_exactly() {
        let map = GrayImage::from_fn(64, 64, |x, y| Luma([if x % 7 == 0 { value(x, y) } else { 128 }]));
        let page = format!("<i data=\"[{}&quot;]\"> and more", png(&map.clone().into()));
        let small = compact(&page);
        assert!(small.contains("image/webp") && small.ends_with("&quot;]\"> and more"), "{small}");
        assert_eq!(shown(&small), image::DynamicImage::from(map).to_rgb8());
    }

    #[test]
    fn pictures_of_scenes_lose_at_most_half_a_step() {
        let picture = RgbImage::from_fn(64, 64, |x, y| {
            let v = value(x / 8, y / 8);
            Rgb([v, v / 2, if x < 32 { 255 } else { v }])
        });
        let small = compact(&format!("<img src=\"{}\">", png(&picture.clone().into())));
        assert!(small.contains("image/webp"), "{small}");
        let shown = shown(&small);
        for (before, after) in picture.iter().zip(shown.iter()) {
            assert!(before.abs_diff(*after) <= STEP / 2, "{before} {after}");
            assert!(*before != 255 || *after == 255);
        }
        assert_ne!(picture, shown, "nothing was rounded");
    }
}
