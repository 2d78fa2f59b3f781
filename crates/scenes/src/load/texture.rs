//! Decoding PNG and JPEG images of bounded size.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageReader, Limits, RgbaImage};

use crate::error::FileFault;

/// Most texels of one image: 8192 x 8192.
pub(super) const MAX_IMAGE_TEXELS: u64 = 1 << 26;
/// Most texels decoded for one scene: the time to decode is the file's choice otherwise.
const MAX_SCENE_TEXELS: u64 = 1 << 31;

/// Decodes images and counts what they cost.
pub(super) struct Images {
    texels_left: u64,
}

impl Images {
    pub(super) fn new() -> Self {
        Self { texels_left: MAX_SCENE_TEXELS }
    }

    /// Decodes an image, told apart by its contents; its size is checked before memory is taken.
    pub(super) fn decode(&mut self, bytes: &[u8], at: &str) -> Result<RgbaImage, FileFault> {
        let invalid = |error: image::ImageError| match error {
            image::ImageError::Unsupported(error) => {
                FileFault::unsupported(at, format!("image: {error} (PNG and JPEG are read)"))
            }
            error => FileFault::invalid(at, format!("image: {error}")),
        };
        let reader = ImageReader::new(Cursor::new(bytes));
        let reader = reader.with_guessed_format().map_err(|error| invalid(error.into()))?;
        if reader.format().is_none() {
            return Err(FileFault::unsupported(at, "image: neither PNG nor JPEG"));
        }
        let mut decoder = reader.into_decoder().map_err(invalid)?;
        let (width, height) = decoder.dimensions();
        let texels = u64::from(width) * u64::from(height);
        let limit = MAX_IMAGE_TEXELS.min(self.texels_left);
        if texels > limit {
            return Err(FileFault::TooMany {
                at: format!("{at}: image of {width} x {height}"),
                what: "texels",
                count: texels,
                limit,
            });
        }
        self.texels_left -= texels;
        let mut limits = Limits::no_limits();
        // Up to 16 bits for each of four channels, and working space.
        limits.max_alloc = Some(texels * 16 + (16 << 20));
        decoder.set_limits(limits).map_err(invalid)?;
        Ok(DynamicImage::from_decoder(decoder).map_err(invalid)?.into_rgba8())
    }
}

/// Mean colour in linear light of sRGB texels, ignoring those that are fully transparent (their colour is
/// never seen) unless all are.
pub(super) fn mean_albedo(image: &RgbaImage) -> [f32; 3] {
    let linear: [f64; 256] = std::array::from_fn(|i| {
        let s = i as f64 / 255.0;
        if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
    });
    let opaque_only = image.pixels().any(|texel| texel[3] > 0);
    let (mut sum, mut count) = ([0.0; 3], 0_u64);
    for texel in image.pixels().filter(|texel| !opaque_only || texel[3] > 0) {
        for channel in 0..3 {
            sum[channel] += linear[usize::from(texel[channel])];
        }
        count += 1;
    }
    sum.map(|channel| (channel / count.max(1) as f64) as f32)
}
