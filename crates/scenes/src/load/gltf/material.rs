//! glTF materials: colour, alpha test, opacity.

use std::collections::HashMap;
use std::sync::Arc;

use image::RgbaImage;

use super::accessor::{entry, out_of_range};
use super::buffers::Buffers;
use super::json::{Root, TextureInfo, Whole};
use crate::error::FileFault;
use crate::load::alpha::{OPAQUE_FROM, alpha_mask};
use crate::load::cut::Cutting;
use crate::load::source::Folder;
use crate::load::texture::{Images, Reduced, unfolded};
use crate::load::warnings::{WarningKind, Warnings};
use crate::{AlphaTexture, Material, Opacity, Wrap};

/// Which texture coordinates a material uses, and how they are transformed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UvMap {
    pub set: u64,
    /// Whether the scene cannot be right without them.
    pub needed: bool,
    rows: [[f64; 3]; 2],
}

impl UvMap {
    /// Honours `KHR_texture_transform`.
    fn of(info: &TextureInfo, scale: [f64; 2], at: &str) -> Result<Self, FileFault> {
        let map = Self::unscaled(info, at)?;
        Ok(Self { rows: [0, 1].map(|k| map.rows[k].map(|c| c * scale[k])), ..map })
    }

    pub(super) fn unscaled(info: &TextureInfo, at: &str) -> Result<Self, FileFault> {
        let transform = info.extensions.as_ref().and_then(|e| e.transform.as_ref());
        let set = info.tex_coord.unwrap_or_default().0;
        let Some(transform) = transform else {
            return Ok(Self { set, needed: false, rows: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] });
        };
        let (offset, scale) = (transform.offset.unwrap_or([0.0; 2]), transform.scale.unwrap_or([1.0; 2]));
        let (sin, cos) = transform.rotation.unwrap_or(0.0).sin_cos();
        let rows =
            [[cos * scale[0], sin * scale[1], offset[0]], [-sin * scale[0], cos * scale[1], offset[1]]];
        if !rows.iter().flatten().all(|c| (*c as f32).is_finite()) {
            return Err(FileFault::invalid(at, "KHR_texture_transform is not finite"));
        }
        Ok(Self { set: transform.tex_coord.map_or(set, |set| set.0), needed: false, rows })
    }

    pub(super) fn apply(&self, uv: [f64; 2]) -> [f32; 2] {
        self.rows.map(|row| (row[0] * uv[0] + row[1] * uv[1] + row[2]) as f32)
    }
}

/// A test of opacity, which vertices' alpha takes part in.
#[derive(Clone, Debug)]
struct AlphaTest {
    texels: Option<Arc<AlphaTexture>>,
    factor: f64,
    cutoff: f64,
    cutting: Cutting,
}

/// The texture of a material's colour.
struct Base {
    /// Where it is asked for and not 1 throughout.
    alpha: Option<Arc<AlphaTexture>>,
    wrap: [Wrap; 2],
    /// Of the texture coordinates, as the image may have become larger.
    scale: [f64; 2],
    reduced: Reduced,
}

/// A glTF material in the scene.
#[derive(Clone, Debug)]
pub(super) struct Converted {
    pub material: u32,
    pub uv_map: Option<UvMap>,
    test: Option<AlphaTest>,
}

impl Converted {
    /// Where triangles must be cut so that the alpha test is right everywhere; `None` without such a test.
    pub(super) fn cutting(&self) -> Option<&Cutting> {
        self.test.as_ref().map(|test| &test.cutting)
    }
}

/// Materials are converted when a primitive first uses them: textures of the others are never decoded.
pub(super) struct Materials<'a> {
    pub(super) root: &'a Root,
    buffers: &'a Buffers<'a>,
    pub(super) images: Images,
    /// By glTF material; the last entry is the default material.
    converted: Vec<Option<Converted>>,
    /// By glTF material and the threshold that the vertices' alpha makes of its own.
    variants: HashMap<(usize, u8), u32>,
    untextured: HashMap<u32, u32>,
    textures: HashMap<u64, Reduced>,
    pub scene: Vec<Material>,
}

impl<'a> Materials<'a> {
    pub(super) fn new(root: &'a Root, buffers: &'a Buffers<'a>) -> Self {
        let textured = root.materials.iter().filter(|material| base_colour(material).1.is_some()).count();
        Self {
            root,
            buffers,
            images: Images::new(textured),
            converted: vec![None; root.materials.len() + 1],
            variants: HashMap::new(),
            untextured: HashMap::new(),
            textures: HashMap::new(),
            scene: Vec::new(),
        }
    }

    fn slot(&self, material: Option<Whole>) -> usize {
        material.map_or(self.root.materials.len(), Whole::index)
    }

    /// The scene's material, and what it needs from the primitive.
    pub(super) fn get(
        &mut self,
        material: Option<Whole>,
        folder: &mut Folder,
        warnings: &mut Warnings,
    ) -> Result<&Converted, FileFault> {
        let count = self.root.materials.len();
        let slot = self.slot(material);
        if slot > count || (slot == count && material.is_some()) {
            return Err(out_of_range("materials".into(), slot, count));
        }
        if self.converted[slot].is_none() {
            let converted = match self.root.materials.get(slot) {
                Some(_) => self.convert(slot, folder, warnings)?,
                None => {
                    self.scene.push(Material::plain("default", [0.8; 3]));
                    Converted { material: self.scene.len() as u32 - 1, uv_map: None, test: None }
                }
            };
            self.converted[slot] = Some(converted);
        }
        match &self.converted[slot] {
            Some(converted) => Ok(converted),
            None => Err(out_of_range("materials".into(), slot, count)),
        }
    }

    /// The material for a surface whose vertices have some alpha; the same where alpha is not tested.
    pub(super) fn variant(&mut self, material: Option<Whole>, alpha: f64) -> Result<u32, FileFault> {
        let slot = self.slot(material);
        let Some(Some(Converted { material, test, .. })) = self.converted.get(slot) else { return Ok(0) };
        let Some(test) = test.as_ref().filter(|_| alpha != 1.0) else { return Ok(*material) };
        let mask = alpha_mask(test.texels.as_deref(), test.factor * alpha, test.cutoff);
        // 0 stands for a test that never fails, as no mask has that cutoff.
        let threshold = mask.as_ref().map_or(0, |mask| if mask.shows_nothing() { 255 } else { mask.cutoff });
        let next = self.scene.len() as u32;
        let number = *self.variants.entry((slot, threshold)).or_insert(next);
        if number == next {
            let texels = mask.as_ref().map_or(0, |mask| mask.alpha.len() as u64);
            self.images.keep_alpha(texels, &format!("materials[{slot}]"))?;
            let of = self.scene[*material as usize].clone();
            self.scene.push(Material { mask: mask.map(Arc::new), ..of });
        }
        Ok(number)
    }

    /// The material without its texture, for a surface that lacks the coordinates.
    pub(super) fn untextured(&mut self, number: u32) -> u32 {
        let next = self.scene.len() as u32;
        let plain = *self.untextured.entry(number).or_insert(next);
        if plain == next {
            let of = self.scene[number as usize].clone();
            let opacity = of.opacity.map(|opacity| Opacity { transmission_texture: None, ..opacity });
            self.scene.push(Material { factor: of.albedo, texture: None, opacity, ..of });
        }
        plain
    }

    fn convert(
        &mut self,
        slot: usize,
        folder: &mut Folder,
        warnings: &mut Warnings,
    ) -> Result<Converted, FileFault> {
        let at = format!("materials[{slot}]");
        let source = &self.root.materials[slot];
        let name = source.name.clone().unwrap_or_else(|| format!("material {slot}"));
        let (given, info) = base_colour(source);
        let factor = checked_factor(given, &at, warnings)?;
        // What is tested for opacity must be right; colours need not.
        let (cutoff, blends) = match source.alpha_mode.as_deref() {
            Some("MASK") => (Some(source.alpha_cutoff.unwrap_or(0.5)), false),
            Some("BLEND") => (Some(OPAQUE_FROM), true),
            None | Some("OPAQUE") => (None, false),
            Some(other) => {
                return Err(FileFault::invalid(at, format!("alphaMode {other:?} is not known")));
            }
        };
        if let Some(cutoff) = cutoff.filter(|cutoff| !(cutoff.is_finite() && *cutoff >= 0.0)) {
            return Err(FileFault::invalid(at, format!("alphaCutoff {cutoff} is not a number from 0 up")));
        }
        let base = match info {
            Some(info) => self.texture(info, cutoff.is_some(), folder, warnings)?,
            None => None,
        };
        let mean = base.as_ref().map_or([1.0; 3], |base| base.reduced.mean);
        let albedo = std::array::from_fn(|channel| factor[channel] * mean[channel]);
        let mut uv_map = match (info, &base) {
            (Some(info), Some(base)) => Some(UvMap::of(info, base.scale, &at)?),
            _ => None,
        };
        let wrap = base.as_ref().map_or([Wrap::Repeat; 2], |base| base.wrap);
        let texels = base.as_ref().and_then(|base| base.alpha.clone());
        let factor_alpha = f64::from(factor[3]);
        let mask = cutoff.and_then(|cutoff| alpha_mask(texels.as_deref(), factor_alpha, cutoff));
        self.images.keep_alpha(mask.as_ref().map_or(0, |mask| mask.alpha.len() as u64), &at)?;
        let through = self.transmission(source, (albedo, info), &at, folder, warnings)?;
        let opacity = (blends || through.is_some()).then(|| {
            let through = through.unwrap_or_default();
            uv_map = uv_map.or(through.uv_map);
            Opacity {
                factor: if blends { factor[3] } else { 1.0 },
                texture: texels.clone().filter(|_| blends),
                transmission: through.shares,
                transmission_texture: through.texture,
                tested: !blends,
            }
        });
        if let Some(uv_map) = &mut uv_map {
            uv_map.needed = texels.is_some();
        }
        let test = cutoff.map(|cutoff| AlphaTest {
            cutting: Cutting::new(texels.as_deref(), wrap, factor_alpha, cutoff),
            texels,
            factor: factor_alpha,
            cutoff,
        });
        self.scene.push(Material {
            name,
            albedo,
            mask: mask.map(Arc::new),
            factor: [0, 1, 2].map(|k| factor[k]),
            texture: base.map(|base| base.reduced.wrapped(wrap)),
            opacity,
            one_sided: false,
        });
        Ok(Converted { material: self.scene.len() as u32 - 1, uv_map, test })
    }

    /// `None` for a texture that is missing or cannot be read: an error where alpha depends on it.
    fn texture(
        &mut self,
        info: &TextureInfo,
        alpha: bool,
        folder: &mut Folder,
        warnings: &mut Warnings,
    ) -> Result<Option<Base>, FileFault> {
        let texture = entry(&self.root.textures, info.index, "textures")?;
        let wrap = wraps(self.root, texture);
        let mut fault = None;
        for source in sources(texture).into_iter().flatten() {
            if let Some(reduced) = self.textures.get(&source.0).filter(|_| !alpha) {
                return Ok(Some(Base { alpha: None, wrap, scale: [1.0; 2], reduced: reduced.clone() }));
            }
            match self.image(source, folder) {
                Ok(image) if alpha => return self.tested(image, wrap, source).map(Some),
                Ok(image) => {
                    let reduced = self.images.reduced(&image);
                    self.textures.insert(source.0, reduced.clone());
                    return Ok(Some(Base { alpha: None, wrap, scale: [1.0; 2], reduced }));
                }
                // The first one tells most about what the file is.
                Err(error) => fault = fault.or(Some(error)),
            }
        }
        let fault = fault.unwrap_or_else(|| {
            FileFault::invalid(format!("textures[{}]", info.index.0), "has no image that is read")
        });
        match fault {
            // Memory and time are not a matter of what shadows need.
            FileFault::TooMany { .. } => Err(fault),
            _ if alpha => Err(fault),
            _ => {
                warnings.add(WarningKind::MissingTexture, &format!("{}", info.index.0), || {
                    format!("{fault}: its materials keep their plain colour")
                });
                Ok(None)
            }
        }
    }

    /// A texture whose alpha counts. Masks repeat, so that one which is mirrored becomes twice as large.
    fn tested(&mut self, image: RgbaImage, wrap: [Wrap; 2], source: Whole) -> Result<Base, FileFault> {
        let at = format!("images[{}]", source.0);
        let mirrored = wrap.map(|wrap| wrap == Wrap::Mirror);
        let image = if mirrored == [false; 2] { image } else { unfolded(&image, mirrored, &at)? };
        let reduced = self.images.reduced(&image);
        let alpha = self.images.alpha(&image, &at)?.map(Arc::new);
        let wrap = wrap.map(|wrap| if wrap == Wrap::Mirror { Wrap::Repeat } else { wrap });
        Ok(Base { alpha, wrap, scale: mirrored.map(|mirrored| if mirrored { 0.5 } else { 1.0 }), reduced })
    }

    pub(super) fn image(&mut self, index: Whole, folder: &mut Folder) -> Result<RgbaImage, FileFault> {
        let root = self.root;
        let source = entry(&root.images, index, "images")?;
        let at = format!("images[{}]", index.0);
        match (source.buffer_view, &source.uri) {
            (Some(view), _) => self.images.decode(self.buffers.view(view)?, "", &at),
            (None, Some(uri)) => self.images.decode(&folder.read_uri(uri, &at)?, uri, &at),
            (None, None) => Err(FileFault::invalid(at, "has neither bufferView nor uri")),
        }
    }
}

/// Images of a texture, the first one that is read counts.
pub(super) fn sources(texture: &super::json::Texture) -> [Option<Whole>; 5] {
    let extensions = texture.extensions.as_ref();
    let of = |source: Option<&super::json::TextureSource>| source.and_then(|source| source.source);
    [
        extensions.and_then(|e| of(e.webp.as_ref())),
        extensions.and_then(|e| of(e.dds.as_ref())),
        texture.source,
        extensions.and_then(|e| of(e.basisu.as_ref())),
        extensions.and_then(|e| of(e.avif.as_ref())),
    ]
}

/// How a texture goes on beyond its image.
pub(super) fn wraps(root: &Root, texture: &super::json::Texture) -> [Wrap; 2] {
    let sampler = texture.sampler.and_then(|index| root.samplers.get(index.index()));
    [sampler.and_then(|s| s.wrap_s), sampler.and_then(|s| s.wrap_t)].map(wrap_of)
}

fn base_colour(material: &super::json::Material) -> ([f64; 4], Option<&TextureInfo>) {
    let specular = material.extensions.as_ref().and_then(|e| e.specular_glossiness.as_ref());
    let (factor, texture) = match (&material.pbr_metallic_roughness, specular) {
        // A renderer that knows this extension uses it in place of the other.
        (_, Some(of)) => (of.diffuse_factor, of.diffuse_texture.as_ref()),
        (Some(of), None) => (of.base_color_factor, of.base_color_texture.as_ref()),
        (None, None) => (None, None),
    };
    (factor.unwrap_or([1.0; 4]), texture)
}

fn checked_factor(given: [f64; 4], at: &str, warnings: &mut Warnings) -> Result<[f32; 4], FileFault> {
    if !given.iter().all(|c| (*c as f32).is_finite()) {
        return Err(FileFault::invalid(at, format!("baseColorFactor {given:?} is outside [0, 1]")));
    }
    if !given.iter().all(|c| (0.0..=1.0).contains(c)) {
        warnings.add(WarningKind::OutOfRange, "baseColorFactor", || {
            format!("{at}: baseColorFactor {given:?} is moved into [0, 1]")
        });
    }
    Ok(given.map(|c| c.clamp(0.0, 1.0) as f32))
}

fn wrap_of(code: Option<Whole>) -> Wrap {
    match code.map(|code| code.0) {
        Some(33071) => Wrap::Clamp,
        Some(33648) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}
