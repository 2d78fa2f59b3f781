//! From an experiment to a run directory.

use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::experiment::{Experiment, Prediction, Scale};
use crate::provenance::{Build, Provenance, cpu_model, inputs, logical_cores, sha256, utc};
use crate::run_directory::{RecordedFile, RunDirectory};
use crate::shards::{self, Shard, Task};
use rayon::ThreadPoolBuilder;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// What solves the linear programs of a search without race.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// The CPU.
    #[default]
    Cpu,
    /// A graphics processor with double precision; without one the run fails.
    Gpu,
    /// A graphics processor if there is a fast one, else the CPU.
    Auto,
}

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
    /// Go on with the newest unfinished run of this experiment and scale, if there is one.
    pub resume: bool,
    /// Work only on this part of the first round.
    pub shard: Option<Shard>,
    /// Directories of all shards to be completed, or the one folder that they shared.
    pub merge: &'a [PathBuf],
    /// How long files may take to show in that folder.
    pub patience: Duration,
    /// What solves linear programs.
    pub backend: Backend,
    /// The code that runs.
    pub build: Build,
    /// The command line, for the provenance.
    pub command: String,
    /// Progress.
    pub progress: Progress<'a>,
}

/// What a task on a folder that machines share needs to know beside the experiment.
pub struct PartOptions<'a> {
    /// The folder.
    pub parts: &'a Path,
    /// Which round, counted from 0.
    pub round: usize,
    /// The part of it that is wanted; without one its pieces are selected.
    pub shard: Option<Shard>,
    /// How long files may take to show in the folder.
    pub patience: Duration,
    /// Scale the experiment was resolved at.
    pub scale: Scale,
    /// Worker threads; without it one per logical core.
    pub threads: Option<usize>,
    /// What solves linear programs.
    pub backend: Backend,
    /// The code that runs.
    pub build: Build,
    /// Progress.
    pub progress: Progress<'a>,
}

/// What the trials of an experiment left.
pub(crate) struct Recorded {
    pub(crate) files: Vec<RecordedFile>,
    pub(crate) trials: usize,
    pub(crate) failed: usize,
    /// False for a shard, which waits to be merged.
    pub(crate) complete: bool,
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
    /// Whether the records are there: a shard has only its checkpoint.
    pub complete: bool,
}

impl Experiment {
    /// Runs all trials and records them. The run is complete when its directory has a provenance.json.
    pub fn run(&self, options: &RunOptions<'_>) -> Result<Run, EvaluationError> {
        let (threads, pool) = pool(options.threads)?;
        self.check_options(options)?;
        let started = utc(SystemTime::now());
        let clock = Instant::now();
        let name: String = started.chars().filter(char::is_ascii_alphanumeric).collect();
        let tag = match options.shard {
            Some(Shard { index, count }) => format!("{}-shard-{index}-of-{count}", options.scale),
            None => options.scale.to_string(),
        };
        let unfinished =
            if options.resume { RunDirectory::unfinished(options.results, &self.name, &tag) } else { None };
        // First, so that a directory that cannot be written shows before the work and not after it.
        let directory = match unfinished {
            Some(directory) => directory,
            None => RunDirectory::create(options.results, &self.name, &format!("{name}-{tag}"))?,
        };
        let context = RunContext {
            progress: options.progress,
            directory: directory.path(),
            task: match options.shard {
                Some(shard) => Task::Shard(shard),
                None if options.merge.is_empty() => Task::Whole,
                None => Task::Merge { directories: options.merge, patience: options.patience },
            },
            keeps_findings: self.settings.kind().is_resumable,
            backend: options.backend,
            identity: self.identity(&options.build),
            started: clock,
        };
        let result = pool.install(|| self.settings.run(&context));
        let located = |error| self.located(error, options.scale);
        let recorded = result.inspect_err(|_| directory.remove_if_empty()).map_err(located)?;
        if !recorded.complete {
            let Recorded { trials, failed, .. } = recorded;
            return Ok(Run { directory, trials, failed, complete: false });
        }
        let read = inputs(self.scenes());
        let mut inputs = BTreeMap::from([(format!("{}.toml", self.name), sha256(self.source.as_bytes()))]);
        inputs.extend(read.hashes);
        let provenance = Provenance {
            build: options.build.clone(),
            command: options.command.clone(),
            scale: options.scale.to_string(),
            seed: self.settings.seed(),
            threads,
            started,
            seconds: (clock.elapsed().as_secs_f64() * 1e3).round() / 1e3,
            cpu: cpu_model(),
            logical_cores: logical_cores(),
            os: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            inputs,
            warnings: read.warnings,
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
        // Everything in it is in the records.
        directory.remove(shards::FILE);
        Ok(Run { directory, trials: recorded.trials, failed: recorded.failed, complete: true })
    }

    /// The newest complete run of this very experiment at a scale by this very program, under `results`. `since` is when the
    /// program was built: sources with uncommitted changes do not tell one build from another.
    pub fn finished(
        &self,
        results: &Path,
        scale: Scale,
        (build, since): (&Build, SystemTime),
    ) -> Option<RunDirectory> {
        let entries = std::fs::read_dir(results.join(&self.name)).ok()?;
        let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
        paths.sort();
        let resolved = self.resolved.to_string();
        paths.into_iter().rev().find_map(|path| {
            let run = RunDirectory::open(&path).ok()?;
            let provenance = run.provenance().ok()?;
            let started = humantime::parse_rfc3339(&provenance.started).ok()?;
            let same = provenance.build == *build
                && started + Duration::from_secs(1) > since
                && provenance.scale == scale.to_string()
                && run.text("experiment.toml").ok()? == resolved;
            same.then_some(run)
        })
    }

    /// Rounds in which shards work; 0 if the experiment cannot be divided.
    pub fn rounds(&self) -> usize {
        if self.settings.kind().is_divisible { self.settings.rounds() } else { 0 }
    }

    /// One task of many on a folder that machines share: a shard of a round, or without one the selection of what the round is
    /// made of. Repeated, it does nothing where it was done. Returns the number of pieces.
    ///
    /// # Errors
    /// As [`Experiment::run`]; [`EvaluationError::Input`] naming files of the folder that are missing, damaged or of another run.
    pub fn run_part(&self, options: &PartOptions<'_>) -> Result<usize, EvaluationError> {
        let (_, pool) = pool(options.threads)?;
        if self.rounds() == 0 {
            return Err(self.refused("--shard"));
        }
        let &PartOptions { parts, round, patience, .. } = options;
        let context = RunContext {
            progress: options.progress,
            directory: parts,
            task: match options.shard {
                Some(shard) => Task::Part { parts, round, shard, patience },
                None => Task::Select { parts, round, patience },
            },
            keeps_findings: false,
            backend: options.backend,
            identity: self.identity(&options.build),
            started: Instant::now(),
        };
        if let Some(recorded) = shards::already_there(&context)? {
            return Ok(recorded.trials);
        }
        let result = pool.install(|| self.settings.run(&context));
        result.map(|recorded| recorded.trials).map_err(|error| self.located(error, options.scale))
    }

    /// What a search will cost, measured on some of its candidates.
    ///
    /// # Errors
    /// As [`Experiment::run`]; [`EvaluationError::Value`] for experiments of another kind.
    pub fn predict(&self, threads: Option<usize>, backend: Backend) -> Result<Prediction, EvaluationError> {
        let (threads, pool) = pool(threads)?;
        let prediction = pool.install(|| self.settings.predict(threads, backend));
        prediction.unwrap_or_else(|| Err(self.refused("--dry-run")))
    }

    fn check_options(&self, options: &RunOptions<'_>) -> Result<(), EvaluationError> {
        let kind = self.settings.kind();
        let (shard, merge) = (options.shard.is_some(), !options.merge.is_empty());
        if shard && merge {
            let reason = "--shard and --merge exclude each other: shards are merged into the whole";
            return Err(EvaluationError::Value(reason.to_owned()));
        }
        let refused = [
            ("--shard", shard && !kind.is_divisible),
            ("--merge", merge && !kind.is_divisible),
            ("--resume", options.resume && !kind.is_resumable && !(shard && kind.is_divisible)),
        ];
        match refused.iter().find(|(_, refused)| *refused) {
            Some((option, _)) => Err(self.refused(option)),
            None => Ok(()),
        }
    }

    pub(crate) fn refused(&self, option: &str) -> EvaluationError {
        let (name, kind) = (&self.name, self.kind_name());
        EvaluationError::Value(format!("{option} is not for experiments of kind \"{kind}\" such as `{name}`"))
    }

    /// Program, resolved experiment and files of its scenes: what findings of an earlier run must agree with.
    fn identity(&self, build: &Build) -> String {
        let Build { version, commit, dirty, .. } = build;
        let mut text = format!("{version} {commit} {dirty}\n{}", self.resolved);
        for scene in self.scenes().iter().filter(|scene| Path::new(scene).is_file()) {
            text += &std::fs::read(scene).map_or_else(|error| error.to_string(), |bytes| sha256(&bytes));
        }
        sha256(text.as_bytes())
    }
}

/// A pool of so many threads, without a number one per logical core.
pub(crate) fn pool(threads: Option<usize>) -> Result<(usize, rayon::ThreadPool), EvaluationError> {
    let threads = threads.unwrap_or_else(logical_cores);
    if threads == 0 {
        return Err(EvaluationError::Value("0 threads cannot work: at least 1 is needed".to_owned()));
    }
    let fail =
        |error: rayon::ThreadPoolBuildError| EvaluationError::Threads { threads, reason: error.to_string() };
    Ok((threads, ThreadPoolBuilder::new().num_threads(threads).build().map_err(fail)?))
}
