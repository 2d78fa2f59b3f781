//! From an experiment to a run directory.

use crate::error::EvaluationError;
use crate::experiment::{Experiment, Kind, Scale};
use crate::provenance::{Build, Provenance, cpu_model, logical_cores, sha256, utc};
use crate::run_directory::{RecordedFile, RunDirectory};
use rayon::ThreadPoolBuilder;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Instant, SystemTime};

/// Called with trials done and trials in all, from any thread.
pub type Progress<'a> = &'a (dyn Fn(usize, usize) + Sync);

/// What a run needs to know beside the experiment.
pub struct RunOptions<'a> {
    /// Directory under which `<experiment>/<run>/` is created.
    pub results: &'a Path,
    /// Scale the experiment was resolved at.
    pub scale: Scale,
    /// Worker threads; without it one per logical core.
    pub threads: Option<usize>,
    /// The code that runs.
    pub build: Build,
    /// The command line, for the provenance.
    pub command: String,
    /// Progress.
    pub progress: Progress<'a>,
}

/// What the trials of an experiment left.
pub(crate) struct Recorded {
    pub(crate) files: Vec<RecordedFile>,
    pub(crate) trials: usize,
    pub(crate) failed: usize,
}

/// A finished run.
#[derive(Clone, Debug)]
pub struct Run {
    /// Where it is recorded.
    pub directory: RunDirectory,
    /// Number of trials, failed ones included.
    pub trials: usize,
    /// Trials whose record has its `error` filled.
    pub failed: usize,
}

impl Experiment {
    /// Runs all trials and records them. The run is complete when its directory has a provenance.json.
    pub fn run(&self, options: &RunOptions<'_>) -> Result<Run, EvaluationError> {
        let threads = options.threads.unwrap_or_else(logical_cores);
        if threads == 0 {
            return Err(EvaluationError::Value("0 threads cannot work: at least 1 is needed".to_owned()));
        }
        let fail = |error: rayon::ThreadPoolBuildError| EvaluationError::Threads {
            threads,
            reason: error.to_string(),
        };
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().map_err(fail)?;
        let started = utc(SystemTime::now());
        let clock = Instant::now();
        let name: String = started.chars().filter(char::is_ascii_alphanumeric).collect();
        // First, so that a directory that cannot be written shows before the work and not after it.
        let directory =
            RunDirectory::create(options.results, &self.name, &format!("{name}-{}", options.scale))?;
        let (result, seed) = match &self.kind {
            Kind::Bounds(experiment) => (pool.install(|| experiment.run(options.progress)), experiment.seed),
            Kind::Filterable(experiment) => {
                (pool.install(|| experiment.run(options.progress)), experiment.seed)
            }
        };
        let located = |error| self.located(error, options.scale);
        let recorded = result.inspect_err(|_| directory.remove_if_empty()).map_err(located)?;
        let mut inputs = BTreeMap::from([(format!("{}.toml", self.name), sha256(self.source.as_bytes()))]);
        for scene in self.scenes() {
            // Procedural scenes are no files; a scene file was read a moment ago.
            if let (Some(name), Ok(bytes)) = (Path::new(scene).file_name(), std::fs::read(scene)) {
                inputs.insert(name.to_string_lossy().into_owned(), sha256(&bytes));
            }
        }
        let provenance = Provenance {
            build: options.build.clone(),
            command: options.command.clone(),
            scale: options.scale.to_string(),
            seed,
            threads,
            started,
            seconds: (clock.elapsed().as_secs_f64() * 1e3).round() / 1e3,
            cpu: cpu_model(),
            logical_cores: logical_cores(),
            os: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            inputs,
        };
        directory.write("experiment.toml", self.resolved.to_string().as_bytes())?;
        for file in &recorded.files {
            directory.write(&file.name, &file.bytes)?;
        }
        let fail = |error: serde_json::Error| EvaluationError::Table {
            table: "provenance.json".to_owned(),
            reason: error.to_string(),
        };
        let mut json = serde_json::to_vec_pretty(&provenance).map_err(fail)?;
        json.push(b'\n');
        // Last, because it marks the run as complete.
        directory.write("provenance.json", &json)?;
        Ok(Run { directory, trials: recorded.trials, failed: recorded.failed })
    }
}
