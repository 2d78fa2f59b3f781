//! Experiments as the binary runs them: advice, errors of techniques on a scene, and recorded runs.

use crate::{failed, input};
use evaluation::{
    Advice, AdviceOptions, Backend, Budget, Build, EvaluationError, Experiment, Lighting, RunDirectory,
    RunOptions, Scale,
};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use scenes::AreaLight;
use std::path::{Path, PathBuf};
use std::time::Duration;

fn fault(error: &EvaluationError) -> PyErr {
    if error.is_input() { input(error) } else { failed(error) }
}

/// `msm advise` as JSON.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the options of the verb")]
pub(crate) fn advise(
    py: Python<'_>,
    scene: &str,
    views: Vec<String>,
    light: Option<String>,
    tolerance: Option<f64>,
    relative: f64,
    size: Option<u32>,
    seed: Option<u64>,
    candidates: Option<PathBuf>,
    threads: Option<usize>,
) -> PyResult<String> {
    let light = light.map(|text| text.parse::<AreaLight>()).transpose();
    let light = light.map_err(|error| PyValueError::new_err(format!("light: {error}")))?;
    let progress = |_: usize, _: usize| {};
    let advice = py.detach(|| {
        let options = AdviceOptions {
            scene,
            lighting: Lighting { views, file: None, light },
            tolerance,
            relative,
            budget: Budget::default(),
            size,
            kernel: None,
            medium: None,
            seed,
            candidates: candidates.as_deref(),
            gpu: false,
            pictures: false,
            progress: &progress,
        };
        Advice::seek_on(&options, threads).map(|(advice, _)| advice).map_err(|error| fault(&error))
    })?;
    serde_json::to_string(&advice).map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

/// Runs an experiment's text in a folder and returns its `records.csv`.
#[pyfunction]
pub(crate) fn error(py: Python<'_>, text: &str, folder: PathBuf, threads: Option<usize>) -> PyResult<String> {
    py.detach(|| run(text, &folder, threads).map_err(|error| fault(&error)))
}

fn run(text: &str, folder: &Path, threads: Option<usize>) -> Result<String, EvaluationError> {
    let path = folder.join("error.toml");
    std::fs::write(&path, text).map_err(|source| EvaluationError::Write { path: path.clone(), source })?;
    let unknown = || "unknown".to_owned();
    let options = RunOptions {
        results: folder,
        scale: Scale::Quick,
        threads,
        resume: false,
        shard: None,
        merge: &[],
        patience: Duration::ZERO,
        backend: Backend::default(),
        build: Build {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: unknown(),
            dirty: unknown(),
            rustc: unknown(),
        },
        command: "msm.error".to_owned(),
        progress: &|_, _| {},
    };
    Experiment::read(&path, Scale::Quick, None)?.run(&options)?.directory.text("records.csv")
}

/// The tables of a run by their names, and its provenance.
#[pyfunction]
pub(crate) fn run_files(py: Python<'_>, path: PathBuf) -> PyResult<Vec<(String, String)>> {
    py.detach(|| {
        let run = RunDirectory::open(&path).map_err(|error| fault(&error))?;
        let entries =
            std::fs::read_dir(run.path()).map_err(|error| PyValueError::new_err(error.to_string()))?;
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let mut names: Vec<String> =
            names.filter(|name| name.ends_with(".csv") || name == "provenance.json").collect();
        names.sort();
        let each = |name: String| Ok((name.clone(), run.text(&name).map_err(|error| fault(&error))?));
        names.into_iter().map(each).collect()
    })
}
