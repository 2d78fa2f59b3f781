//! `msm cluster`: an experiment becomes a folder of scripts for a batch system, and what came of them is told.

mod forecast;
mod plan;
mod scripts;
mod status;

use crate::outcome::{Failure, Output};
use crate::run::ScaleName;
use anyhow::{Context, anyhow};
use clap::{Subcommand, ValueEnum};
use evaluation::Scale;
use plan::Plan;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Most shards: file names have four digits, and folders of more files are slow everywhere.
const MOST_SHARDS: usize = 9999;

/// Spread an experiment over many machines: a folder of readable scripts, a job array for each round.
///
/// `msm cluster status DIR` tells what is done, running and missing, and how to submit again what is missing.
#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    verb: Option<ClusterVerb>,
    /// The experiment.
    #[arg(value_name = "EXPERIMENT.toml", required = true)]
    experiment: Option<PathBuf>,
    /// How much of it.
    #[arg(long, value_enum, default_value = "quick")]
    scale: ScaleName,
    /// Parts of each round.
    #[arg(long, value_name = "N", required = true)]
    shards: Option<usize>,
    /// What runs them: a Slurm cluster, or GNU parallel on machines that ssh reaches.
    #[arg(long, value_enum, default_value = "slurm")]
    engine: Engine,
    /// The folder; it must be new, or empty, and seen by all machines under this path.
    #[arg(long, value_name = "DIR", required_unless_present = "dry_run")]
    out: Option<PathBuf>,
    /// Submit at once.
    #[arg(long, conflicts_with = "dry_run")]
    submit: bool,
    /// Say what it will cost, measured now, and what usual limits are exceeded; write nothing.
    #[arg(long)]
    dry_run: bool,
    /// Worker threads of a task.
    #[arg(long, value_name = "T", default_value_t = 1)]
    threads: usize,
    /// Partition of the cluster.
    #[arg(long, value_name = "NAME")]
    partition: Option<String>,
    /// Time limit of a task, as Slurm writes it: minutes, HH:MM:SS or D-HH:MM:SS.
    #[arg(long, value_name = "TIME")]
    time: Option<String>,
    /// Memory of a task, as Slurm writes it: 4G.
    #[arg(long, value_name = "SIZE")]
    mem: Option<String>,
    /// Shell commands that every task begins with, such as those that load modules.
    #[arg(long, value_name = "FILE")]
    setup: Option<PathBuf>,
    /// Scene in place of the experiment's, as for `msm run`; repeatable.
    #[arg(long = "scene", value_name = "FILE", value_parser = crate::scene_name())]
    scenes: Vec<String>,
    /// Seed in place of the experiment's own.
    #[arg(long)]
    seed: Option<u64>,
    /// Judge every candidate of a search on every fragment, without a race.
    #[arg(long)]
    exhaustive: bool,
    #[command(flatten)]
    output: Output,
}

#[derive(Subcommand)]
enum ClusterVerb {
    /// What is done, running and missing, how long it will take, and how to submit again what is missing.
    Status(status::Arguments),
}

/// What runs the tasks.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Engine {
    /// Job arrays of a Slurm cluster.
    Slurm,
    /// GNU parallel, on this machine or over ssh.
    Parallel,
}

#[derive(Serialize)]
struct Answer {
    experiment: String,
    scale: Scale,
    engine: Engine,
    rounds: usize,
    shards: usize,
    directory: String,
    files: Vec<String>,
    submitted: Option<String>,
}

/// A value that becomes part of a line of a script, and must not become a line of its own.
fn checked(option: &str, value: Option<&String>) -> Result<(), Failure> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.:,+/".contains(c);
    match value.filter(|value| value.is_empty() || !value.chars().all(is_plain)) {
        Some(value) => {
            Err(Failure::Input(anyhow!("{option} {value:?} is no such value: letters, digits and -_.:,+/")))
        }
        None => Ok(()),
    }
}

/// Minutes, MM:SS, HH:MM:SS, D-HH, D-HH:MM or D-HH:MM:SS.
fn is_time(text: &str) -> bool {
    let is_number = |part: &str| !part.is_empty() && part.chars().all(|c| c.is_ascii_digit());
    let (days, rest) = text.split_once('-').map_or((None, text), |(days, rest)| (Some(days), rest));
    days.is_none_or(is_number) && rest.split(':').count() <= 3 && rest.split(':').all(is_number)
}

/// A whole number with K, M, G or T, or of megabytes.
fn is_memory(text: &str) -> bool {
    let digits = text.strip_suffix(['K', 'M', 'G', 'T', 'k', 'm', 'g', 't']).unwrap_or(text);
    !digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit())
}

/// Writes the folder, or tells what it would cost, or what came of it.
pub(crate) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(ClusterVerb::Status(arguments)) = &arguments.verb {
        return status::execute(arguments);
    }
    let path = arguments.experiment.as_deref().unwrap_or(Path::new(""));
    let scale = Scale::from(arguments.scale);
    let experiment = crate::experiments::read(path, scale, arguments.seed)?
        .with_scenes(&arguments.scenes)
        .and_then(|experiment| if arguments.exhaustive { experiment.exhaustive() } else { Ok(experiment) })?;
    let shards = arguments.shards.unwrap_or(1);
    if !(1..=MOST_SHARDS).contains(&shards) {
        return Err(Failure::Input(anyhow!("--shards {shards} is not between 1 and {MOST_SHARDS}")));
    }
    if arguments.threads == 0 {
        return Err(Failure::Input(anyhow!("--threads 0: a task needs at least 1")));
    }
    for (option, value) in
        [("--partition", &arguments.partition), ("--time", &arguments.time), ("--mem", &arguments.mem)]
    {
        checked(option, value.as_ref())?;
        if let (Engine::Parallel, Some(_)) = (arguments.engine, value) {
            return Err(Failure::Input(anyhow!("{option} is for Slurm: GNU parallel has no such limit")));
        }
    }
    arguments.scenes.iter().try_for_each(|scene| evaluation::check_scene(scene))?;
    if experiment.rounds() == 0 {
        let (name, kind) = (&experiment.name, experiment.kind_name());
        let reason = format!(
            "experiment `{name}` is of kind \"{kind}\", which is not divided: `msm run` takes one machine"
        );
        return Err(Failure::Input(anyhow!(reason)));
    }
    if arguments.dry_run {
        return forecast::execute(arguments, &experiment, shards);
    }
    // A forecast warns of them.
    let forms =
        [("--time", &arguments.time, is_time as fn(&str) -> bool), ("--mem", &arguments.mem, is_memory)];
    for (option, value, is_it) in forms {
        if let Some(value) = value.as_ref().filter(|value| !is_it(value)) {
            return Err(Failure::Input(anyhow!(
                "{option} {value:?} is nothing that Slurm knows; see `msm cluster --help`"
            )));
        }
    }
    let out = arguments.out.as_deref().unwrap_or(Path::new(""));
    let plan = Plan::new(arguments, &experiment, (scale, shards))?;
    let written = scripts::write(arguments, &plan, (path, out))?;
    let submitted = if arguments.submit { Some(submitted(out)?) } else { None };
    let answer = Answer {
        experiment: plan.experiment.clone(),
        scale,
        engine: plan.engine,
        rounds: plan.rounds,
        shards,
        directory: out.display().to_string(),
        files: written,
        submitted,
    };
    arguments.output.emit(&answer, |out| {
        let Answer { experiment, rounds, shards, directory, .. } = &answer;
        writeln!(out, "{experiment}, {scale}: {rounds} rounds of {shards} shards in {directory}")?;
        answer.files.iter().try_for_each(|file| writeln!(out, "  {file}"))?;
        match &answer.submitted {
            Some(text) => writeln!(out, "{text}"),
            None => writeln!(out, "to begin: sh {directory}/submit.sh"),
        }
    })
}

/// Runs submit.sh and returns what it says.
fn submitted(folder: &Path) -> Result<String, Failure> {
    let script = folder.join("submit.sh");
    let output = Command::new("sh").arg(&script).output().context("sh")?;
    if !output.status.success() {
        let reason = String::from_utf8_lossy(&output.stderr).into_owned();
        return Err(Failure::Failed(anyhow!("{}: {reason}", script.display())));
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
