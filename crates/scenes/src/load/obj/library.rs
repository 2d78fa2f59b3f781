//! MTL: the materials of OBJ files. Whatever is missing or broken there leaves a plain, opaque material and a warning.

use std::collections::HashMap;
use std::sync::Arc;

use super::statement::{Statement, statements};
use crate::error::FileFault;
use crate::load::alpha::{OPAQUE_FROM, alpha_mask};
use crate::load::cut::Cutting;
use crate::load::source::Folder;
use crate::load::text::as_utf8;
use crate::load::texture::Images;
use crate::load::warnings::{WarningKind, Warnings};
use crate::{AlphaTexture, Material, Opacity, Wrap};

/// How texture coordinates become those of a material's textures: scale, then offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UvOptions {
    scale: [f64; 2],
    offset: [f64; 2],
    clamp: bool,
}

impl UvOptions {
    const NONE: Self = Self { scale: [1.0; 2], offset: [0.0; 2], clamp: false };

    /// OBJ counts v from below.
    pub(super) fn apply(&self, [u, v]: [f64; 2]) -> [f32; 2] {
        let [u, v] = [(0, u), (1, v)].map(|(k, t)| t * self.scale[k] + self.offset[k]);
        [u as f32, (1.0 - v) as f32]
    }
}

/// A material with what its corners need.
#[derive(Clone, Debug)]
pub(super) struct Defined {
    pub material: Material,
    pub uv: UvOptions,
}

impl Defined {
    /// A clamped texture of alpha ends somewhere.
    pub(super) fn cutting(&self) -> Cutting {
        let texels = self.material.opacity.as_ref().and_then(|opacity| opacity.texture.as_deref());
        let wrap = [if self.uv.clamp { Wrap::Clamp } else { Wrap::Repeat }; 2];
        Cutting::new(texels, wrap, 1.0, OPAQUE_FROM)
    }

    pub(super) fn plain(name: &str) -> Self {
        Self { material: Material::plain(name, [0.8; 3]), uv: UvOptions::NONE }
    }
}

/// A material as it is being read.
struct Draft {
    name: String,
    kd: [f32; 3],
    opacity: f64,
    /// `d` overrules `Tr`.
    has_d: bool,
    map_kd: Option<Map>,
    map_d: Option<Map>,
}

/// A reference to an image.
struct Map {
    name: String,
    uv: UvOptions,
    at: String,
}

/// All materials that were read. Their textures are, where a face uses them.
#[derive(Default)]
pub(super) struct Library {
    materials: HashMap<String, Draft>,
    /// Whether one of the files could not be read.
    pub incomplete: bool,
    /// Whether any was named.
    pub named: bool,
}

/// What reading needs.
pub(super) struct Means<'a> {
    pub folder: &'a mut Folder,
    pub images: &'a mut Images,
    pub warnings: &'a mut Warnings,
}

impl Library {
    /// Reads the files that a `mtllib` statement names: one, in whose name there may be spaces, or several.
    pub(super) fn read(&mut self, statement: &Statement, means: &mut Means) -> Result<(), FileFault> {
        self.named = true;
        let (whole, at) = (statement.arguments, statement.at());
        if let Ok(bytes) = read_beside(means.folder, whole, &at) {
            return self.parse(&bytes, whole, &at, means);
        }
        for name in whole.split_whitespace() {
            match read_beside(means.folder, name, &at) {
                Ok(bytes) => self.parse(&bytes, name, &at, means)?,
                Err(fault @ FileFault::TooMany { .. }) => return Err(fault),
                Err(fault) => {
                    self.incomplete = true;
                    means.warnings.add(WarningKind::MissingLibrary, name, || {
                        format!("{fault}: its materials are plain and opaque")
                    });
                }
            }
        }
        Ok(())
    }

    fn parse(&mut self, bytes: &[u8], name: &str, at: &str, means: &mut Means) -> Result<(), FileFault> {
        // Textures belong to the materials of the library in which they stand.
        let of = |line: usize| format!("{at}: line {line} of {name:?}");
        let Ok(bytes) = as_utf8(bytes, name, means.warnings) else {
            self.incomplete = true;
            let message = || format!("{at}: {name:?} is text in UTF-32, which is not read");
            means.warnings.add(WarningKind::MissingLibrary, name, message);
            return Ok(());
        };
        let text = String::from_utf8_lossy(&bytes);
        let mut drafts: Vec<Draft> = Vec::new();
        statements(&text, |s| {
            if s.keyword == "newmtl" {
                drafts.push(Draft {
                    name: s.arguments.to_owned(),
                    kd: [0.8; 3],
                    opacity: 1.0,
                    has_d: false,
                    map_kd: None,
                    map_d: None,
                });
            } else if let Some(draft) = drafts.last_mut() {
                draft.read(&s, of(s.line), means.warnings);
            }
            Ok(())
        })?;
        self.materials.extend(drafts.into_iter().map(|draft| (draft.name.clone(), draft)));
        Ok(())
    }

    /// A material, once.
    pub(super) fn take(&mut self, name: &str, means: &mut Means) -> Result<Option<Defined>, FileFault> {
        self.materials.remove(name).map(|draft| draft.finish(means)).transpose()
    }
}

/// A file in the scene's folder; of one that is named elsewhere, its namesake there.
fn read_beside(folder: &mut Folder, name: &str, at: &str) -> Result<Vec<u8>, FileFault> {
    let path = name.replace('\\', "/");
    folder.read_path(&path, at).or_else(|fault| match (path.rsplit_once('/'), fault) {
        (_, fault @ FileFault::TooMany { .. }) | (None, fault) => Err(fault),
        (Some((_, file)), fault) => folder.read_path(file, at).map_err(|_| fault),
    })
}

impl Draft {
    fn read(&mut self, s: &Statement, at: String, warnings: &mut Warnings) {
        match s.keyword {
            // `Kd spectral` and `Kd xyz` exist on paper only: whatever is no number keeps the default.
            "Kd" => {
                if let Ok(kd) = s.numbers::<3>(3) {
                    self.kd = kd.map(|c| if c.is_nan() { 0.8 } else { c.clamp(0.0, 1.0) as f32 });
                }
            }
            "d" => {
                let halo = s.arguments.strip_prefix("-halo").unwrap_or(s.arguments).trim();
                match halo.parse::<f64>() {
                    Ok(d) if d.is_finite() => {
                        if !(0.0..=1.0).contains(&d) {
                            self.moved(warnings, &at, s.keyword, &format!("{d} is moved into [0, 1]"));
                        }
                        (self.opacity, self.has_d) = (d.clamp(0.0, 1.0), true);
                    }
                    _ => {
                        self.moved(warnings, &at, s.keyword, &format!("{halo:?} is no opacity, and ignored"))
                    }
                }
            }
            "Tr" => {
                // Some programs write 1 for opaque, others for clear; nobody draws what is clear throughout.
                match s.numbers::<1>(1) {
                    Ok([tr]) if (0.0..=1.0).contains(&tr) => {
                        if !self.has_d && tr < 1.0 {
                            self.opacity = 1.0 - tr;
                        }
                    }
                    _ => {
                        let what = format!("{:?} is no transparency in [0, 1], and ignored", s.arguments);
                        self.moved(warnings, &at, s.keyword, &what);
                    }
                }
            }
            "map_Kd" => self.map_kd = Map::of(s.arguments, at),
            "map_d" | "map_opacity" => self.map_d = Map::of(s.arguments, at),
            _ => {}
        }
    }

    /// Tells of an opacity that cannot be taken as it is.
    fn moved(&self, warnings: &mut Warnings, at: &str, keyword: &str, what: &str) {
        warnings
            .add(WarningKind::OutOfRange, keyword, || format!("{at}: {keyword} of {:?}: {what}", self.name));
    }

    fn finish(self, means: &mut Means) -> Result<Defined, FileFault> {
        let Self { name, kd, opacity, map_kd, map_d, .. } = self;
        let uv = map_d.as_ref().or(map_kd.as_ref()).map_or(UvOptions::NONE, |map| map.uv);
        let wrap = [if uv.clamp { Wrap::Clamp } else { Wrap::Repeat }; 2];
        let mut load = |map: Option<Map>, instead: &str| -> Result<Option<image::RgbaImage>, FileFault> {
            let Some(Map { name, at, .. }) = map else { return Ok(None) };
            let read = read_beside(means.folder, &name, &at);
            match read.and_then(|bytes| means.images.decode(&bytes, &name, &at)) {
                Ok(image) => Ok(Some(image)),
                Err(fault @ FileFault::TooMany { .. }) => Err(fault),
                Err(fault) => {
                    let message = || format!("{fault}: {instead}");
                    means.warnings.add(WarningKind::MissingTexture, &format!("{name} {instead}"), message);
                    Ok(None)
                }
            }
        };
        let colour = load(map_kd, "its material keeps its plain colour")?;
        let alpha = load(map_d, "its material is opaque there")?;
        let alpha = match alpha {
            Some(image) => alpha_of(&image, &name, means.images)?,
            None => None,
        };
        let blends = opacity < 1.0 || alpha.is_some();
        if opacity == 0.0 {
            means.warnings.add(WarningKind::Transparent, &name, || {
                format!("material {name:?} has an opacity of 0 and casts no shadow")
            });
        }
        let mask = if blends { alpha_mask(alpha.as_deref(), opacity, OPAQUE_FROM) } else { None };
        let at = format!("material {name:?}");
        means.images.keep_alpha(mask.as_ref().map_or(0, |mask| mask.alpha.len() as u64), &at)?;
        let reduced = colour.map(|image| means.images.reduced(&image));
        let mean = reduced.as_ref().map_or([1.0; 3], |reduced| reduced.mean);
        // Programs that write a texture often write a black colour beside it, which nobody multiplies it with.
        let factor = if reduced.is_some() && kd == [0.0; 3] { [1.0; 3] } else { kd };
        let material = Material {
            albedo: [0, 1, 2].map(|k| factor[k] * mean[k]),
            name,
            mask: mask.map(Arc::new),
            factor,
            texture: reduced.map(|reduced| reduced.wrapped(wrap)),
            opacity: blends.then(|| Opacity::blended(opacity as f32, alpha)),
            one_sided: false,
        };
        Ok(Defined { material, uv })
    }
}

/// Opacity from an image: its alpha where it has any, else its red channel.
fn alpha_of(
    image: &image::RgbaImage,
    name: &str,
    images: &mut Images,
) -> Result<Option<Arc<AlphaTexture>>, FileFault> {
    let channel = if image.pixels().any(|texel| texel[3] < 255) { 3 } else { 0 };
    if image.pixels().all(|texel| texel[channel] == 255) {
        return Ok(None);
    }
    let (width, height) = image.dimensions();
    images.keep_alpha(u64::from(width) * u64::from(height), &format!("material {name:?}"))?;
    let alpha = image.pixels().map(|texel| texel[channel]).collect();
    Ok(Some(Arc::new(AlphaTexture { width, height, alpha })))
}

impl Map {
    /// Options come first; what they leave is the name, in which there may be spaces.
    fn of(arguments: &str, at: String) -> Option<Self> {
        let mut uv = UvOptions::NONE;
        let mut rest = arguments.trim();
        while let Some(option) = rest.strip_prefix('-') {
            let (option, after) = option.split_once(char::is_whitespace)?;
            rest = after.trim_start();
            let word = |rest: &mut &str| {
                let (word, after) = rest.split_once(char::is_whitespace)?;
                let word = word.to_owned();
                *rest = after.trim_start();
                Some(word)
            };
            match option {
                "o" | "s" | "t" => {
                    let mut values = [if option == "s" { 1.0 } else { 0.0 }; 2];
                    // One to three numbers; a name may begin with a digit, so that the last word is never one of them.
                    for k in 0..3 {
                        let next = rest.split_whitespace().next().and_then(|next| next.parse::<f64>().ok());
                        let Some(number) =
                            next.filter(|n| n.is_finite() && rest.contains(char::is_whitespace))
                        else {
                            break;
                        };
                        word(&mut rest)?;
                        if let Some(value) = values.get_mut(k) {
                            *value = number;
                        }
                    }
                    match option {
                        "o" => uv.offset = values,
                        "s" => uv.scale = values,
                        _ => {}
                    }
                }
                "clamp" => uv.clamp = word(&mut rest)? == "on",
                "mm" => {
                    word(&mut rest)?;
                    word(&mut rest)?;
                }
                _ => {
                    word(&mut rest)?;
                }
            }
        }
        (!rest.is_empty()).then(|| Self { name: rest.to_owned(), uv, at })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_end_where_the_name_begins() {
        let map = |text: &str| Map::of(text, String::new()).map(|map| (map.name, map.uv));
        assert_eq!(map("leaf 2.png"), Some(("leaf 2.png".into(), UvOptions::NONE)));
        assert_eq!(map("-s 2 3 1 leaf.png").unwrap().1.scale, [2.0, 3.0]);
        assert_eq!(map("-o 0.5 -clamp on 2 leaves.png").unwrap().0, "2 leaves.png");
        assert_eq!(map("-bm 0.2 -mm 0 1 -imfchan m leaf.png").unwrap().0, "leaf.png");
        assert!(map("-clamp on x.png").unwrap().1.clamp);
        assert_eq!([map(""), map("-s"), map("-clamp on")], [None, None, None]);
        let uv = map("-s 2 2 -o 0.25 0.5 x.png").unwrap().1;
        assert_eq!(uv.apply([0.5, 0.25]), [1.25, 0.0]);
    }
}
