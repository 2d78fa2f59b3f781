//! The binary glTF container: a header and two chunks.
//!
//! Read here and not by a library, so that lengths are checked and messages carry the numbers.

use crate::error::FileFault;

const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;

/// The JSON text and the binary chunk, where there is one.
pub(super) type Chunks<'a> = (&'a [u8], Option<&'a [u8]>);

pub(super) fn is_glb(bytes: &[u8]) -> bool {
    bytes.starts_with(b"glTF")
}

/// Splits a GLB. Bytes after the length given in the header are ignored, as are chunks of unknown type.
pub(super) fn split(bytes: &[u8]) -> Result<Chunks<'_>, FileFault> {
    let at = "GLB header";
    let (Some(version), Some(length)) = (u32_at(bytes, 4), u32_at(bytes, 8)) else {
        let problem = format!("truncated: {} of {HEADER_BYTES} bytes", bytes.len());
        return Err(FileFault::invalid(at, problem));
    };
    if version != 2 {
        let convert = "glTF 2.0 is read; convert the file with gltf-pipeline or Blender";
        return Err(FileFault::unsupported(at, format!("version {version}: {convert}")));
    }
    let length = length as usize;
    if length < HEADER_BYTES || length > bytes.len() {
        let problem = format!("length {length} does not fit the file's {} bytes", bytes.len());
        return Err(FileFault::invalid(at, problem));
    }
    let (json_type, json, mut offset) = chunk(&bytes[..length], HEADER_BYTES)?;
    if json_type != *b"JSON" {
        return Err(FileFault::invalid("GLB chunk at byte 12", format!("type {json_type:?} is not JSON")));
    }
    let mut binary = None;
    while offset < length {
        let (kind, data, next) = chunk(&bytes[..length], offset)?;
        if kind == *b"BIN\0" && binary.is_none() {
            binary = Some(data);
        }
        offset = next;
    }
    Ok((json, binary))
}

/// Type, contents and end of the chunk that starts at `offset`.
fn chunk(bytes: &[u8], offset: usize) -> Result<([u8; 4], &[u8], usize), FileFault> {
    let at = || format!("GLB chunk at byte {offset}");
    let left = bytes.len() - offset;
    let (Some(length), Some(kind)) = (u32_at(bytes, offset), four_at(bytes, offset + 4)) else {
        let problem = format!("truncated: {left} bytes left, its header takes {CHUNK_HEADER_BYTES}");
        return Err(FileFault::invalid(at(), problem));
    };
    let start = offset + CHUNK_HEADER_BYTES;
    match start.checked_add(length as usize).and_then(|end| Some((bytes.get(start..end)?, end))) {
        Some((data, end)) => Ok((kind, data, end)),
        None => {
            let problem = format!("length {length} exceeds the {} bytes left", left - CHUNK_HEADER_BYTES);
            Err(FileFault::invalid(at(), problem))
        }
    }
}

fn four_at(bytes: &[u8], offset: usize) -> Option<[u8; 4]> {
    bytes.get(offset..offset + 4)?.try_into().ok()
}

fn u32_at(bytes: &[u8], offset: usize) -> Option<u32> {
    four_at(bytes, offset).map(u32::from_le_bytes)
}
