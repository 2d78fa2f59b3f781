//! `msm cluster status`: what the files of a folder tell, and what is to be submitted again.

use super::Engine;
use super::plan::Plan;
use crate::outcome::{Failure, Output};
use evaluation::{RoundState, ranges, round_state};
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A folder that `msm cluster` has written.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// The folder.
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    #[command(flatten)]
    output: Output,
}

#[derive(Serialize)]
struct Answer {
    experiment: String,
    engine: Engine,
    shards: usize,
    rounds: Vec<Round>,
    /// The recorded run, once all is done.
    run: Option<String>,
    /// The line that submits what is missing, and everything after it.
    resubmit: Option<String>,
}

#[derive(Serialize)]
struct Round {
    round: usize,
    /// Pieces, once they are selected.
    pieces: Option<usize>,
    done: usize,
    running: usize,
    /// Waiting in the queue, where the batch system tells.
    queued: Option<usize>,
    /// Neither done nor running.
    missing: Vec<usize>,
    /// Mean and longest of the shards that are done.
    mean_seconds: Option<f64>,
    longest_seconds: Option<f64>,
    /// Core hours that are left, as far as the shards that are done tell.
    core_hours_left: Option<f64>,
    /// Hours until its end with as many tasks at once as now.
    hours_left: Option<f64>,
    /// Files that are not to be believed.
    faults: Vec<String>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let plan = Plan::read(&arguments.directory)?;
    let parts = arguments.directory.join("parts");
    let rounds: Vec<Round> = (0..plan.rounds)
        .map(|round| {
            let state = round_state(&parts, round, plan.shards);
            let queued = if plan.engine == Engine::Slurm { queued(&plan, round) } else { None };
            told(&plan, round, &state, queued)
        })
        .collect();
    let run = finished(&arguments.directory);
    let resubmit = if run.is_some() { None } else { Some(again(&arguments.directory, &plan, &rounds)) };
    let answer = Answer {
        experiment: plan.experiment.clone(),
        engine: plan.engine,
        shards: plan.shards,
        rounds,
        run: run.map(|path| path.display().to_string()),
        resubmit,
    };
    arguments.output.emit(&answer, |out| describe(out, &plan, &answer))
}

fn told(plan: &Plan, round: usize, state: &RoundState, queued: Option<usize>) -> Round {
    let is_open = |index: &usize| !state.done.contains_key(index) && !state.running.contains(index);
    let seconds: Vec<f64> = state.done.values().map(|&(_, seconds, _)| seconds).collect();
    let cores = state.done.values().map(|&(_, seconds, threads)| seconds * threads as f64).sum::<f64>();
    let count = seconds.len().max(1) as f64;
    let mean = (!seconds.is_empty()).then(|| seconds.iter().sum::<f64>() / count);
    let left = (plan.shards - state.done.len().min(plan.shards)) as f64;
    let at_once = state.running.len().max(1) as f64;
    Round {
        round,
        pieces: state.selected,
        done: state.done.len(),
        running: state.running.len(),
        queued,
        missing: (1..=plan.shards).filter(is_open).collect(),
        mean_seconds: mean,
        longest_seconds: seconds.into_iter().reduce(f64::max),
        core_hours_left: mean.map(|_| left * cores / count / 3600.0),
        hours_left: mean.map(|mean| (left / at_once).ceil() * mean / 3600.0),
        faults: state.faults.iter().map(|(path, reason)| format!("{}: {reason}", path.display())).collect(),
    }
}

/// Tasks of a round that wait in the queue of Slurm.
fn queued(plan: &Plan, round: usize) -> Option<usize> {
    let name = format!("--name={}-round-{round}", plan.job);
    let arguments = ["--noheader", "--array", "--states=PENDING", "--format=%i", &name];
    let output = Command::new("squeue").args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).lines().count())
}

/// The run that the shards were merged into.
fn finished(folder: &Path) -> Option<PathBuf> {
    let inside = |path: &Path| -> Vec<PathBuf> {
        let entries = std::fs::read_dir(path).into_iter().flatten();
        entries.filter_map(|entry| Some(entry.ok()?.path())).collect()
    };
    let runs = inside(&folder.join("results")).into_iter().flat_map(|experiment| inside(&experiment));
    runs.filter(|run| run.join("provenance.json").is_file()).max()
}

/// The line that submits the first unfinished round and all that follow.
fn again(folder: &Path, plan: &Plan, rounds: &[Round]) -> String {
    let script = format!("sh '{}/submit.sh'", folder.display().to_string().replace('\'', r"'\''"));
    let Some(open) = rounds.iter().find(|round| round.done < plan.shards) else {
        return format!("{script} {}", plan.rounds);
    };
    // A round that nobody has selected begins with that.
    if open.pieces.is_none() {
        return if open.round == 0 { script } else { format!("{script} {}", open.round) };
    }
    let mut wanted = open.missing.clone();
    if wanted.is_empty() {
        // What still runs must be waited for.
        return format!("{script} {}", open.round);
    }
    wanted.sort_unstable();
    let list = match plan.engine {
        Engine::Slurm => ranges(&wanted),
        Engine::Parallel => {
            let words: Vec<String> = wanted.iter().map(usize::to_string).collect();
            format!("'{}'", words.join(" "))
        }
    };
    format!("{script} {} {list}", open.round)
}

/// Seconds, minutes or hours.
pub(super) fn span(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.1} s"),
        s if s < 7200.0 => format!("{:.1} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

fn describe(out: &mut dyn Write, plan: &Plan, answer: &Answer) -> std::io::Result<()> {
    writeln!(out, "{}, {}: {} rounds of {} shards", plan.experiment, plan.scale, plan.rounds, plan.shards)?;
    writeln!(out, "round  pieces   done  running  queued  missing  a shard    longest    left")?;
    for round in &answer.rounds {
        let number = |value: Option<usize>| value.map_or("-".to_owned(), |value| value.to_string());
        let time = |value: Option<f64>| value.map_or("-".to_owned(), span);
        let left = match (round.hours_left, round.core_hours_left) {
            _ if round.done >= plan.shards => "nothing".to_owned(),
            (Some(hours), Some(core_hours)) => {
                format!("{} with as many at once as now, {core_hours:.2} core hours", span(3600.0 * hours))
            }
            _ => "unknown before a shard is done".to_owned(),
        };
        writeln!(
            out,
            "{:<6} {:<8} {:<5} {:<8} {:<7} {:<8} {:<10} {:<10} {left}",
            round.round,
            number(round.pieces),
            round.done,
            round.running,
            number(round.queued),
            round.missing.len(),
            time(round.mean_seconds),
            time(round.longest_seconds),
        )?;
    }
    for fault in answer.rounds.iter().flat_map(|round| &round.faults) {
        writeln!(out, "not believed: {fault}")?;
    }
    if let Some(run) = &answer.run {
        writeln!(out, "recorded in {run}")?;
    }
    if let Some(line) = &answer.resubmit {
        writeln!(out, "what is missing, and all after it, once nothing of it waits any more:\n  {line}")?;
    }
    Ok(())
}
