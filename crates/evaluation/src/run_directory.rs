//! `results/<experiment>/<run>/`: created once, never overwritten.

use crate::error::EvaluationError;
use crate::provenance::Provenance;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::{Path, PathBuf};

/// A recorded file: its name and bytes.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct RecordedFile {
    /// File name within the run directory.
    pub name: String,
    /// Contents.
    pub bytes: Vec<u8>,
}

impl RecordedFile {
    /// Rows as CSV with a header.
    pub fn csv<R: Serialize>(name: &str, rows: &[R]) -> Result<Self, EvaluationError> {
        let fail = |reason: String| EvaluationError::Table { table: name.to_owned(), reason };
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in rows {
            writer.serialize(row).map_err(|error| fail(error.to_string()))?;
        }
        let bytes = writer.into_inner().map_err(|error| fail(error.to_string()))?;
        Ok(Self { name: name.to_owned(), bytes })
    }
}

/// An existing run directory.
#[derive(Clone, Debug)]
pub struct RunDirectory {
    path: PathBuf,
}

impl RunDirectory {
    /// Creates `root/experiment/run`. A name that is taken gets a number behind it.
    pub fn create(root: &Path, experiment: &str, run: &str) -> Result<Self, EvaluationError> {
        let parent = root.join(experiment);
        let fail = |path: &Path, source| EvaluationError::Write { path: path.to_owned(), source };
        std::fs::create_dir_all(&parent).map_err(|error| fail(&parent, error))?;
        let mut path = parent.join(run);
        let mut number = 2;
        loop {
            match std::fs::create_dir(&path) {
                Ok(()) => return Ok(Self { path }),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                    path = parent.join(format!("{run}-{number}"));
                    number += 1;
                }
                Err(error) => return Err(fail(&path, error)),
            }
        }
    }

    /// The newest `root/experiment/TIME-tag` without a provenance.json: a run that was not finished.
    pub(crate) fn unfinished(root: &Path, experiment: &str, tag: &str) -> Option<Self> {
        let is_tagged = |name: &str| {
            let rest = name.split_once('-').and_then(|(_, rest)| rest.strip_prefix(tag));
            // A name that was taken has a number behind it.
            rest.is_some_and(|rest| {
                rest.is_empty() || rest.strip_prefix('-').is_some_and(|n| n.parse::<u32>().is_ok())
            })
        };
        let entries = std::fs::read_dir(root.join(experiment)).ok()?;
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let unfinished = names.filter(|name| is_tagged(name)).map(|name| root.join(experiment).join(name));
        let newest = unfinished.filter(|path| !path.join("provenance.json").exists()).max()?;
        Some(Self { path: newest })
    }

    /// Removes a file that has served its purpose.
    pub(crate) fn remove(&self, name: &str) {
        // Most kinds of run never had it, and what is left over does no harm.
        let _ = std::fs::remove_file(self.path.join(name));
    }

    /// Takes back a directory in which nothing was recorded.
    pub(crate) fn remove_if_empty(&self) {
        // Whoever put something in there wants to keep it.
        let _ = std::fs::remove_dir(&self.path);
    }

    /// Opens a directory that a run has written.
    pub fn open(path: &Path) -> Result<Self, EvaluationError> {
        let provenance = path.join("provenance.json");
        if provenance.is_file() {
            return Ok(Self { path: path.to_owned() });
        }
        let reason = "is not a run directory (it has no provenance.json)".to_owned();
        Err(EvaluationError::Input { path: path.to_owned(), reason })
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file whole or not at all: to a temporary name first, then renamed.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), EvaluationError> {
        write_whole(&self.path.join(name), bytes)
    }

    /// The provenance of the run.
    pub fn provenance(&self) -> Result<Provenance, EvaluationError> {
        let (path, bytes) = self.read("provenance.json")?;
        serde_json::from_slice(&bytes)
            .map_err(|error| EvaluationError::Input { path, reason: error.to_string() })
    }

    /// The rows of a CSV file.
    pub fn rows<R: DeserializeOwned>(&self, name: &str) -> Result<Vec<R>, EvaluationError> {
        let (path, bytes) = self.read(name)?;
        let rows: Result<Vec<R>, _> = csv::Reader::from_reader(bytes.as_slice()).deserialize().collect();
        rows.map_err(|error| EvaluationError::Input { path, reason: error.to_string() })
    }

    /// A file of it.
    pub fn bytes(&self, name: &str) -> Result<Vec<u8>, EvaluationError> {
        self.read(name).map(|(_, bytes)| bytes)
    }

    /// A text file of it.
    pub fn text(&self, name: &str) -> Result<String, EvaluationError> {
        let (path, bytes) = self.read(name)?;
        String::from_utf8(bytes).map_err(|error| EvaluationError::Input { path, reason: error.to_string() })
    }

    fn read(&self, name: &str) -> Result<(PathBuf, Vec<u8>), EvaluationError> {
        let path = self.path.join(name);
        match std::fs::read(&path) {
            Ok(bytes) => Ok((path, bytes)),
            Err(error) => Err(EvaluationError::Input { path, reason: error.to_string() }),
        }
    }
}

/// Writes a file under a temporary name in the same directory, then renames it: no partial file is ever seen. Links are followed;
/// what is no file, such as a device or a pipe, is written to as it is.
///
/// # Errors
/// [`EvaluationError::Write`] for a folder, a file that may not be written, and whatever the system says.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), EvaluationError> {
    let fail = |source| EvaluationError::Write { path: path.to_owned(), source };
    let target = &followed(path).map_err(fail)?;
    match std::fs::metadata(target) {
        Ok(found) if found.is_dir() => return Err(fail(io::ErrorKind::IsADirectory.into())),
        Ok(found) if !found.is_file() => return std::fs::write(target, bytes).map_err(fail),
        Ok(found) if found.permissions().readonly() => {
            return Err(fail(io::ErrorKind::PermissionDenied.into()));
        }
        // It is new, or may be replaced.
        Ok(_) | Err(_) => {}
    }
    let name = target.file_name().ok_or_else(|| fail(io::Error::other("not a file name")))?;
    let mut temporary_name = std::ffi::OsString::from(".");
    temporary_name.push(name);
    temporary_name.push(format!(".{}.partial", std::process::id()));
    let temporary = target.with_file_name(temporary_name);
    let written = std::fs::write(&temporary, bytes).and_then(|()| std::fs::rename(&temporary, target));
    written.map_err(|source| {
        // Nothing to clean up if the temporary file could not even be created.
        let _ = std::fs::remove_file(&temporary);
        fail(source)
    })
}

/// What a path leads to over symbolic links, the last of which may lead to nothing yet.
fn followed(path: &Path) -> io::Result<PathBuf> {
    /// More links than that are a circle.
    const LINKS: usize = 40;
    let mut target = path.to_owned();
    for _ in 0..LINKS {
        match std::fs::read_link(&target) {
            Ok(next) => target = target.parent().unwrap_or(Path::new("")).join(next),
            // No link, or nothing at all.
            Err(_) => return Ok(target),
        }
    }
    Err(io::Error::other("too many symbolic links"))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn links_devices_and_read_only_files_are_left_what_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("there"), "old").unwrap();
        std::os::unix::fs::symlink("there", at("link")).unwrap();
        std::os::unix::fs::symlink("new", at("to-nothing")).unwrap();
        std::os::unix::fs::symlink("circle", at("circle")).unwrap();
        write_whole(&at("link"), b"one").unwrap();
        write_whole(&at("to-nothing"), b"two").unwrap();
        assert!(at("link").is_symlink() && at("to-nothing").is_symlink());
        assert_eq!(std::fs::read(at("there")).unwrap(), b"one");
        assert_eq!(std::fs::read(at("new")).unwrap(), b"two");
        assert!(write_whole(&at("circle"), b"three").is_err());
        let mut permissions = std::fs::metadata(at("there")).unwrap().permissions();
        permissions.set_readonly(true);
        std::fs::set_permissions(at("there"), permissions).unwrap();
        assert!(write_whole(&at("there"), b"four").is_err() && write_whole(folder.path(), b"five").is_err());
        assert_eq!(std::fs::read(at("there")).unwrap(), b"one");
        // Nobody can write there, so that nothing is changed should this fail.
        let full = Path::new("/dev/full");
        if full.exists() {
            assert!(write_whole(full, b"six").is_err());
            assert!(!std::fs::metadata(full).unwrap().is_file());
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 5);
    }
}
