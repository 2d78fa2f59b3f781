//! Wavefront OBJ with its MTL materials.
//!
//! Read here and not by the `tobj` crate, because messages must name the line, because `tobj` misaligns
//! texture coordinates where only some corners have them, and because it panics on some malformed MTL files.

use std::collections::HashMap;
use std::sync::Arc;

use super::Loaded;
use super::obj_text::{Statement, statements};
use super::source::Folder;
use super::texture::Images;
use crate::arrays::{MAX_TRIANGLES, Mesh, SceneArrays, checked_position};
use crate::error::FileFault;
use crate::{AlphaMask, Material};

/// Alpha from which a texel of `map_d` counts as present; MTL has no such number.
const MASK_CUTOFF: u8 = 128;

/// Positions, texture coordinates and normals are shared by the whole file; faces are grouped by material.
#[derive(Default)]
struct Reader {
    positions: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    groups: Vec<Group>,
    group_of_material: HashMap<String, usize>,
    current: Option<usize>,
    library: HashMap<String, Material>,
    triangle_count: u64,
}

#[derive(Default)]
struct Group {
    material: Option<String>,
    mesh: Mesh,
    numbers: HashMap<Corner, u32>,
}

/// Zero-based position, texture coordinate and normal.
type Corner = (u32, Option<u32>, Option<u32>);

/// Loads an OBJ: polygons become fans; points, lines, curves and unknown keywords are skipped; `v` of texture
/// coordinates is flipped because OBJ counts it from below. Of a material `Kd` and `map_d` are used: alpha of
/// the image where it has any, else its red channel. `mtllib` and `map_d` must exist in the file's folder.
pub(super) fn load(bytes: &[u8], folder: &mut Folder) -> Result<Loaded, FileFault> {
    // Comments and names in old files are Latin-1; numbers are ASCII in any case.
    let text = String::from_utf8_lossy(bytes);
    let mut reader = Reader::default();
    let mut images = Images::new();
    statements(&text, |statement| reader.read(&statement, folder, &mut images))?;
    reader.finish()
}

impl Reader {
    fn read(&mut self, s: &Statement, folder: &mut Folder, images: &mut Images) -> Result<(), FileFault> {
        match s.keyword {
            "v" => self.positions.push(checked_position(s.numbers(3)?, || format!("{}: v", s.at()))?),
            "vt" => {
                let [u, v] = s.numbers(1)?;
                let uv = [u as f32, (1.0 - v) as f32];
                if !uv.iter().all(|c| c.is_finite()) {
                    return Err(s.invalid(format!("vt {:?} is not finite", [u, v])));
                }
                self.uvs.push(uv);
            }
            "vn" => self.normals.push(s.numbers::<3>(3)?.map(|c| c as f32)),
            "f" => self.face(s)?,
            "usemtl" => self.current = Some(self.group(Some(s.arguments))),
            "mtllib" => {
                let bytes = folder.read_path(&s.arguments.replace('\\', "/"), &s.at())?;
                read_library(&bytes, s, &mut self.library, folder, images)?;
            }
            _ => {}
        }
        Ok(())
    }

    fn group(&mut self, material: Option<&str>) -> usize {
        let next = self.groups.len();
        let group = *self.group_of_material.entry(material.unwrap_or_default().to_owned()).or_insert(next);
        if group == next {
            self.groups.push(Group { material: material.map(str::to_owned), ..Group::default() });
        }
        group
    }

    fn face(&mut self, s: &Statement) -> Result<(), FileFault> {
        let group = match self.current {
            Some(group) => group,
            None => self.group(None),
        };
        self.current = Some(group);
        let mut fan: Option<(u32, Option<u32>)> = None;
        let mut corners = 0;
        for word in s.arguments.split_whitespace() {
            let corner = self.corner(s, word)?;
            let number = self.number(group, corner);
            corners += 1;
            fan = match fan {
                None => Some((number, None)),
                Some((first, previous)) => {
                    if let Some(previous) = previous {
                        self.groups[group].mesh.triangles.push([first, previous, number]);
                        self.triangle_count += 1;
                    }
                    Some((first, Some(number)))
                }
            };
        }
        if corners < 3 {
            return Err(s.invalid(format!("f with {corners} corners, at least 3 are needed")));
        }
        if self.triangle_count > MAX_TRIANGLES {
            let count = self.triangle_count;
            return Err(FileFault::TooMany { at: s.at(), what: "triangles", count, limit: MAX_TRIANGLES });
        }
        Ok(())
    }

    fn corner(&self, s: &Statement, word: &str) -> Result<Corner, FileFault> {
        let mut parts = word.split('/');
        let mut next = |what: &str, count: usize| -> Result<Option<u32>, FileFault> {
            match parts.next() {
                None | Some("") => Ok(None),
                Some(part) => {
                    let index: i64 =
                        part.parse().map_err(|_| s.invalid(format!("f with {word:?}, which is no index")))?;
                    // Positive indices count from 1, negative ones back from the latest.
                    let zero_based = if index > 0 { index - 1 } else { index.saturating_add(count as i64) };
                    if index == 0 || !(0..count as i64).contains(&zero_based) {
                        let at = format!("{}: {what} of {word:?}", s.at());
                        return Err(FileFault::IndexOutOfRange { at, index, count: count as u64 });
                    }
                    Ok(Some(zero_based as u32))
                }
            }
        };
        let position = next("position", self.positions.len())?;
        let uv = next("texture coordinate", self.uvs.len())?;
        let normal = next("normal", self.normals.len())?;
        let position =
            position.ok_or_else(|| s.invalid(format!("f with {word:?}, which names no position")))?;
        if parts.next().is_some() {
            return Err(s.invalid(format!("f with {word:?}, which has more than three parts")));
        }
        Ok((position, uv, normal))
    }

    fn number(&mut self, group: usize, corner: Corner) -> u32 {
        let Group { mesh, numbers, .. } = &mut self.groups[group];
        let next = mesh.positions.len() as u32;
        let number = *numbers.entry(corner).or_insert(next);
        if number == next {
            let (position, uv, normal) = corner;
            mesh.positions.push(self.positions[position as usize]);
            mesh.uvs.push(uv.map_or([0.0; 2], |i| self.uvs[i as usize]));
            mesh.normals.push(normal.map_or([0.0; 3], |i| self.normals[i as usize]));
        }
        number
    }

    fn finish(mut self) -> Result<Loaded, FileFault> {
        let mut arrays = SceneArrays::default();
        let mut materials = Vec::new();
        for group in self.groups.iter().filter(|group| !group.mesh.triangles.is_empty()) {
            let material = match &group.material {
                None => plain("default"),
                Some(name) => self.library.remove(name).unwrap_or_else(|| plain(name)),
            };
            arrays.push(&group.mesh, materials.len() as u32);
            materials.push(material);
        }
        Ok(Loaded { arrays, materials, camera: None })
    }
}

fn plain(name: &str) -> Material {
    Material { name: name.to_owned(), albedo: [0.8; 3], mask: None }
}

fn read_library(
    bytes: &[u8],
    mtllib: &Statement,
    library: &mut HashMap<String, Material>,
    folder: &mut Folder,
    images: &mut Images,
) -> Result<(), FileFault> {
    let mut current: Option<Material> = None;
    let text = String::from_utf8_lossy(bytes);
    statements(&text, |s| {
        let at = format!("{}: line {} of {:?}", mtllib.at(), s.line, mtllib.arguments);
        if s.keyword == "newmtl" {
            let finished = current.replace(plain(s.arguments));
            library.extend(finished.map(|material| (material.name.clone(), material)));
            return Ok(());
        }
        let Some(material) = &mut current else {
            return Ok(());
        };
        match s.keyword {
            // `Kd spectral` and `Kd xyz` exist on paper only: whatever is no number keeps the default.
            "Kd" => {
                if let Ok(kd) = s.numbers::<3>(3) {
                    material.albedo = kd.map(|c| if c.is_nan() { 0.8 } else { c.clamp(0.0, 1.0) as f32 });
                }
            }
            "map_d" => {
                // Options come first and end where the name starts; names with spaces have no options.
                let name = match s.arguments.strip_prefix('-') {
                    Some(rest) => rest.split_whitespace().next_back().unwrap_or_default(),
                    None => s.arguments,
                };
                let image = folder.read_path(&name.replace('\\', "/"), &at)?;
                let image = images.decode(&image, &at)?;
                let channel = if image.pixels().any(|texel| texel[3] < 255) { 3 } else { 0 };
                let alpha: Vec<u8> = image.pixels().map(|texel| texel[channel]).collect();
                if alpha.iter().any(|&a| a < MASK_CUTOFF) {
                    let (width, height) = image.dimensions();
                    material.mask = Some(Arc::new(AlphaMask { width, height, alpha, cutoff: MASK_CUTOFF }));
                }
            }
            _ => {}
        }
        Ok(())
    })?;
    library.extend(current.map(|material| (material.name.clone(), material)));
    Ok(())
}
