//! The encoding of text files.

use std::borrow::Cow;

use super::warnings::{WarningKind, Warnings};
use crate::error::FileFault;

/// Bytes as UTF-8 without byte order mark. UTF-16 is told by its mark, or by every other byte of the first characters being
/// zero, and converted; UTF-32 is refused. Anything else is taken as it is.
pub(super) fn as_utf8<'a>(
    bytes: &'a [u8],
    at: &str,
    warnings: &mut Warnings,
) -> Result<Cow<'a, [u8]>, FileFault> {
    /// A unit of UTF-16 from its bytes.
    type Unit = fn([u8; 2]) -> u16;
    let (rest, decode): (&[u8], Unit) = match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => {
            warnings.add(WarningKind::ByteOrderMark, at, || format!("{at} begins with a byte order mark"));
            return Ok(Cow::Borrowed(rest));
        }
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => {
            return Err(FileFault::unsupported(at, "text encoding UTF-32: save it as UTF-8"));
        }
        [0xff, 0xfe, rest @ ..] => (rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => (rest, u16::from_be_bytes),
        [first, 0, second, 0, ..] if *first != 0 && *second != 0 => (bytes, u16::from_le_bytes),
        [0, first, 0, second, ..] if *first != 0 && *second != 0 => (bytes, u16::from_be_bytes),
        _ => return Ok(Cow::Borrowed(bytes)),
    };
    warnings.add(WarningKind::Encoding, at, || format!("{at} is text in UTF-16"));
    let units = rest.chunks_exact(2).map(|pair| decode([pair[0], pair[1]]));
    let text: String = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
    Ok(Cow::Owned(text.into_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_taken_off_and_utf16_is_converted() {
        let read = |bytes: &[u8]| {
            let mut warnings = Warnings::default();
            let text = as_utf8(bytes, "file", &mut warnings).unwrap().into_owned();
            (String::from_utf8(text).unwrap(), warnings.into_list().len())
        };
        assert_eq!(read(b"v 1"), ("v 1".into(), 0));
        assert_eq!(read(b"\xef\xbb\xbfv 1"), ("v 1".into(), 1));
        let units = || "v é".encode_utf16();
        let little: Vec<u8> = units().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = units().flat_map(u16::to_be_bytes).collect();
        assert_eq!(read(&[&[0xff, 0xfe], &little[..]].concat()), ("v é".into(), 1));
        assert_eq!(read(&[&[0xfe, 0xff], &big[..]].concat()), ("v é".into(), 1));
        assert_eq!(read(&little), ("v é".into(), 1));
        assert_eq!(read(&big), ("v é".into(), 1));
        let refused = as_utf8(&[0xff, 0xfe, 0, 0, b'v', 0, 0, 0], "file", &mut Warnings::default());
        assert!(refused.unwrap_err().to_string().contains("UTF-32"));
    }
}
