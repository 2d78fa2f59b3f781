//! glTF accessors, checked in full when opened so that reading an element cannot fail.

use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::{Checked, USize64};
use gltf::json::{Index, Root, buffer};

use crate::error::FileFault;

/// The contents of each glTF buffer, at least as long as it claims.
pub(super) type Buffers<'a> = Vec<std::borrow::Cow<'a, [u8]>>;

/// The bytes of a buffer view.
pub(super) fn view_bytes<'a>(
    root: &Root,
    buffers: &'a Buffers,
    index: Index<buffer::View>,
) -> Result<&'a [u8], FileFault> {
    let at = || format!("bufferViews[{index}]");
    let view = root.get(index).ok_or_else(|| out_of_range(at(), index.value(), root.buffer_views.len()))?;
    let buffer = buffers
        .get(view.buffer.value())
        .ok_or_else(|| out_of_range(at(), view.buffer.value(), buffers.len()))?;
    // Only the claimed part of a buffer belongs to it; a file may be padded.
    let claimed =
        root.buffers.get(view.buffer.value()).map_or(0, |b| b.byte_length.0).min(buffer.len() as u64);
    let offset = view.byte_offset.unwrap_or_default().0;
    let length = view.byte_length.0;
    match offset.checked_add(length) {
        Some(end) if end <= claimed => Ok(&buffer[offset as usize..end as usize]),
        _ => Err(FileFault::invalid(
            at(),
            format!(
                "byteOffset {offset} + byteLength {length} exceeds the {claimed} bytes of buffers[{}]",
                view.buffer
            ),
        )),
    }
}

pub(super) fn out_of_range(at: String, index: usize, count: usize) -> FileFault {
    FileFault::IndexOutOfRange { at, index: index as i64, count: count as u64 }
}

/// Elements of one accessor.
pub(super) struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
    component: ComponentType,
    normalized: bool,
}

impl<'a> Elements<'a> {
    /// Opens an accessor whose elements must have the type `expected`, for an attribute called `role`.
    pub(super) fn open(
        root: &Root,
        buffers: &'a Buffers,
        index: Index<gltf::json::Accessor>,
        expected: Type,
        role: &str,
    ) -> Result<Self, FileFault> {
        let at = || format!("accessors[{index}]");
        let accessor =
            root.get(index).ok_or_else(|| out_of_range(at(), index.value(), root.accessors.len()))?;
        if accessor.sparse.is_some() {
            return Err(FileFault::unsupported(at(), "sparse accessor"));
        }
        let (Checked::Valid(component), Checked::Valid(kind)) = (&accessor.component_type, accessor.type_)
        else {
            return Err(FileFault::invalid(at(), "unknown component type or element type"));
        };
        if kind != expected {
            return Err(FileFault::invalid(
                at(),
                format!("{role} is of type {kind:?}, expected {expected:?}"),
            ));
        }
        let component = component.0;
        let Some(view_index) = accessor.buffer_view else {
            return Err(FileFault::invalid(at(), "has no bufferView"));
        };
        let view = view_bytes(root, buffers, view_index)?;
        let size = component.size() * kind.multiplicity();
        let stride = root.get(view_index).and_then(|v| v.byte_stride).map_or(size, |stride| stride.0);
        if stride < size {
            let problem = format!("byteStride {stride} is smaller than the element size {size}");
            return Err(FileFault::invalid(at(), problem));
        }
        let USize64(count) = accessor.count;
        let offset = accessor.byte_offset.unwrap_or_default().0;
        let needed = match count {
            0 => Some(0),
            _ => (count - 1).checked_mul(stride as u64).and_then(|n| n.checked_add(size as u64)),
        };
        match needed.and_then(|needed| needed.checked_add(offset)) {
            Some(end) if end <= view.len() as u64 => Ok(Self {
                bytes: &view[offset as usize..],
                stride,
                count: count as usize,
                component,
                normalized: accessor.normalized,
            }),
            _ => Err(FileFault::invalid(
                at(),
                format!(
                    "byteOffset {offset} + {count} elements of {size} bytes, {stride} apart, exceeds the {} bytes \
                     of bufferViews[{view_index}]",
                    view.len()
                ),
            )),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.count
    }

    pub(super) fn is_index_type(&self) -> bool {
        matches!(self.component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32)
    }

    /// Element `i`, which must be below [`Self::len`], as numbers; normalised integers are mapped to [-1, 1].
    pub(super) fn vector<const N: usize>(&self, i: usize) -> [f64; N] {
        std::array::from_fn(|component| self.component_at(i * self.stride, component))
    }

    /// Element `i` of a scalar accessor of unsigned integers.
    pub(super) fn index(&self, i: usize) -> u32 {
        let at = i * self.stride;
        match self.component {
            ComponentType::U8 => u32::from(self.bytes[at]),
            ComponentType::U16 => u32::from(u16::from_le_bytes(self.fixed(at))),
            _ => u32::from_le_bytes(self.fixed(at)),
        }
    }

    fn component_at(&self, start: usize, component: usize) -> f64 {
        let at = start + component * self.component.size();
        let (value, largest) = match self.component {
            ComponentType::F32 => return f64::from(f32::from_le_bytes(self.fixed(at))),
            ComponentType::U32 => return f64::from(u32::from_le_bytes(self.fixed(at))),
            ComponentType::I8 => (f64::from(i8::from_le_bytes(self.fixed(at))), 127.0),
            ComponentType::U8 => (f64::from(self.bytes[at]), 255.0),
            ComponentType::I16 => (f64::from(i16::from_le_bytes(self.fixed(at))), 32767.0),
            ComponentType::U16 => (f64::from(u16::from_le_bytes(self.fixed(at))), 65535.0),
        };
        if self.normalized { (value / largest).max(-1.0) } else { value }
    }

    fn fixed<const N: usize>(&self, at: usize) -> [u8; N] {
        std::array::from_fn(|i| self.bytes[at + i])
    }
}
