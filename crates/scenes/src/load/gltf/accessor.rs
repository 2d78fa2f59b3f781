//! glTF accessors, checked in full when opened so that reading an element cannot fail.

use std::rc::Rc;

use super::buffers::Buffers;
use super::json::{Accessor, Root, Whole};
use crate::error::FileFault;

pub(super) fn out_of_range(at: String, index: usize, count: usize) -> FileFault {
    FileFault::IndexOutOfRange { at, index: index as i64, count: count as u64 }
}

/// The entry of a list that an index names.
pub(super) fn entry<'a, T>(list: &'a [T], index: Whole, what: &str) -> Result<&'a T, FileFault> {
    let index = index.index();
    list.get(index).ok_or_else(|| out_of_range(format!("{what}[{index}]"), index, list.len()))
}

/// Types of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: Whole) -> Option<Self> {
        Some(match code.0 {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The value that stands for 1 where integers are normalised.
    fn largest(self) -> f64 {
        match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32767.0,
            Self::U16 => 65535.0,
            Self::U32 => 4_294_967_295.0,
            Self::F32 => 1.0,
        }
    }

    fn is_index(self) -> bool {
        matches!(self, Self::U8 | Self::U16 | Self::U32)
    }

    /// The number at the beginning of `bytes`.
    fn read(self, bytes: &[u8]) -> f64 {
        match self {
            Self::I8 => f64::from(bytes[0] as i8),
            Self::U8 => f64::from(bytes[0]),
            Self::I16 => f64::from(i16::from_le_bytes(first(bytes))),
            Self::U16 => f64::from(u16::from_le_bytes(first(bytes))),
            Self::U32 => f64::from(u32::from_le_bytes(first(bytes))),
            Self::F32 => f64::from(f32::from_le_bytes(first(bytes))),
        }
    }

    fn read_index(self, bytes: &[u8]) -> u32 {
        match self {
            Self::U8 | Self::I8 => u32::from(bytes[0]),
            Self::U16 | Self::I16 => u32::from(u16::from_le_bytes(first(bytes))),
            Self::U32 | Self::F32 => u32::from_le_bytes(first(bytes)),
        }
    }
}

fn first<const N: usize>(bytes: &[u8]) -> [u8; N] {
    std::array::from_fn(|i| bytes[i])
}

/// Number of components of an element type.
pub(super) fn multiplicity(kind: &str) -> Option<usize> {
    Some(match kind {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        "MAT4" => 16,
        _ => return None,
    })
}

/// Where elements lie.
enum Data<'a> {
    Bytes {
        bytes: &'a [u8],
        stride: usize,
    },
    /// An accessor without buffer view is zero throughout.
    Zeros,
    /// From a compressed mesh: a number for each component, one element after another.
    Decoded(Rc<Vec<f32>>),
}

/// Elements that replace those of a sparse accessor.
struct Replaced<'a> {
    /// Ascending.
    indices: Vec<u32>,
    values: &'a [u8],
}

/// Elements of one accessor.
pub(super) struct Elements<'a> {
    data: Data<'a>,
    replaced: Option<Replaced<'a>>,
    count: usize,
    components: usize,
    component: Component,
    normalized: bool,
}

impl<'a> Elements<'a> {
    /// Opens an accessor whose elements must have one of the types `expected`, for an attribute called `role`.
    pub(super) fn open(
        root: &'a Root,
        buffers: &'a Buffers<'a>,
        index: Whole,
        expected: &[&str],
        role: &str,
    ) -> Result<Self, FileFault> {
        let at = || format!("accessors[{}]", index.0);
        let accessor = entry(&root.accessors, index, "accessors")?;
        let shape = Self::shape(accessor, expected, role, &at)?;
        let size = shape.component.size() * shape.components;
        let count = shape.count;
        let data = match accessor.buffer_view {
            None => Data::Zeros,
            Some(view_index) => {
                let view = buffers.view(view_index)?;
                let stride = entry(&root.buffer_views, view_index, "bufferViews")?.byte_stride;
                let stride = stride.map_or(size, Whole::index);
                if stride < size {
                    let problem = format!("byteStride {stride} is smaller than the element size {size}");
                    return Err(FileFault::invalid(at(), problem));
                }
                let offset = accessor.byte_offset.unwrap_or_default().0;
                let needed = match count {
                    0 => Some(0),
                    _ => {
                        (count as u64 - 1).checked_mul(stride as u64).and_then(|n| n.checked_add(size as u64))
                    }
                };
                match needed.and_then(|needed| needed.checked_add(offset)) {
                    Some(end) if end <= view.len() as u64 => {
                        Data::Bytes { bytes: &view[offset as usize..], stride }
                    }
                    _ => {
                        let problem = format!(
                            "byteOffset {offset} + {count} elements of {size} bytes, {stride} apart, exceeds the {} \
                             bytes of bufferViews[{}]",
                            view.len(),
                            view_index.0
                        );
                        return Err(FileFault::invalid(at(), problem));
                    }
                }
            }
        };
        let replaced = replaced(buffers, accessor, count, size, &at)?;
        Ok(Self { data, replaced, ..shape })
    }

    /// The elements of a compressed mesh in place of an accessor's own bytes; `values` has as many for each element as the
    /// accessor's type says.
    pub(super) fn decoded(
        accessor: &Accessor,
        values: Rc<Vec<f32>>,
        count: usize,
        expected: &[&str],
        role: &str,
    ) -> Result<Self, FileFault> {
        let shape = Self::shape(accessor, expected, role, &|| role.to_owned())?;
        Ok(Self { data: Data::Decoded(values), count, ..shape })
    }

    fn shape(
        accessor: &Accessor,
        expected: &[&str],
        role: &str,
        at: &dyn Fn() -> String,
    ) -> Result<Self, FileFault> {
        let (Some(component), Some(components)) =
            (Component::of(accessor.component_type), multiplicity(&accessor.kind))
        else {
            let (component, kind) = (accessor.component_type.0, &accessor.kind);
            let problem = format!("{role} has unknown component type {component} or element type {kind:?}");
            return Err(FileFault::invalid(at(), problem));
        };
        if !expected.contains(&accessor.kind.as_str()) {
            let problem = format!("{role} is of type {}, expected {}", accessor.kind, expected.join(" or "));
            return Err(FileFault::invalid(at(), problem));
        }
        let count = accessor.count.0;
        if count > u64::from(u32::MAX) {
            let limit = u64::from(u32::MAX);
            return Err(FileFault::TooMany { at: at(), what: "elements", count, limit });
        }
        Ok(Self {
            data: Data::Zeros,
            replaced: None,
            count: count as usize,
            components,
            component,
            normalized: accessor.normalized,
        })
    }

    pub(super) fn len(&self) -> usize {
        self.count
    }

    pub(super) fn is_index_type(&self) -> bool {
        self.component.is_index()
    }

    /// Integers count as normalised whatever the accessor says.
    pub(super) fn into_normalized(self) -> Self {
        Self { normalized: true, ..self }
    }

    /// Element `i`, which must be below [`Self::len`], as numbers; normalised integers are mapped to [-1, 1]. Components that
    /// the type lacks are 1.
    pub(super) fn vector<const N: usize>(&self, i: usize) -> [f64; N] {
        // Nearly all there is.
        if let (Data::Bytes { bytes, stride }, None, Component::F32) =
            (&self.data, &self.replaced, self.component)
            && N <= self.components
        {
            let element = &bytes[i * stride..][..4 * N];
            return std::array::from_fn(|k| f64::from(f32::from_le_bytes(first(&element[4 * k..]))));
        }
        match (&self.data, self.bytes_of(i)) {
            (Data::Decoded(values), _) => std::array::from_fn(|k| {
                let value = values.get(i * self.components + k).filter(|_| k < self.components);
                value.map_or(1.0, |&value| self.scaled(f64::from(value)))
            }),
            (_, None) => std::array::from_fn(|k| if k < self.components { 0.0 } else { 1.0 }),
            (_, Some(bytes)) => std::array::from_fn(|k| {
                if k >= self.components {
                    return 1.0;
                }
                self.scaled(self.component.read(&bytes[k * self.component.size()..]))
            }),
        }
    }

    /// Element `i` of a scalar accessor of unsigned integers.
    pub(super) fn index(&self, i: usize) -> u32 {
        self.bytes_of(i).map_or(0, |bytes| self.component.read_index(bytes))
    }

    /// One number of a list that is read without regard to the element type.
    pub(super) fn number(&self, i: usize) -> f64 {
        self.vector::<1>(i)[0]
    }

    fn bytes_of(&self, i: usize) -> Option<&'a [u8]> {
        if let Some(replaced) = &self.replaced
            && let Ok(place) = replaced.indices.binary_search(&(i as u32))
        {
            return Some(&replaced.values[place * self.components * self.component.size()..]);
        }
        match self.data {
            Data::Bytes { bytes, stride } => Some(&bytes[i * stride..]),
            Data::Zeros | Data::Decoded(_) => None,
        }
    }

    fn scaled(&self, value: f64) -> f64 {
        if self.normalized { (value / self.component.largest()).max(-1.0) } else { value }
    }
}

fn replaced<'a>(
    buffers: &'a Buffers<'a>,
    accessor: &Accessor,
    count: usize,
    size: usize,
    at: &dyn Fn() -> String,
) -> Result<Option<Replaced<'a>>, FileFault> {
    let Some(sparse) = &accessor.sparse else { return Ok(None) };
    let at = || format!("{}.sparse", at());
    let many = sparse.count.0;
    let component = Component::of(sparse.indices.component_type).filter(|component| component.is_index());
    let Some(component) = component else {
        let problem = format!("indices have component type {}", sparse.indices.component_type.0);
        return Err(FileFault::invalid(at(), problem));
    };
    let part = |view: Whole, offset: Option<Whole>, size: usize, what: &str| {
        let bytes = buffers.view(view)?;
        let offset = offset.unwrap_or_default().0;
        let end = many.checked_mul(size as u64).and_then(|needed| needed.checked_add(offset));
        match end {
            Some(end) if end <= bytes.len() as u64 => Ok(&bytes[offset as usize..end as usize]),
            _ => Err(FileFault::invalid(
                at(),
                format!(
                    "byteOffset {offset} + {many} {what} of {size} bytes exceeds the {} bytes of bufferViews[{}]",
                    bytes.len(),
                    view.0
                ),
            )),
        }
    };
    let indices = part(sparse.indices.buffer_view, sparse.indices.byte_offset, component.size(), "indices")?;
    let values = part(sparse.values.buffer_view, sparse.values.byte_offset, size, "values")?;
    let indices: Vec<u32> =
        indices.chunks_exact(component.size()).map(|bytes| component.read_index(bytes)).collect();
    if let Some(place) = indices.windows(2).position(|pair| pair[0] >= pair[1]) {
        let problem = format!("indices {} and {} do not ascend", indices[place], indices[place + 1]);
        return Err(FileFault::invalid(at(), problem));
    }
    if let Some(&last) = indices.last().filter(|&&last| last as usize >= count) {
        return Err(out_of_range(at(), last as usize, count));
    }
    Ok(Some(Replaced { indices, values }))
}
