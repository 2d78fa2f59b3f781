//! The triangles of glTF primitives, placed in the world.

use std::collections::HashMap;

use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};

use super::accessor::{Buffers, Elements};
use super::material::UvMap;
use super::node::Affine;
use crate::arrays::{Mesh, SceneArrays, checked_position};
use crate::error::FileFault;

/// Whether a primitive consists of triangles; points and lines cast no shadow here.
pub(super) fn is_triangles(primitive: &Primitive) -> bool {
    mode(primitive).is_some()
}

fn mode(primitive: &Primitive) -> Option<Mode> {
    match primitive.mode {
        Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => Some(mode),
        _ => None,
    }
}

/// Where a primitive's data are and how messages call it.
pub(super) struct Source<'a> {
    pub root: &'a Root,
    pub buffers: &'a Buffers<'a>,
    pub primitive: &'a Primitive,
    pub at: String,
}

impl<'a> Source<'a> {
    fn attribute(
        &self,
        semantic: Semantic,
        kind: Type,
        role: &str,
    ) -> Result<Option<Elements<'a>>, FileFault> {
        let index: Option<Index<_>> = self.primitive.attributes.get(&Checked::Valid(semantic)).copied();
        index.map(|index| Elements::open(self.root, self.buffers, index, kind, role)).transpose()
    }

    /// The world-space mesh of those vertices that triangles use; `uv_map` is needed for masked materials only.
    pub(super) fn mesh(
        &self,
        arrays: &SceneArrays,
        world_from_mesh: &Affine,
        uv_map: Option<&UvMap>,
    ) -> Result<Mesh, FileFault> {
        let Some(positions) = self.attribute(Semantic::Positions, Type::Vec3, "POSITION")? else {
            return Err(FileFault::invalid(&self.at, "has no POSITION"));
        };
        let normals =
            self.same_count(self.attribute(Semantic::Normals, Type::Vec3, "NORMAL")?, &positions)?;
        let uvs = match uv_map {
            None => None,
            Some(map) => {
                let role = format!("TEXCOORD_{}", map.set);
                let uvs = self.attribute(Semantic::TexCoords(map.set), Type::Vec2, &role)?;
                let uvs = self.same_count(uvs, &positions)?;
                let missing = || FileFault::invalid(&self.at, format!("has no {role} for its alpha mask"));
                Some((map, uvs.ok_or_else(missing)?))
            }
        };
        let mut used = Used::new(self.corner_count(&positions)?, positions.len());
        let triangles = self.triangles(arrays, &positions, &mut used, world_from_mesh.mirrors())?;
        let mut mesh = Mesh { triangles, ..Mesh::default() };
        mesh.positions.reserve_exact(used.originals.len());
        for &original in &used.originals {
            let i = original as usize;
            let local: [f64; 3] = positions.vector(i);
            let at = || format!("{}: POSITION {original}", self.at);
            // Checked before it is transformed too: a zero scale turns an infinity into NaN, never into zero,
            // but the message should show what the file says.
            checked_position(local, at)?;
            mesh.positions.push(checked_position(world_from_mesh.point(local), at)?);
            if let Some(normals) = &normals {
                mesh.normals.push(world_from_mesh.normal(normals.vector(i)).map(|c| c as f32));
            }
            if let Some((map, uvs)) = &uvs {
                let uv = map.apply(uvs.vector(i));
                if !uv.iter().all(|c| c.is_finite()) {
                    let problem = format!("TEXCOORD_{} {original} is {uv:?}, not finite", map.set);
                    return Err(FileFault::invalid(&self.at, problem));
                }
                mesh.uvs.push(uv);
            }
        }
        Ok(mesh)
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

    fn indices(&self) -> Result<Option<Elements<'a>>, FileFault> {
        let Some(index) = self.primitive.indices else {
            return Ok(None);
        };
        let indices = Elements::open(self.root, self.buffers, index, Type::Scalar, "indices")?;
        if indices.is_index_type() {
            Ok(Some(indices))
        } else {
            Err(FileFault::invalid(format!("accessors[{index}]"), "indices are not unsigned integers"))
        }
    }

    fn corner_count(&self, positions: &Elements) -> Result<usize, FileFault> {
        Ok(self.indices()?.map_or(positions.len(), |indices| indices.len()))
    }

    fn triangles(
        &self,
        arrays: &SceneArrays,
        positions: &Elements,
        used: &mut Used,
        flip: bool,
    ) -> Result<Vec<[u32; 3]>, FileFault> {
        let indices = self.indices()?;
        let corners = self.corner_count(positions)?;
        let mode = mode(self.primitive).unwrap_or(Mode::Triangles);
        // None at all is invalid too, so that every primitive counts towards the limit of triangles.
        let valid = corners >= 3 && (mode != Mode::Triangles || corners.is_multiple_of(3));
        if !valid {
            let problem = format!("{corners} corners do not make up triangles of mode {mode:?}");
            return Err(FileFault::invalid(&self.at, problem));
        }
        let count = if mode == Mode::Triangles { corners / 3 } else { corners - 2 };
        arrays.reserve_check(count as u64, || self.at.clone())?;
        let mut triangles = Vec::with_capacity(count);
        for i in 0..count {
            let [a, mut b, mut c] = match mode {
                Mode::TriangleStrip if i % 2 == 1 => [i, i + 2, i + 1],
                Mode::TriangleStrip => [i, i + 1, i + 2],
                Mode::TriangleFan => [0, i + 1, i + 2],
                _ => [3 * i, 3 * i + 1, 3 * i + 2],
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
