//! Reading files and the files that they name, without leaving the folder or the memory limit.

use std::fs::{self, File};
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use super::MAX_FILE_BYTES;
use crate::error::FileFault;

/// Reads a regular file of at most `limit` bytes. Devices and pipes are refused: they may never end.
pub(crate) fn read_limited(path: &Path, limit: u64) -> Result<Vec<u8>, FileFault> {
    let unreadable = |error: std::io::Error| FileFault::unreadable(error.to_string());
    let metadata = fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(FileFault::unreadable("not a regular file"));
    }
    let too_large = |count| FileFault::TooMany { at: "file size".into(), what: "bytes", count, limit };
    if metadata.len() > limit {
        return Err(too_large(metadata.len()));
    }
    let mut bytes = Vec::with_capacity(metadata.len() as usize);
    // The file may grow between the two calls.
    File::open(path).and_then(|file| file.take(limit + 1).read_to_end(&mut bytes)).map_err(unreadable)?;
    if bytes.len() as u64 > limit { Err(too_large(bytes.len() as u64)) } else { Ok(bytes) }
}

/// The folder whose files a scene may name, and how many bytes it may still read.
pub(crate) struct Folder {
    path: Option<PathBuf>,
    bytes_left: u64,
    /// Files read, in their order.
    read: Vec<PathBuf>,
}

impl Folder {
    /// The folder that holds `file`.
    pub(crate) fn of(file: &Path) -> Self {
        let parent = match file.parent() {
            Some(parent) if parent != Path::new("") => parent.to_path_buf(),
            _ => PathBuf::from("."),
        };
        Self { path: Some(parent), bytes_left: MAX_FILE_BYTES, read: Vec::new() }
    }

    /// No folder: every external file is refused.
    pub(crate) fn none() -> Self {
        Self { path: None, bytes_left: MAX_FILE_BYTES, read: Vec::new() }
    }

    /// The files that were read, as they were named, each once.
    pub(crate) fn into_read(self) -> Vec<PathBuf> {
        self.read
    }

    /// The bytes of a glTF URI: a base64 `data:` URI, or a percent-encoded relative path within the folder.
    pub(crate) fn read_uri(&mut self, uri: &str, at: &str) -> Result<Vec<u8>, FileFault> {
        if uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")) {
            return decode_data_uri(&uri[5..], at);
        }
        if let Some(scheme) = scheme(uri) {
            return Err(FileFault::unsupported(at, format!("URI scheme {scheme:?} in {uri:?}")));
        }
        let decoded = percent_encoding::percent_decode_str(uri)
            .decode_utf8()
            .map_err(|error| FileFault::invalid(at, format!("URI {uri:?}: {error}")))?;
        self.read_path(&decoded, at)
    }

    /// The bytes of a file named by a relative path that stays within the folder, symbolic links followed.
    pub(crate) fn read_path(&mut self, name: &str, at: &str) -> Result<Vec<u8>, FileFault> {
        let refuse = |why: &str| Err(FileFault::invalid(at, format!("file {name:?} {why}")));
        // On other systems `\` separates folders and `C:` is absolute: refused everywhere alike.
        let leaves = Path::new(name)
            .components()
            .any(|component| !matches!(component, Component::Normal(_) | Component::CurDir));
        if name.contains(['\\', ':', '\0']) || leaves {
            return refuse("does not lie in the scene's folder");
        }
        let Some(folder) = &self.path else {
            return refuse("cannot be read: the scene comes from memory and has no folder");
        };
        let resolve = |path: &Path| {
            fs::canonicalize(path)
                .map_err(|error| FileFault::invalid(at, format!("file {name:?} cannot be read: {error}")))
        };
        let named = folder.join(name);
        let path = resolve(&named)?;
        if !path.starts_with(resolve(folder)?) {
            return refuse("is a link out of the scene's folder");
        }
        let bytes = read_limited(&path, self.bytes_left).map_err(|fault| match fault {
            FileFault::Unreadable { problem } => {
                FileFault::invalid(at, format!("file {name:?} cannot be read: {problem}"))
            }
            FileFault::TooMany { what, count, limit, .. } => {
                FileFault::TooMany { at: format!("{at}: size of file {name:?}"), what, count, limit }
            }
            other => other,
        })?;
        self.bytes_left -= bytes.len() as u64;
        if !self.read.contains(&named) {
            self.read.push(named);
        }
        Ok(bytes)
    }
}

/// The scheme of an absolute URI: what stands before a colon, where no separator comes first.
fn scheme(uri: &str) -> Option<&str> {
    let end = uri.find([':', '/', '?', '#', '%'])?;
    (uri.as_bytes()[end] == b':').then(|| &uri[..end])
}

fn decode_data_uri(rest: &str, at: &str) -> Result<Vec<u8>, FileFault> {
    let Some((head, body)) = rest.split_once(',') else {
        return Err(FileFault::invalid(at, "data URI without a comma"));
    };
    if !head.to_ascii_lowercase().ends_with(";base64") {
        return Err(FileFault::unsupported(at, format!("data URI of type {head:?}: only base64 is read")));
    }
    // Padding is often left out in practice.
    let config = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    GeneralPurpose::new(&STANDARD, config)
        .decode(body.trim())
        .map_err(|error| FileFault::invalid(at, format!("data URI is not base64: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(uri: &str) -> String {
        let mut folder = Folder {
            path: Some(PathBuf::from(env!("CARGO_MANIFEST_DIR"))),
            bytes_left: 1 << 20,
            read: Vec::new(),
        };
        folder.read_uri(uri, "buffers[0]").unwrap_err().to_string()
    }

    #[test]
    fn uris_that_leave_the_folder_are_refused() {
        for uri in [
            "/etc/hostname",
            "../Cargo.toml",
            "src/../../Cargo.toml",
            "%2e%2e/Cargo.toml",
            "..%2FCargo.toml",
            "%2Fetc/hostname",
            "..\\Cargo.toml",
            "src%5C..%5CCargo.toml",
            "a%00b",
            "C%3A%5Cboot.ini",
        ] {
            let message = refused(uri);
            assert!(message.contains("does not lie in the scene's folder"), "{uri}: {message}");
        }
    }

    #[test]
    fn schemes_are_unsupported_and_named() {
        for uri in ["http://example.org/a.bin", "HTTPS://x/a", "file:///etc/hostname", "C:/boot.ini"] {
            let message = refused(uri);
            assert!(message.contains("unsupported URI scheme") && message.contains(uri), "{message}");
        }
    }

    #[test]
    fn directories_missing_files_and_bad_data_are_told_apart() {
        assert!(refused("src").contains("not a regular file"));
        assert!(refused("no_such_file.bin").contains("\"no_such_file.bin\" cannot be read"));
        assert!(refused("%FF.bin").contains("invalid utf-8"));
        assert!(refused("data:application/octet-stream;base64").contains("without a comma"));
        assert!(refused("data:text/plain,abc").contains("only base64"));
        assert!(refused("data:;base64,a*c=").contains("not base64"));
    }

    #[test]
    fn a_file_in_the_folder_and_a_data_uri_are_read() {
        let mut folder = Folder {
            path: Some(PathBuf::from(env!("CARGO_MANIFEST_DIR"))),
            bytes_left: 1 << 20,
            read: Vec::new(),
        };
        let bytes = folder.read_uri("./src/../Cargo.toml", "x");
        assert!(bytes.is_err(), "even a harmless .. is refused");
        assert!(folder.read_uri("./Cargo%2Etoml", "x").unwrap().starts_with(b"[package]"));
        assert_eq!(folder.read_uri("data:;base64,AAEC", "x").unwrap(), [0, 1, 2]);
        assert_eq!(folder.read_uri("DATA:a/b;BASE64,AAE", "x").unwrap(), [0, 1]);
        folder.bytes_left = 3;
        let message = folder.read_uri("Cargo.toml", "x").unwrap_err().to_string();
        assert!(message.contains("exceed the limit of 3"), "{message}");
    }
}
