//! Buffers and their views, compressed views decoded when they are first asked for.

use std::borrow::Cow;
use std::cell::{Cell, OnceCell};

use super::accessor::entry;
use super::json::{Meshopt, Root, Whole};
use crate::error::FileFault;
use crate::load::source::Folder;

/// Most bytes that all compressed views of a file may become.
const MAX_DECODED_BYTES: u64 = 1 << 30;

/// Most bytes that one compressed byte may become: where all deltas are zero, the codec spends two bits on 16 values of a
/// byte, or with its version 1 on 256.
const MOST_FROM_A_BYTE: u64 = 1024;

/// The contents of each glTF buffer, at least as long as it claims; `None` where it has none.
pub(super) struct Buffers<'a> {
    root: &'a Root,
    bytes: Vec<Option<Cow<'a, [u8]>>>,
    decoded: Vec<OnceCell<Vec<u8>>>,
    bytes_left: Cell<u64>,
}

impl<'a> Buffers<'a> {
    pub(super) fn read(
        root: &'a Root,
        binary: Option<&'a [u8]>,
        folder: &mut Folder,
    ) -> Result<Self, FileFault> {
        let mut buffers = Vec::with_capacity(root.buffers.len());
        for (i, buffer) in root.buffers.iter().enumerate() {
            let at = format!("buffers[{i}]");
            let bytes = match (&buffer.uri, binary) {
                (Some(uri), _) => Cow::Owned(folder.read_uri(uri, &at)?),
                (None, Some(binary)) if i == 0 => Cow::Borrowed(binary),
                // Stands for what compressed views become, or is not used; told when it is.
                (None, _) => {
                    buffers.push(None);
                    continue;
                }
            };
            let claimed = buffer.byte_length.0;
            let fallback = buffer.extensions.as_ref().and_then(|e| e.meshopt.as_ref());
            if (bytes.len() as u64) < claimed {
                if fallback.is_some_and(|of| of.fallback) {
                    buffers.push(None);
                    continue;
                }
                let problem = format!("byteLength {claimed} exceeds the {} bytes that exist", bytes.len());
                return Err(FileFault::invalid(at, problem));
            }
            buffers.push(Some(bytes));
        }
        let decoded = root.buffer_views.iter().map(|_| OnceCell::new()).collect();
        Ok(Self { root, bytes: buffers, decoded, bytes_left: Cell::new(MAX_DECODED_BYTES) })
    }

    /// The bytes of a buffer view.
    pub(super) fn view(&self, index: Whole) -> Result<&[u8], FileFault> {
        let view = entry(&self.root.buffer_views, index, "bufferViews")?;
        let at = || format!("bufferViews[{}]", index.0);
        if let Some(compressed) = view.extensions.as_ref().and_then(|e| e.meshopt.as_ref()) {
            let cell = &self.decoded[index.index()];
            return match cell.get() {
                Some(bytes) => Ok(bytes),
                None => {
                    let bytes = self.decode(compressed, &at())?;
                    Ok(cell.get_or_init(|| bytes))
                }
            };
        }
        self.part(view.buffer, view.byte_offset.unwrap_or_default(), view.byte_length, &at)
    }

    fn part(
        &self,
        buffer: Whole,
        offset: Whole,
        length: Whole,
        at: &dyn Fn() -> String,
    ) -> Result<&[u8], FileFault> {
        let Some(bytes) = entry(&self.bytes, buffer, "buffers")? else {
            let at = format!("buffers[{}]", buffer.0);
            return Err(FileFault::invalid(at, "has no uri and no binary chunk"));
        };
        // Only the claimed part of a buffer belongs to it; a file may be padded.
        let claimed = self.root.buffers[buffer.index()].byte_length.0.min(bytes.len() as u64);
        match offset.0.checked_add(length.0) {
            Some(end) if end <= claimed => Ok(&bytes[offset.0 as usize..end as usize]),
            _ => Err(FileFault::invalid(
                at(),
                format!(
                    "byteOffset {} + byteLength {} exceeds the {claimed} bytes of buffers[{}]",
                    offset.0, length.0, buffer.0
                ),
            )),
        }
    }

    fn decode(&self, of: &Meshopt, at: &str) -> Result<Vec<u8>, FileFault> {
        let source =
            self.part(of.buffer, of.byte_offset.unwrap_or_default(), of.byte_length, &|| at.to_owned())?;
        let size = of.count.0.saturating_mul(of.byte_stride.0);
        let limit = self.bytes_left.get().min(MOST_FROM_A_BYTE.saturating_mul(source.len() as u64));
        if size > limit {
            let at = format!("{at}: meshopt compression");
            return Err(FileFault::TooMany { at, what: "decoded bytes", count: size, limit });
        }
        self.bytes_left.set(self.bytes_left.get() - size);
        decode_meshopt(of, source).map_err(|problem| {
            FileFault::invalid(at, format!("meshopt compression, mode {:?}: {problem}", of.mode))
        })
    }
}

/// The count and the stride of `of` must be bounded; all else is checked here, as the library takes it on trust.
fn decode_meshopt(of: &Meshopt, source: &[u8]) -> Result<Vec<u8>, String> {
    use meshopt::ffi;
    let (count, stride) = (of.count.index(), of.byte_stride.index());
    let mut bytes = vec![0_u8; count * stride];
    let fits = match of.mode.as_str() {
        "ATTRIBUTES" => stride.is_multiple_of(4) && (4..=256).contains(&stride),
        "TRIANGLES" => matches!(stride, 2 | 4) && count.is_multiple_of(3),
        "INDICES" => matches!(stride, 2 | 4),
        _ => return Err("is not known".into()),
    };
    if !fits {
        return Err(format!("{count} elements of {stride} bytes do not fit it"));
    }
    // The filters write words of up to four bytes, so that their start must be aligned: the allocator's is for far more.
    let filter = of.filter.as_deref().unwrap_or("NONE");
    let fits = match filter {
        "NONE" => true,
        "OCTAHEDRAL" | "COLOR" => matches!(stride, 4 | 8),
        "QUATERNION" => stride == 8,
        "EXPONENTIAL" => stride.is_multiple_of(4),
        _ => return Err(format!("filter {filter:?} is not known")),
    };
    if !fits || (filter != "NONE" && of.mode != "ATTRIBUTES") {
        return Err(format!("filter {filter:?} does not fit elements of {stride} bytes"));
    }
    if count == 0 {
        return Ok(bytes);
    }
    let mut words = vec![0_u32; bytes.len().div_ceil(4)];
    let out = words.as_mut_ptr().cast::<std::ffi::c_void>();
    let (from, length) = (source.as_ptr(), source.len());
    // SAFETY: `out` has room for `count` elements of `stride` bytes, which are of the sizes that the decoder of this mode
    // takes, and `from` has `length` bytes. The decoders check all that they read from there.
    let code = unsafe {
        match of.mode.as_str() {
            "ATTRIBUTES" => ffi::meshopt_decodeVertexBuffer(out, count, stride, from, length),
            "TRIANGLES" => ffi::meshopt_decodeIndexBuffer(out, count, stride, from, length),
            _ => ffi::meshopt_decodeIndexSequence(out, count, stride, from, length),
        }
    };
    if code != 0 {
        return Err(format!("{length} bytes do not hold {count} elements of {stride} bytes"));
    }
    // SAFETY: `out` holds `count` elements of `stride` bytes, of a size that the filter takes.
    unsafe {
        match filter {
            "OCTAHEDRAL" => ffi::meshopt_decodeFilterOct(out, count, stride),
            "QUATERNION" => ffi::meshopt_decodeFilterQuat(out, count, stride),
            "EXPONENTIAL" => ffi::meshopt_decodeFilterExp(out, count, stride),
            "COLOR" => ffi::meshopt_decodeFilterColor(out, count, stride),
            _ => {}
        }
    }
    for (to, word) in bytes.chunks_mut(4).zip(&words) {
        to.copy_from_slice(&word.to_ne_bytes()[..to.len()]);
    }
    Ok(bytes)
}
