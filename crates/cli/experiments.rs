//! Experiments by name: files first, else those that the binary brings along.

use crate::outcome::Failure;
use anyhow::{Context, anyhow};
use evaluation::{Experiment, Scale};
use std::path::{Path, PathBuf};

/// Name and text of every file in `experiments/` when this binary was built.
static EMBEDDED: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/experiments.rs"));

/// Where experiments lie in a checkout.
const FOLDER: &str = "experiments";

/// Names of those that the binary brings along.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    EMBEDDED.iter().map(|(name, _)| *name)
}

/// What a user means by an experiment.
enum Found {
    File(PathBuf),
    /// Name and text.
    Embedded(&'static str, &'static str),
}

/// A file, or a name: that of `experiments/NAME.toml` where there is one, else the embedded one.
fn find(wanted: &Path) -> Result<Found, Failure> {
    let file = || Ok(Found::File(wanted.to_owned()));
    let Some(stem) = wanted.file_stem().filter(|_| !wanted.exists()).map(|stem| stem.to_string_lossy())
    else {
        return file();
    };
    let is_name = wanted.components().count() == 1 && wanted.extension().is_none();
    let beside = Path::new(FOLDER).join(format!("{stem}.toml"));
    if is_name && beside.exists() {
        return Ok(Found::File(beside));
    }
    // A path into a checkout that is not there means the file of that name, too.
    let is_there = wanted.parent().is_some_and(|parent| parent == Path::new(FOLDER)) || is_name;
    match EMBEDDED.iter().find(|(name, _)| is_there && *name == stem) {
        Some((name, text)) => Ok(Found::Embedded(name, text)),
        None if is_name => Err(Failure::Input(anyhow!(
            "no experiment `{stem}`: neither a file nor one of {}",
            names().collect::<Vec<_>>().join(", ")
        ))),
        None => file(),
    }
}

/// The experiment of a file or of a name.
pub(crate) fn read(wanted: &Path, scale: Scale, seed: Option<u64>) -> Result<Experiment, Failure> {
    Ok(match find(wanted)? {
        Found::File(path) => Experiment::read(&path, scale, seed)?,
        Found::Embedded(name, text) => embedded(name, text, scale, seed)?,
    })
}

/// Its text.
pub(crate) fn text(wanted: &Path) -> Result<Vec<u8>, Failure> {
    Ok(match find(wanted)? {
        Found::File(path) => std::fs::read(&path).with_context(|| path.display().to_string())?,
        Found::Embedded(_, text) => text.as_bytes().to_vec(),
    })
}

fn embedded(
    name: &str,
    text: &str,
    scale: Scale,
    seed: Option<u64>,
) -> Result<Experiment, evaluation::EvaluationError> {
    Experiment::parse(Path::new(&format!("{name}.toml")), text, scale, seed)
}

/// All experiments of a folder; without one those of `experiments/` if it is there, else the embedded ones.
pub(crate) fn all(folder: Option<&Path>, scale: Scale) -> Result<Vec<Experiment>, Failure> {
    let beside = Path::new(FOLDER);
    let Some(folder) = folder.or_else(|| beside.is_dir().then_some(beside)) else {
        let read = |(name, text): &(&str, &str)| embedded(name, text, scale, None);
        return Ok(EMBEDDED.iter().map(read).collect::<Result<_, _>>()?);
    };
    let missing = |reason: String| Failure::Input(anyhow!("{}: {reason}", folder.display()));
    let entries = std::fs::read_dir(folder).map_err(|error| missing(error.to_string()))?;
    let mut files: Vec<PathBuf> = Vec::new();
    for entry in entries {
        let path = entry.context("reading the folder of experiments")?.path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            files.push(path);
        }
    }
    if files.is_empty() {
        return Err(missing("holds no experiment (.toml)".to_owned()));
    }
    let read = |file: &PathBuf| Experiment::read(file, scale, None);
    Ok(files.iter().map(read).collect::<Result<_, _>>()?)
}
