//! glTF materials: albedo and alpha test.

use std::sync::Arc;

use gltf::json::material::AlphaMode;
use gltf::json::texture::Info;
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};
use image::RgbaImage;

use super::accessor::{Buffers, out_of_range, view_bytes};
use super::source::Folder;
use super::texture::{Images, mean_albedo};
use crate::error::FileFault;
use crate::{AlphaMask, Material};

/// Which texture coordinates an alpha mask uses, and how they are transformed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UvMap {
    pub set: u32,
    rows: [[f64; 3]; 2],
}

impl UvMap {
    /// Honours `KHR_texture_transform`.
    fn of(info: &Info, at: &str) -> Result<Self, FileFault> {
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        let Some(transform) = transform else {
            return Ok(Self { set: info.tex_coord, rows: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] });
        };
        let (offset, scale) = (transform.offset.0.map(f64::from), transform.scale.0.map(f64::from));
        let (sin, cos) = f64::from(transform.rotation.0).sin_cos();
        let rows =
            [[cos * scale[0], sin * scale[1], offset[0]], [-sin * scale[0], cos * scale[1], offset[1]]];
        if !rows.iter().flatten().all(|c| c.is_finite()) {
            return Err(FileFault::invalid(at, "KHR_texture_transform is not finite"));
        }
        Ok(Self { set: transform.tex_coord.unwrap_or(info.tex_coord), rows })
    }

    pub(super) fn apply(&self, uv: [f64; 2]) -> [f32; 2] {
        self.rows.map(|row| (row[0] * uv[0] + row[1] * uv[1] + row[2]) as f32)
    }
}

/// Materials are converted when a primitive first uses them: textures of the others are never decoded.
pub(super) struct Materials<'a> {
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    folder: &'a mut Folder,
    images: Images,
    /// Scene material and its texture coordinates by glTF material; the last entry is the default material.
    converted: Vec<Option<(u32, Option<UvMap>)>>,
    pub scene: Vec<Material>,
}

impl<'a> Materials<'a> {
    pub(super) fn new(root: &'a Root, buffers: &'a Buffers<'a>, folder: &'a mut Folder) -> Self {
        let converted = vec![None; root.materials.len() + 1];
        Self { root, buffers, folder, images: Images::new(), converted, scene: Vec::new() }
    }

    /// Index into the scene's materials, and what its alpha mask needs from the primitive.
    pub(super) fn index(
        &mut self,
        material: Option<Index<gltf::json::Material>>,
    ) -> Result<(u32, Option<UvMap>), FileFault> {
        let count = self.root.materials.len();
        let slot = material.map_or(count, |index| index.value());
        match self.converted.get(slot) {
            None => Err(out_of_range("materials".into(), slot, count)),
            Some(Some(known)) => Ok(*known),
            Some(None) => {
                let (material, uv_map) = match self.root.materials.get(slot) {
                    Some(_) => self.convert(slot)?,
                    None => (Material { name: "default".into(), albedo: [0.8; 3], mask: None }, None),
                };
                let known = (self.scene.len() as u32, uv_map);
                self.scene.push(material);
                self.converted[slot] = Some(known);
                Ok(known)
            }
        }
    }

    fn convert(&mut self, slot: usize) -> Result<(Material, Option<UvMap>), FileFault> {
        let at = format!("materials[{slot}]");
        let source = &self.root.materials[slot];
        let name = source.name.clone().unwrap_or_else(|| format!("material {slot}"));
        let factor = source.pbr_metallic_roughness.base_color_factor.0;
        if !factor.iter().all(|c| (0.0..=1.0).contains(c)) {
            return Err(FileFault::invalid(at, format!("baseColorFactor {factor:?} is outside [0, 1]")));
        }
        let info = source.pbr_metallic_roughness.base_color_texture.as_ref();
        let image = info.map(|info| self.image(info)).transpose()?;
        let mean = image.as_ref().map_or([1.0; 3], mean_albedo);
        let albedo = std::array::from_fn(|channel| factor[channel] * mean[channel]);
        let mut mask = None;
        if matches!(source.alpha_mode, Checked::Valid(AlphaMode::Mask)) {
            let cutoff = source.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0);
            if !(cutoff.is_finite() && cutoff >= 0.0) {
                return Err(FileFault::invalid(
                    at,
                    format!("alphaCutoff {cutoff} is not a number from 0 up"),
                ));
            }
            mask = alpha_mask(image, factor[3], cutoff);
        }
        let uv_map = match (&mask, info) {
            (Some(_), Some(info)) => Some(UvMap::of(info, &at)?),
            _ => None,
        };
        Ok((Material { name, albedo, mask: mask.map(Arc::new) }, uv_map))
    }

    fn image(&mut self, info: &Info) -> Result<RgbaImage, FileFault> {
        let root = self.root;
        let texture = root
            .get(info.index)
            .ok_or_else(|| out_of_range("textures".into(), info.index.value(), root.textures.len()))?;
        let source = root
            .get(texture.source)
            .ok_or_else(|| out_of_range("images".into(), texture.source.value(), root.images.len()))?;
        let at = format!("images[{}]", texture.source);
        match (source.buffer_view, &source.uri) {
            (Some(view), _) => self.images.decode(view_bytes(root, self.buffers, view)?, &at),
            (None, Some(uri)) => self.images.decode(&self.folder.read_uri(uri, &at)?, &at),
            (None, None) => Err(FileFault::invalid(at, "has neither bufferView nor uri")),
        }
    }
}

/// The mask for texture alpha times `factor` tested against `cutoff`; `None` if the test never fails.
fn alpha_mask(image: Option<RgbaImage>, factor: f32, cutoff: f32) -> Option<AlphaMask> {
    // Texel t passes where t / 255 * factor >= cutoff. The slack absorbs decimal cutoffs such as 0.2 = 51/255.
    let threshold = (255.0 * f64::from(cutoff) / f64::from(factor) - 1e-4).ceil();
    let (width, height, mut alpha) = match image {
        Some(image) => (image.width(), image.height(), image.pixels().map(|texel| texel[3]).collect()),
        None => (1, 1, vec![255]),
    };
    if width == 0 || height == 0 || cutoff <= 0.0 || threshold <= 0.0 {
        return None;
    }
    let mut cutoff = threshold as u8;
    // A factor of 0 makes the threshold infinite: nothing passes.
    if threshold > 255.0 {
        alpha.fill(0);
        cutoff = 1;
    }
    (alpha.iter().any(|&a| a < cutoff)).then_some(AlphaMask { width, height, alpha, cutoff })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> RgbaImage {
        RgbaImage::from_fn(256, 1, |x, _| image::Rgba([0, 0, 0, x as u8]))
    }

    #[test]
    fn the_cutoff_is_the_first_alpha_that_passes() {
        let cutoff = |factor, cutoff| alpha_mask(Some(ramp()), factor, cutoff).unwrap().cutoff;
        assert_eq!(cutoff(1.0, 0.5), 128);
        assert_eq!(cutoff(1.0, 0.2), 51);
        assert_eq!(cutoff(0.5, 0.25), 128);
        assert_eq!(cutoff(1.0, 1.0), 255);
    }

    #[test]
    fn a_test_that_never_or_always_fails_is_no_cutoff() {
        assert_eq!(alpha_mask(Some(ramp()), 1.0, 0.0), None);
        assert_eq!(alpha_mask(None, 1.0, 0.5), None);
        for (factor, cutoff) in [(0.25, 0.5), (0.0, 0.5), (1.0, 1.5)] {
            let mask = alpha_mask(Some(ramp()), factor, cutoff).unwrap();
            assert!(mask.alpha.iter().all(|&a| a < mask.cutoff), "{factor} {cutoff}");
        }
        assert_eq!(alpha_mask(None, 0.2, 0.5).unwrap().alpha, [0]);
    }
}
