//! Several files that appear together, when all of them are complete, or not at all.

use anyhow::{Context, anyhow};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// A folder for files in the making, inside the folder in which they will appear.
///
/// Dropped before [`Staging::publish`], it takes back everything, the folders that it had to create included.
pub(crate) struct Staging {
    target: PathBuf,
    /// Known once it exists and is this process's own.
    folder: Option<PathBuf>,
    /// Folders that did not exist before, innermost first.
    created: Vec<PathBuf>,
}

impl Staging {
    /// Creates `target` where it is missing; fails at once if none of `names` can be written there.
    pub(crate) fn new(target: &Path, names: &[String]) -> anyhow::Result<Self> {
        let missing = target.ancestors().filter(|path| !path.as_os_str().is_empty() && !path.exists());
        let created = missing.map(Path::to_owned).collect();
        let mut staging = Self { target: target.to_owned(), folder: None, created };
        for name in names {
            let path = target.join(name);
            if path.is_dir() {
                return Err(anyhow!("{}: a folder has the name of a file to be written", path.display()));
            }
        }
        std::fs::create_dir_all(target).with_context(|| target.display().to_string())?;
        // Processes that share the folder but not the machine may have the same number.
        for attempt in 0..100 {
            let folder = target.join(format!(".msm-{}-{attempt}.partial", std::process::id()));
            match std::fs::create_dir(&folder) {
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                created => {
                    created.with_context(|| target.display().to_string())?;
                    staging.folder = Some(folder);
                    return Ok(staging);
                }
            }
        }
        Err(anyhow!("{}: too many unfinished `.msm-*.partial` folders", target.display()))
    }

    /// Where a file is to be written until it is complete.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.as_deref().unwrap_or(&self.target).join(name)
    }

    /// Gives the files their place, replacing older ones, and returns their paths.
    pub(crate) fn publish(mut self, names: &[String]) -> anyhow::Result<Vec<PathBuf>> {
        let mut published = Vec::with_capacity(names.len());
        for name in names {
            let path = self.target.join(name);
            std::fs::rename(self.path(name), &path).with_context(|| path.display().to_string())?;
            published.push(path);
        }
        self.created.clear();
        Ok(published)
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        // Failures here must not hide the one that is being reported; folders in use stay.
        if let Some(folder) = &self.folder {
            let _ = std::fs::remove_dir_all(folder);
        }
        for folder in &self.created {
            let _ = std::fs::remove_dir(folder);
        }
    }
}
