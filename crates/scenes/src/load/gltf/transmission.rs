//! `KHR_materials_transmission`: what passes through a thin surface, before reflection.

use std::sync::Arc;

use image::RgbaImage;

use super::accessor::entry;
use super::json::{Material, TextureInfo};
use super::material::{Materials, UvMap, sources, wraps};
use crate::AlphaTexture;
use crate::Wrap;
use crate::error::FileFault;
use crate::load::source::Folder;
use crate::load::warnings::{WarningKind, Warnings};

/// What a material transmits: red, green and blue shares, and their factor over the surface with its coordinates.
#[derive(Default)]
pub(super) struct Transmission {
    pub shares: [f32; 3],
    pub texture: Option<Arc<AlphaTexture>>,
    pub uv_map: Option<UvMap>,
}

/// Channels of an image.
const RED: usize = 0;
const BLUE: usize = 2;

impl Materials<'_> {
    /// The share is transmission times base colour times what is no metal; the base colour counts by its mean, and so does a
    /// texture whose coordinates are not those of the base colour, as a surface has one pair of coordinates.
    pub(super) fn transmission(
        &mut self,
        source: &Material,
        (albedo, base): ([f32; 3], Option<&TextureInfo>),
        at: &str,
        folder: &mut Folder,
        warnings: &mut Warnings,
    ) -> Result<Option<Transmission>, FileFault> {
        let Some(given) = source.extensions.as_ref().and_then(|e| e.transmission.as_ref()) else {
            return Ok(None);
        };
        let factor = share(given.transmission_factor.unwrap_or(0.0), "transmissionFactor", at, warnings)?;
        if factor == 0.0 {
            return Ok(None);
        }
        let (metal, metal_texture) = match &source.pbr_metallic_roughness {
            Some(of) => (of.metallic_factor.unwrap_or(1.0), of.metallic_roughness_texture.as_ref()),
            None => (1.0, None),
        };
        let metal = share(metal, "metallicFactor", at, warnings)?;
        let metal_image = if metal > 0.0 { self.channel(metal_texture, folder, warnings)? } else { None };
        let metal = metal * metal_image.map_or(1.0, |image| mean(&image, BLUE));
        let (mut texture, mut uv_map, mut red) = (None, None, 1.0);
        if let Some(info) = given.transmission_texture.as_ref()
            && let Some(image) = self.channel(Some(info), folder, warnings)?
        {
            let own = UvMap::unscaled(info, at)?;
            let shared = match base {
                Some(base) => {
                    let alike = self.wraps_of(info)? == self.wraps_of(base)?;
                    alike && UvMap::unscaled(base, at)? == own
                }
                None => true,
            };
            if shared && !self.wraps_of(info)?.contains(&Wrap::Mirror) {
                let texels = u64::from(image.width()) * u64::from(image.height());
                self.images.keep_alpha(texels, at)?;
                let alpha = image.pixels().map(|texel| texel[RED]).collect();
                let (width, height) = image.dimensions();
                texture = Some(Arc::new(AlphaTexture { width, height, alpha }));
                uv_map = Some(own);
            } else {
                red = mean(&image, RED);
                warnings.add(WarningKind::TextureCoordinates, at, || {
                    format!("{at}: transmissionTexture has other coordinates than the base colour, and counts by its mean")
                });
            }
        }
        let shares = albedo.map(|c| (factor * red * (1.0 - metal) * f64::from(c)).clamp(0.0, 1.0) as f32);
        Ok((shares != [0.0; 3]).then_some(Transmission { shares, texture, uv_map }))
    }

    fn wraps_of(&self, info: &TextureInfo) -> Result<[Wrap; 2], FileFault> {
        let texture = entry(&self.root.textures, info.index, "textures")?;
        Ok(wraps(self.root, texture))
    }

    /// An image of which a channel counts; `None`, with a warning, where it cannot be read.
    fn channel(
        &mut self,
        info: Option<&TextureInfo>,
        folder: &mut Folder,
        warnings: &mut Warnings,
    ) -> Result<Option<RgbaImage>, FileFault> {
        let Some(info) = info else { return Ok(None) };
        let mut fault = None;
        for source in sources(entry(&self.root.textures, info.index, "textures")?).into_iter().flatten() {
            match self.image(source, folder) {
                Ok(image) => return Ok(Some(image)),
                Err(error @ FileFault::TooMany { .. }) => return Err(error),
                Err(error) => fault = fault.or(Some(error)),
            }
        }
        warnings.add(WarningKind::MissingTexture, &format!("{}", info.index.0), || match fault {
            Some(fault) => format!("{fault}: its materials transmit alike everywhere"),
            None => {
                format!("textures[{}] has no image: its materials transmit alike everywhere", info.index.0)
            }
        });
        Ok(None)
    }
}

fn mean(image: &RgbaImage, channel: usize) -> f64 {
    let sum: u64 = image.pixels().map(|texel| u64::from(texel[channel])).sum();
    sum as f64 / (255.0 * f64::from(image.width()) * f64::from(image.height()))
}

/// A number that must be finite, moved into \[0, 1\].
fn share(value: f64, key: &str, at: &str, warnings: &mut Warnings) -> Result<f64, FileFault> {
    if !value.is_finite() {
        return Err(FileFault::invalid(at, format!("{key} {value} is not finite")));
    }
    if !(0.0..=1.0).contains(&value) {
        warnings.add(WarningKind::OutOfRange, key, || format!("{at}: {key} {value} is moved into [0, 1]"));
    }
    Ok(value.clamp(0.0, 1.0))
}
