//! Meshes under `KHR_draco_mesh_compression`.

use std::collections::HashMap;
use std::rc::Rc;

use draco_core::decode_limits::DecodeLimits;
use draco_core::decoder_buffer::DecoderBuffer;
use draco_core::mesh::Mesh;
use draco_core::mesh_decoder::MeshDecoder;

use super::accessor::entry;
use super::buffers::Buffers;
use super::json::{Draco, Primitive, Root, Whole};
use crate::arrays::MAX_TRIANGLES;
use crate::error::FileFault;

/// Most bytes of attributes that all compressed meshes of a scene may become. Legitimate ones compress without limit: what
/// does not change takes no bits.
const MAX_DECODED_BYTES: u64 = 1 << 29;

/// A decoded primitive.
pub(super) struct Decoded {
    faces: Vec<[u32; 3]>,
    attributes: HashMap<String, Rc<Vec<f32>>>,
    points: usize,
}

impl Decoded {
    pub(super) fn attribute(&self, name: &str) -> Option<(Rc<Vec<f32>>, usize)> {
        self.attributes.get(name).map(|values| (values.clone(), self.points))
    }

    pub(super) fn indices(&self) -> &[[u32; 3]] {
        &self.faces
    }
}

/// How many bytes meshes of a scene may still become.
pub(super) struct DracoBudget(u64);

impl Default for DracoBudget {
    fn default() -> Self {
        Self(MAX_DECODED_BYTES)
    }
}

impl DracoBudget {
    /// Decodes the attributes that a primitive names.
    pub(super) fn decode(
        &mut self,
        root: &Root,
        buffers: &Buffers,
        primitive: &Primitive,
        of: &Draco,
        at: &str,
    ) -> Result<Decoded, FileFault> {
        let bytes = buffers.view(of.buffer_view)?;
        let limits = DecodeLimits::default()
            .with_max_faces(MAX_TRIANGLES)
            .with_max_points(3 * MAX_TRIANGLES)
            .with_max_decoded_bytes(self.0);
        let mut mesh = Mesh::new();
        let mut source = DecoderBuffer::new(bytes).with_limits(limits);
        MeshDecoder::new()
            .decode(&mut source, &mut mesh)
            .map_err(|error| FileFault::invalid(at, format!("Draco compression: {error}")))?;
        let points = mesh.num_points();
        let mut attributes = HashMap::new();
        for (name, &Whole(id)) in &of.attributes {
            let Some(&index) = primitive.attributes.get(name) else { continue };
            let accessor = entry(&root.accessors, index, "accessors")?;
            let attribute = u32::try_from(id).ok().and_then(|id| mesh.attribute_by_unique_id(id));
            let Some(attribute) = attribute else {
                let problem = format!("Draco compression: there is no attribute {id} for {name}");
                return Err(FileFault::invalid(at, problem));
            };
            let components = super::accessor::multiplicity(&accessor.kind).unwrap_or(0);
            self.spend((points * components * size_of::<f32>()) as u64, at)?;
            attributes.insert(name.clone(), Rc::new(attribute.read_f32s(points, components)));
        }
        let faces: Vec<[u32; 3]> = mesh.faces().iter().map(|face| face.map(|point| point.0)).collect();
        self.spend(size_of_val(&faces[..]) as u64, at)?;
        Ok(Decoded { faces, attributes, points })
    }

    fn spend(&mut self, bytes: u64, at: &str) -> Result<(), FileFault> {
        match self.0.checked_sub(bytes) {
            Some(left) => self.0 = left,
            None => {
                let at = format!("{at}: Draco compression");
                let (what, limit) = ("decoded bytes", MAX_DECODED_BYTES);
                return Err(FileFault::TooMany {
                    at,
                    what,
                    count: MAX_DECODED_BYTES + bytes - self.0,
                    limit,
                });
            }
        }
        Ok(())
    }
}
