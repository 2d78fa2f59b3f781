//! Wavefront OBJ with its MTL materials.
//!
//! Read here and not by the `tobj` crate, because messages must name the line, because `tobj` misaligns
//! texture coordinates where only some corners have them, and because it panics on some malformed MTL files.

mod library;
mod polygon;
mod statement;

use std::collections::HashMap;

use library::{Defined, Library, Means};
use polygon::{Outcome, Triangulation};
use statement::{Statement, statements};

use super::source::Folder;
use super::text::as_utf8;
use super::texture::Images;
use super::warnings::{WarningKind, Warnings};
use super::{Loaded, recentred};
use crate::Material;
use crate::arrays::{MAX_TRIANGLES, Mesh, SceneArrays, checked_position};
use crate::colour::linear_from_srgb;
use crate::error::FileFault;

/// Positions, texture coordinates and normals are shared by the whole file; faces are grouped by material.
struct Reader {
    positions: Vec<[f64; 3]>,
    /// Linear; as many as positions, or none where no vertex has one.
    colors: Vec<[f32; 3]>,
    uvs: Vec<[f64; 2]>,
    normals: Vec<[f32; 3]>,
    groups: Vec<Group>,
    group_of_material: HashMap<String, usize>,
    current: Option<usize>,
    library: Library,
    triangle_count: u64,
    triangulation: Triangulation,
    images: Images,
    /// What the file shows beside faces.
    holds: Vec<&'static str>,
}

/// Faces of one material.
#[derive(Default)]
struct Group {
    material: Option<String>,
    corners: Vec<Corner>,
    triangles: Vec<[u32; 3]>,
    numbers: HashMap<Corner, u32>,
}

/// Zero-based position, texture coordinate and normal.
type Corner = (u32, Option<u32>, Option<u32>);

/// Loads an OBJ: polygons are cut into triangles, convex or not; points, lines, curves and unknown keywords are skipped. Of a
/// material `Kd`, `d`, `Tr`, `map_Kd` and `map_d` are used: alpha of the latter's image where it has any, else its red channel.
pub(super) fn load(bytes: &[u8], folder: &mut Folder, warnings: &mut Warnings) -> Result<Loaded, FileFault> {
    // Comments and names in old files are Latin-1; numbers are ASCII in any case.
    let bytes = as_utf8(bytes, "the file", warnings)?;
    let text = String::from_utf8_lossy(&bytes);
    let mut reader = Reader {
        positions: Vec::new(),
        colors: Vec::new(),
        uvs: Vec::new(),
        normals: Vec::new(),
        groups: Vec::new(),
        group_of_material: HashMap::new(),
        current: None,
        library: Library::default(),
        triangle_count: 0,
        triangulation: Triangulation::new(),
        images: Images::new(TEXTURES_OF_A_LIBRARY),
        holds: Vec::new(),
    };
    statements(&text, |statement| reader.read(&statement, folder, warnings))?;
    reader.finish(folder, warnings)
}

/// How many textures the space for colours is shared by: their number is not known before they are read.
const TEXTURES_OF_A_LIBRARY: usize = 64;

impl Reader {
    fn read(&mut self, s: &Statement, folder: &mut Folder, warnings: &mut Warnings) -> Result<(), FileFault> {
        match s.keyword {
            "v" => self.vertex(s)?,
            "vt" => {
                let uv: [f64; 2] = s.numbers(1)?;
                if !uv.iter().all(|c| (*c as f32).is_finite()) {
                    return Err(s.invalid(format!("vt {uv:?} is not finite")));
                }
                self.uvs.push(uv);
            }
            "vn" => self.normals.push(s.numbers::<3>(3)?.map(|c| c as f32)),
            "f" | "fo" => self.face(s, warnings)?,
            "usemtl" => self.current = Some(self.group(Some(s.arguments))),
            "mtllib" => {
                let mut means = Means { folder, images: &mut self.images, warnings };
                self.library.read(s, &mut means)?;
            }
            "l" => self.hold("lines"),
            "p" => self.hold("points"),
            "curv" | "curv2" | "surf" => self.hold("curves and curved surfaces"),
            _ => {}
        }
        Ok(())
    }

    fn hold(&mut self, what: &'static str) {
        if !self.holds.contains(&what) {
            self.holds.push(what);
        }
    }

    fn vertex(&mut self, s: &Statement) -> Result<(), FileFault> {
        let [x, y, z, rest @ ..] = s.numbers::<7>(3)?;
        let position = [x, y, z];
        checked_position(position, || format!("{}: v", s.at()))?;
        // Three numbers more are a colour, as many programs write it; a weight may stand before it.
        let color = match s.arguments.split_whitespace().count() {
            6 => Some([rest[0], rest[1], rest[2]]),
            7 => Some([rest[1], rest[2], rest[3]]),
            _ => None,
        };
        if let Some(color) = color {
            self.colors.resize(self.positions.len(), [1.0; 3]);
            self.colors.push(color.map(|c| linear_from_srgb((255.0 * c.clamp(0.0, 1.0) + 0.5) as u8) as f32));
        }
        self.positions.push(position);
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

    fn face(&mut self, s: &Statement, warnings: &mut Warnings) -> Result<(), FileFault> {
        let group = match self.current {
            Some(group) => group,
            None => self.group(None),
        };
        self.current = Some(group);
        let mut corners = Vec::new();
        for word in s.arguments.split_whitespace() {
            corners.push(self.corner(s, word, warnings)?);
        }
        if corners.len() < 3 {
            let count = corners.len();
            warnings.add(WarningKind::ShortFace, "", || {
                format!("{}: f with {count} corners is left out, at least 3 are needed", s.at())
            });
            return Ok(());
        }
        self.triangle_count += corners.len() as u64 - 2;
        if self.triangle_count > MAX_TRIANGLES {
            let count = self.triangle_count;
            return Err(FileFault::TooMany { at: s.at(), what: "triangles", count, limit: MAX_TRIANGLES });
        }
        let numbers: Vec<u32> = corners.iter().map(|&corner| self.groups[group].number(corner)).collect();
        let positions: Vec<[f64; 3]> =
            corners.iter().map(|corner| self.positions[corner.0 as usize]).collect();
        let triangles = &mut self.groups[group].triangles;
        match self.triangulation.of(&positions, |t| triangles.push(t.map(|i| numbers[i]))) {
            Outcome::Whole => {}
            Outcome::Crossing => warnings.add(WarningKind::CrossingPolygon, "", || {
                format!(
                    "{}: f with {} corners crosses itself or does not lie in a plane",
                    s.at(),
                    corners.len()
                )
            }),
            Outcome::TooMany => {
                let problem = format!("f with {} corners that is not convex has too many", corners.len());
                return Err(s.invalid(problem));
            }
        }
        Ok(())
    }

    fn corner(&self, s: &Statement, word: &str, warnings: &mut Warnings) -> Result<Corner, FileFault> {
        let mut parts = word.split('/');
        // The index, and whether there is such a one.
        let mut next = |count: usize| -> Result<Option<(i64, Option<u32>)>, FileFault> {
            match parts.next() {
                None | Some("") => Ok(None),
                Some(part) => {
                    let index: i64 =
                        part.parse().map_err(|_| s.invalid(format!("f with {word:?}, which is no index")))?;
                    // Positive indices count from 1, negative ones back from the latest.
                    let zero_based = if index > 0 { index - 1 } else { index.saturating_add(count as i64) };
                    let inside = index != 0 && (0..count as i64).contains(&zero_based);
                    Ok(Some((index, inside.then_some(zero_based as u32))))
                }
            }
        };
        let position = match next(self.positions.len())? {
            Some((_, Some(position))) => position,
            Some((index, None)) => {
                let at = format!("{}: position of {word:?}", s.at());
                return Err(FileFault::IndexOutOfRange { at, index, count: self.positions.len() as u64 });
            }
            None => return Err(s.invalid(format!("f with {word:?}, which names no position"))),
        };
        let mut lenient = |found: Option<(i64, Option<u32>)>, kind, what: &str, count: usize| {
            if let Some((index, None)) = found {
                warnings.add(kind, what, || {
                    format!("{}: {what} {index} of {word:?} is out of range, there are {count}", s.at())
                });
            }
            found.and_then(|(_, place)| place)
        };
        let uv = next(self.uvs.len())?;
        let uv = lenient(uv, WarningKind::TextureCoordinates, "texture coordinate", self.uvs.len());
        let normal = next(self.normals.len())?;
        let normal = lenient(normal, WarningKind::Normals, "normal", self.normals.len());
        if parts.next().is_some() {
            return Err(s.invalid(format!("f with {word:?}, which has more than three parts")));
        }
        Ok((position, uv, normal))
    }

    fn finish(mut self, folder: &mut Folder, warnings: &mut Warnings) -> Result<Loaded, FileFault> {
        let mut materials: Vec<Material> = Vec::new();
        let groups = std::mem::take(&mut self.groups);
        let mut used: Vec<(Group, Defined)> = Vec::new();
        for group in groups.into_iter().filter(|group| !group.triangles.is_empty()) {
            let defined = self.defined(group.material.as_deref(), folder, warnings)?;
            materials.push(defined.material.clone());
            used.push((group, defined));
        }
        let build = |origin: [f64; 3], _: &mut Warnings| {
            let mut arrays = SceneArrays::default();
            for (number, (group, defined)) in used.iter().enumerate() {
                let mesh = self.mesh(group, defined, origin)?;
                let cutting = defined.cutting();
                let left = arrays.triangles_left();
                let parts = cutting.apply(mesh, left).map_err(|pieces| FileFault::TooMany {
                    at: format!("material {:?}", defined.material.name),
                    what: "triangles after cutting them at the borders of a texture",
                    count: pieces.0,
                    limit: left,
                })?;
                parts.iter().for_each(|(mesh, _)| arrays.push(mesh, number as u32));
            }
            Ok(arrays)
        };
        let (arrays, origin) = recentred(warnings, build)?;
        if self.holds.is_empty() && used.is_empty() && !self.positions.is_empty() {
            self.hold("vertices without faces");
        }
        let (cameras, lights, animations) = (Vec::new(), Vec::new(), (Vec::new(), None));
        Ok(Loaded { arrays, materials, cameras, lights, origin, holds: self.holds, animations })
    }

    fn defined(
        &mut self,
        material: Option<&str>,
        folder: &mut Folder,
        warnings: &mut Warnings,
    ) -> Result<Defined, FileFault> {
        let Some(name) = material else { return Ok(Defined::plain("default")) };
        let mut means = Means { folder, images: &mut self.images, warnings };
        if let Some(defined) = self.library.take(name, &mut means)? {
            return Ok(defined);
        }
        if self.library.named && !self.library.incomplete {
            warnings.add(WarningKind::MissingMaterial, name, || {
                format!("usemtl {name:?} is in no mtllib: it is plain and opaque")
            });
        }
        Ok(Defined::plain(name))
    }

    fn mesh(&self, group: &Group, defined: &Defined, origin: [f64; 3]) -> Result<Mesh, FileFault> {
        let mut mesh = Mesh { triangles: group.triangles.clone(), ..Mesh::default() };
        let vertices = group.corners.len();
        mesh.positions.reserve_exact(vertices);
        mesh.uvs.reserve_exact(vertices);
        mesh.normals.reserve_exact(vertices);
        let coloured = group.corners.iter().any(|corner| (corner.0 as usize) < self.colors.len());
        for &(position, uv, normal) in &group.corners {
            let world = self.positions[position as usize];
            let relative = [0, 1, 2].map(|k| world[k] - origin[k]);
            mesh.positions.push(checked_position(relative, || format!("position {}", position + 1))?);
            mesh.uvs.push(uv.map_or([0.0; 2], |i| defined.uv.apply(self.uvs[i as usize])));
            mesh.normals.push(normal.map_or([0.0; 3], |i| self.normals[i as usize]));
            if coloured {
                let [r, g, b] = self.colors.get(position as usize).copied().unwrap_or([1.0; 3]);
                mesh.colors.push([r, g, b, 1.0]);
            }
        }
        Ok(mesh)
    }
}

impl Group {
    fn number(&mut self, corner: Corner) -> u32 {
        let next = self.corners.len() as u32;
        let number = *self.numbers.entry(corner).or_insert(next);
        if number == next {
            self.corners.push(corner);
        }
        number
    }
}
