//! Decoding images of bounded size.

use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits, RgbaImage};

use crate::colour::{Texture, linear_from_srgb};
use crate::error::FileFault;
use crate::{AlphaTexture, Wrap};

/// Most texels of one image: 8192 x 8192.
pub(super) const MAX_IMAGE_TEXELS: u64 = 1 << 26;
/// Most texels decoded for one scene: the time to decode is the file's choice otherwise.
const MAX_SCENE_TEXELS: u64 = 1 << 31;
/// Most texels of all alpha that is kept for one scene, at a byte each.
const MAX_ALPHA_TEXELS: u64 = 1 << 29;
/// Most texels of all colours that are kept for pictures of one scene; textures are reduced until they fit.
const MAX_COLOUR_TEXELS: u64 = 1 << 23;
/// Longest side of a texture in pictures, which are about as large.
const MAX_COLOUR_SIDE: u32 = 1024;

/// Formats that are read, for messages.
const FORMATS: &str = "PNG, JPEG, WebP, TGA, BMP and DDS are read";

/// The small version of an image for pictures, and its mean.
#[derive(Clone, Debug)]
pub(super) struct Reduced {
    /// Linear.
    pub mean: [f32; 3],
    texture: Texture,
}

impl Reduced {
    pub(super) fn wrapped(&self, wrap: [Wrap; 2]) -> Texture {
        Texture { wrap, ..self.texture.clone() }
    }
}

/// Decodes images and counts what they cost.
pub(super) struct Images {
    texels_left: u64,
    alpha_left: u64,
    colour_texels: u64,
}

impl Images {
    /// For a scene with so many textures of colour.
    pub(super) fn new(textured: usize) -> Self {
        let colour_texels = (MAX_COLOUR_TEXELS / (textured as u64).max(1)).max(1);
        Self { texels_left: MAX_SCENE_TEXELS, alpha_left: MAX_ALPHA_TEXELS, colour_texels }
    }

    /// Decodes an image, told apart by its contents, else by the extension of its name; its size is checked before memory is
    /// taken.
    pub(super) fn decode(&mut self, bytes: &[u8], name: &str, at: &str) -> Result<RgbaImage, FileFault> {
        let invalid = |error: image::ImageError| match error {
            image::ImageError::Unsupported(error) => {
                FileFault::unsupported(at, format!("image: {error} ({FORMATS})"))
            }
            error => FileFault::invalid(at, format!("image: {error}")),
        };
        if bytes.starts_with(b"\xabKTX 20\xbb\r\n\x1a\n") {
            let format = "image: KTX 2 with Basis Universal textures";
            return Err(FileFault::unsupported(at, format!("{format} ({FORMATS})")));
        }
        let mut reader = ImageReader::new(Cursor::new(bytes))
            .with_guessed_format()
            .map_err(|error| invalid(error.into()))?;
        // TGA begins like nothing else.
        let is_tga = Path::new(name).extension().is_some_and(|e| e.eq_ignore_ascii_case("tga"));
        if reader.format().is_none() && is_tga {
            reader.set_format(ImageFormat::Tga);
        }
        if reader.format().is_none() {
            return Err(FileFault::unsupported(at, format!("image: its format is not known ({FORMATS})")));
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
        let image = DynamicImage::from_decoder(decoder).map_err(invalid)?.into_rgba8();
        if image.width() == 0 || image.height() == 0 {
            return Err(FileFault::invalid(at, "image: it has no texels"));
        }
        Ok(image)
    }

    /// What pictures need of an image.
    pub(super) fn reduced(&self, image: &RgbaImage) -> Reduced {
        let texels = |[width, height]: [u32; 2]| u64::from(width) * u64::from(height);
        let mut size = [image.width(), image.height()];
        while size[0].max(size[1]) > MAX_COLOUR_SIDE || texels(size) > self.colour_texels {
            if size == [1, 1] {
                break;
            }
            size = size.map(|side| side.div_ceil(2));
        }
        Reduced { mean: mean_albedo(image), texture: Texture::reduced(image, size) }
    }

    /// The alpha of an image; `None` where it is opaque.
    pub(super) fn alpha(&mut self, image: &RgbaImage, at: &str) -> Result<Option<AlphaTexture>, FileFault> {
        if image.pixels().all(|texel| texel[3] == 255) {
            return Ok(None);
        }
        let (width, height) = image.dimensions();
        self.keep_alpha(u64::from(width) * u64::from(height), at)?;
        Ok(Some(AlphaTexture { width, height, alpha: image.pixels().map(|texel| texel[3]).collect() }))
    }

    /// Counts alpha that will be kept.
    pub(super) fn keep_alpha(&mut self, texels: u64, at: &str) -> Result<(), FileFault> {
        match self.alpha_left.checked_sub(texels) {
            Some(left) => self.alpha_left = left,
            None => {
                let (at, limit) = (format!("{at}: alpha"), self.alpha_left);
                return Err(FileFault::TooMany { at, what: "texels", count: texels, limit });
            }
        }
        Ok(())
    }
}

/// An image with the same, mirrored, beside it along u and v where it is to be mirrored: repeating it is mirroring the image.
pub(super) fn unfolded(image: &RgbaImage, mirrored: [bool; 2], at: &str) -> Result<RgbaImage, FileFault> {
    let (width, height) = image.dimensions();
    let size = [(width, mirrored[0]), (height, mirrored[1])].map(|(side, m)| u64::from(side) << u32::from(m));
    if size[0] * size[1] > MAX_IMAGE_TEXELS {
        return Err(FileFault::TooMany {
            at: format!("{at}: mirrored image of {} x {}", size[0], size[1]),
            what: "texels",
            count: size[0] * size[1],
            limit: MAX_IMAGE_TEXELS,
        });
    }
    let fold = |t: u32, side: u32| if t < side { t } else { 2 * side - 1 - t };
    Ok(RgbaImage::from_fn(size[0] as u32, size[1] as u32, |x, y| {
        *image.get_pixel(fold(x, width), fold(y, height))
    }))
}

/// Mean colour in linear light of sRGB texels, ignoring those that are fully transparent (their colour is
/// never seen) unless all are.
fn mean_albedo(image: &RgbaImage) -> [f32; 3] {
    let linear: [f64; 256] = std::array::from_fn(|i| linear_from_srgb(i as u8));
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
