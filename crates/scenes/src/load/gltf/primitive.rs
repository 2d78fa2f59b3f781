//! The triangles of glTF primitives, placed in the world.

use std::collections::{BTreeMap, HashMap};

use super::accessor::{Elements, entry};
use super::buffers::Buffers;
use super::draco::Decoded;
use super::json::{Primitive, Root, Whole};
use super::material::UvMap;
use super::pose::{Morph, MorphBudget, Placement};
use crate::arrays::{Mesh, SceneArrays, checked_position};
use crate::error::FileFault;
use crate::load::warnings::{WarningKind, Warnings};

/// How corners make up triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    List,
    Strip,
    Fan,
}

/// What a primitive is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Topology {
    Points,
    Lines,
    Triangles(Mode),
}

impl Topology {
    pub(super) fn of(primitive: &Primitive, at: &str) -> Result<Self, FileFault> {
        Ok(match primitive.mode.map_or(4, |mode| mode.0) {
            0 => Self::Points,
            1..=3 => Self::Lines,
            4 => Self::Triangles(Mode::List),
            5 => Self::Triangles(Mode::Strip),
            6 => Self::Triangles(Mode::Fan),
            mode => return Err(FileFault::invalid(at, format!("mode {mode} is not known"))),
        })
    }
}

/// Where a primitive's data are and how messages call it.
pub(super) struct Source<'a> {
    pub root: &'a Root,
    pub buffers: &'a Buffers<'a>,
    pub primitive: &'a Primitive,
    pub mode: Mode,
    pub compressed: Option<&'a Decoded>,
    pub at: String,
}

/// What a mesh is made with.
pub(super) struct Wanted<'a, 'b> {
    pub placement: &'b Placement<'a>,
    /// Of morph targets.
    pub weights: &'b [f64],
    pub uv_map: Option<UvMap>,
    /// Taken off positions in double precision.
    pub origin: [f64; 3],
}

impl<'a> Source<'a> {
    pub(super) fn attribute(&self, name: &str, expected: &[&str]) -> Result<Option<Elements<'a>>, FileFault> {
        let Some(&index) = self.primitive.attributes.get(name) else { return Ok(None) };
        if let Some((values, count)) = self.compressed.and_then(|decoded| decoded.attribute(name)) {
            let accessor = entry(&self.root.accessors, index, "accessors")?;
            return Elements::decoded(accessor, values, count, expected, name).map(Some);
        }
        Elements::open(self.root, self.buffers, index, expected, name).map(Some)
    }

    /// The world-space mesh of those vertices that triangles use; `None` where there is none, which is no error.
    pub(super) fn mesh(
        &self,
        arrays: &SceneArrays,
        wanted: &Wanted<'a, '_>,
        budget: &mut MorphBudget,
        warnings: &mut Warnings,
    ) -> Result<Option<Mesh>, FileFault> {
        let Some(positions) = self.attribute("POSITION", &["VEC3"])? else {
            let message = || format!("{}: has no POSITION and is not shown", self.at);
            warnings.add(WarningKind::Incomplete, "no POSITION", message);
            return Ok(None);
        };
        self.check_bounds(warnings)?;
        let normals = self.same_count(self.attribute("NORMAL", &["VEC3"])?, &positions)?;
        let colors = self.same_count(self.attribute("COLOR_0", &["VEC3", "VEC4"])?, &positions)?;
        let uvs = self.uvs(wanted.uv_map, &positions, warnings)?;
        let corners = self.indices()?.map_or(positions.len(), |indices| indices.len());
        let count = self.count(corners, warnings);
        arrays.reserve_check(count as u64, || self.at.clone())?;
        if count == 0 {
            return Ok(None);
        }
        let mut used = Used::new(corners, positions.len());
        let flip = match wanted.placement {
            Placement::Rigid(world) => world.mirrors(),
            Placement::Skinned { .. } => {
                let first = self.indices()?.map_or(0, |indices| indices.index(0) as usize);
                let inside = first < positions.len();
                // What it warns of is said when the vertex is placed.
                inside && wanted.placement.of(first, &self.at, &mut Warnings::default())?.mirrors()
            }
        };
        let triangles = self.triangles(count, &positions, &mut used, flip)?;
        let counts = [positions.len(), used.originals.len()];
        let mut morph = |attribute: &str| {
            let data = (self.root, self.buffers);
            let targets: &[BTreeMap<String, Whole>] = &self.primitive.targets;
            Morph::open(data, targets, wanted.weights, attribute, counts, (&self.at, budget))
        };
        let (moved, turned) = (morph("POSITION")?, morph("NORMAL")?);
        // Without normals surfaces are flat (glTF 2.0, 3.7.2.1).
        let mut mesh = Mesh { triangles, flat: normals.is_none(), ..Mesh::default() };
        mesh.positions.reserve_exact(used.originals.len());
        let still = moved.is_empty() && turned.is_empty();
        let rigid = match wanted.placement {
            Placement::Rigid(world) => Some(*world),
            Placement::Skinned { .. } => None,
        };
        for &original in &used.originals {
            let i = original as usize;
            let at = || format!("{}: POSITION {original}", self.at);
            // Checked before it is transformed too: a zero scale turns an infinity into NaN, never into zero,
            // but the message should show what the file says.
            let stored = positions.vector(i);
            checked_position(stored, at)?;
            let local = if still { stored } else { moved.apply(i, stored) };
            let placed;
            let map = match &rigid {
                Some(world) => world,
                None => {
                    placed = wanted.placement.of(i, &self.at, warnings)?;
                    &placed
                }
            };
            let world = map.point(local);
            let relative = [0, 1, 2].map(|k| world[k] - wanted.origin[k]);
            mesh.positions.push(checked_position(relative, at)?);
            if let Some(normals) = &normals {
                let stored = normals.vector(i);
                let normal = if still { stored } else { turned.apply(i, stored) };
                mesh.normals.push(map.normal(normal).map(|c| c as f32));
            }
            if let Some((map, uvs)) = &uvs {
                let uv = map.apply(uvs.vector(i));
                if !uv.iter().all(|c| c.is_finite()) {
                    let problem = format!("TEXCOORD_{} {original} is {uv:?}, not finite", map.set);
                    return Err(FileFault::invalid(&self.at, problem));
                }
                mesh.uvs.push(uv);
            }
            if let Some(colors) = &colors {
                let color: [f64; 4] = colors.vector(i);
                if !color.iter().all(|c| c.is_finite()) {
                    let problem = format!("COLOR_0 {original} is {color:?}, not finite");
                    return Err(FileFault::invalid(&self.at, problem));
                }
                if !(0.0..=1.0).contains(&color[3]) {
                    warnings.add(WarningKind::OutOfRange, "COLOR_0", || {
                        format!("{}: COLOR_0 {original}: alpha {} is moved into [0, 1]", self.at, color[3])
                    });
                }
                mesh.colors.push(color.map(|c| c.clamp(0.0, 1.0) as f32));
            }
        }
        Ok(Some(mesh))
    }

    /// Positions must state their least and greatest values; nothing here depends on them.
    fn check_bounds(&self, warnings: &mut Warnings) -> Result<(), FileFault> {
        let Some(&index) = self.primitive.attributes.get("POSITION") else { return Ok(()) };
        let accessor = entry(&self.root.accessors, index, "accessors")?;
        if accessor.min.is_none() || accessor.max.is_none() {
            warnings.add(WarningKind::MissingBounds, "", || {
                format!("accessors[{}]: positions without min and max", index.0)
            });
        }
        Ok(())
    }

    fn uvs(
        &self,
        map: Option<UvMap>,
        positions: &Elements,
        warnings: &mut Warnings,
    ) -> Result<Option<(UvMap, Elements<'a>)>, FileFault> {
        let Some(map) = map else { return Ok(None) };
        let role = format!("TEXCOORD_{}", map.set);
        match self.same_count(self.attribute(&role, &["VEC2"])?, positions)? {
            Some(uvs) => Ok(Some((map, uvs))),
            None if map.needed => {
                Err(FileFault::invalid(&self.at, format!("has no {role} for its alpha mask")))
            }
            None => {
                warnings.add(WarningKind::TextureCoordinates, "", || {
                    format!("{}: has no {role} for its texture", self.at)
                });
                Ok(None)
            }
        }
    }

    fn same_count(
        &self,
        elements: Option<Elements<'a>>,
        positions: &Elements,
    ) -> Result<Option<Elements<'a>>, FileFault> {
        match elements {
            Some(elements) if elements.len() != positions.len() => Err(FileFault::invalid(
                &self.at,
                format!("{} attribute values for {} positions", elements.len(), positions.len()),
            )),
            elements => Ok(elements),
        }
    }

    fn indices(&self) -> Result<Option<Indices<'a>>, FileFault> {
        if let Some(decoded) = self.compressed {
            return Ok(Some(Indices::Decoded(decoded.indices())));
        }
        let Some(index) = self.primitive.indices else {
            return Ok(None);
        };
        let indices = Elements::open(self.root, self.buffers, index, &["SCALAR"], "indices")?;
        if indices.is_index_type() {
            Ok(Some(Indices::Accessor(indices)))
        } else {
            Err(FileFault::invalid(format!("accessors[{}]", index.0), "indices are not unsigned integers"))
        }
    }

    /// How many triangles the corners make up.
    fn count(&self, corners: usize, warnings: &mut Warnings) -> usize {
        let (count, left) = match self.mode {
            Mode::List => (corners / 3, corners % 3),
            Mode::Strip | Mode::Fan => (corners.saturating_sub(2), if corners < 3 { corners } else { 0 }),
        };
        if left > 0 || count == 0 {
            let message = || {
                format!(
                    "{}: {corners} corners do not make up triangles ({:?}), {left} are left over",
                    self.at, self.mode
                )
            };
            warnings.add(WarningKind::Incomplete, "corners", message);
        }
        count
    }

    fn triangles(
        &self,
        count: usize,
        positions: &Elements,
        used: &mut Used,
        flip: bool,
    ) -> Result<Vec<[u32; 3]>, FileFault> {
        let indices = self.indices()?;
        let mut triangles = Vec::with_capacity(count);
        for i in 0..count {
            let [a, mut b, mut c] = match self.mode {
                Mode::Strip if i % 2 == 1 => [i, i + 2, i + 1],
                Mode::Strip => [i, i + 1, i + 2],
                Mode::Fan => [0, i + 1, i + 2],
                Mode::List => [3 * i, 3 * i + 1, 3 * i + 2],
            };
            if flip {
                std::mem::swap(&mut b, &mut c);
            }
            let mut triangle = [0; 3];
            for (slot, corner) in triangle.iter_mut().zip([a, b, c]) {
                let original = indices.as_ref().map_or(corner as u32, |indices| indices.index(corner));
                if original as usize >= positions.len() {
                    let at = format!("{}: indices[{corner}]", self.at);
                    let (index, count) = (i64::from(original), positions.len() as u64);
                    return Err(FileFault::IndexOutOfRange { at, index, count });
                }
                *slot = used.number(original);
            }
            triangles.push(triangle);
        }
        Ok(triangles)
    }
}

/// Which vertices corners are.
enum Indices<'a> {
    Accessor(Elements<'a>),
    Decoded(&'a [[u32; 3]]),
}

impl Indices<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Accessor(elements) => elements.len(),
            Self::Decoded(faces) => 3 * faces.len(),
        }
    }

    fn index(&self, corner: usize) -> u32 {
        match self {
            Self::Accessor(elements) => elements.index(corner),
            Self::Decoded(faces) => faces[corner / 3][corner % 3],
        }
    }
}

/// Renumbers vertices by first use. Many primitives may share one long accessor, so the cost must follow the
/// corners of the primitive, not the length of the accessor.
struct Used {
    originals: Vec<u32>,
    numbers: Numbers,
}

enum Numbers {
    Dense(Vec<u32>),
    Sparse(HashMap<u32, u32>),
}

impl Used {
    fn new(corners: usize, vertices: usize) -> Self {
        let numbers = if vertices / 4 <= corners {
            Numbers::Dense(vec![u32::MAX; vertices])
        } else {
            Numbers::Sparse(HashMap::new())
        };
        Self { originals: Vec::new(), numbers }
    }

    fn number(&mut self, original: u32) -> u32 {
        let next = self.originals.len() as u32;
        let number = match &mut self.numbers {
            Numbers::Dense(numbers) => {
                let slot = &mut numbers[original as usize];
                if *slot == u32::MAX {
                    *slot = next;
                }
                *slot
            }
            Numbers::Sparse(numbers) => *numbers.entry(original).or_insert(next),
        };
        if number == next {
            self.originals.push(original);
        }
        number
    }
}
