//! `msm run`: an experiment becomes a run directory with records, figures and a page.

use crate::backend::BackendName;
use crate::outcome::{Failure, Output};
use crate::progress::Bar;
use anyhow::anyhow;
use clap::ValueEnum;
use evaluation::{Backend, Build, Experiment, PartOptions, Prediction, Run, RunOptions, Scale, Shard};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Run an experiment and record it.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The experiment: a file, or the name of one of those that msm brings along, such as `filterable`.
    #[arg(value_name = "EXPERIMENT")]
    experiment: PathBuf,
    /// How much of it.
    #[arg(long, value_enum, default_value = "quick")]
    scale: ScaleName,
    /// Where EXPERIMENT/RUN/ is created; an existing run is never overwritten.
    #[arg(long, value_name = "DIR", default_value = "results")]
    out: PathBuf,
    /// Scene to evaluate in place of the experiment's: a procedural name, a .glb, .gltf or .obj file, or a stack of `msm render` (.npz); repeatable.
    #[arg(long = "scene", value_name = "FILE", value_parser = crate::scene_name())]
    scenes: Vec<String>,
    /// Fragments a view in place of the experiment's own number, 0 for all; for single scattering view rays of a camera.
    #[arg(long, value_name = "N")]
    fragments: Option<usize>,
    /// Seed in place of the experiment's own.
    #[arg(long)]
    seed: Option<u64>,
    /// Worker threads; without this one per logical core. The records do not depend on it.
    #[arg(long)]
    threads: Option<usize>,
    /// Go on with the newest unfinished search or shard of this experiment and scale; without one, begin.
    #[arg(long)]
    resume: bool,
    /// Only part i of N, to be merged later: of a search's candidates, of the views or families of other kinds.
    #[arg(long, value_name = "i/N", conflicts_with = "merge")]
    shard: Option<Shard>,
    /// Round of the shard, counted from 0: in a search round k judges what is left of the race on block k. Its findings become a
    /// file in the folder --parts; where that file is, nothing is done.
    #[arg(long, value_name = "k", requires = "shard", conflicts_with = "resume")]
    round: Option<usize>,
    /// Write down what round k is made of, once all shards of the rounds before it are in the folder --parts.
    #[arg(long, value_name = "k", conflicts_with_all = ["shard", "merge", "resume"])]
    select: Option<usize>,
    /// Folder that all shards share; without this EXPERIMENT/parts-SCALE/ below --out.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["merge", "resume"])]
    parts: Option<PathBuf>,
    /// Run directory of a shard, give all of them; or the one folder of --parts. Completes the run.
    #[arg(long, value_name = "DIR")]
    merge: Vec<PathBuf>,
    /// How long files may take to show in a folder that machines share.
    #[arg(long, value_name = "SECONDS", default_value_t = 0)]
    wait: u64,
    /// Judge every candidate of a search on every fragment, without a race.
    #[arg(long)]
    exhaustive: bool,
    /// What solves the linear programs of --exhaustive.
    #[arg(long, value_enum, default_value = "cpu", requires = "exhaustive")]
    backend: BackendName,
    /// Say what a search will cost, and stop.
    #[arg(long, conflicts_with_all = ["resume", "shard", "merge", "select"])]
    dry_run: bool,
    #[command(flatten)]
    output: Output,
}

/// How much of an experiment.
#[derive(Clone, Copy, ValueEnum)]
pub enum ScaleName {
    Smoke,
    Brief,
    Quick,
    Paper,
}

impl From<ScaleName> for Scale {
    fn from(name: ScaleName) -> Self {
        match name {
            ScaleName::Smoke => Self::Smoke,
            ScaleName::Brief => Self::Brief,
            ScaleName::Quick => Self::Quick,
            ScaleName::Paper => Self::Paper,
        }
    }
}

#[derive(Serialize)]
struct Answer {
    experiment: String,
    scale: Scale,
    trials: usize,
    failed: usize,
    complete: bool,
    directory: String,
    files: Vec<String>,
}

/// Runs, records, draws.
pub(crate) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let scale = Scale::from(arguments.scale);
    let experiment = crate::experiments::read(&arguments.experiment, scale, arguments.seed)?
        .with_scenes(&arguments.scenes)
        .and_then(|experiment| if arguments.exhaustive { experiment.exhaustive() } else { Ok(experiment) })?;
    let experiment = match arguments.fragments {
        Some(fragments) => experiment.with_fragments(fragments)?,
        None => experiment,
    };
    let backend = Backend::from(arguments.backend);
    if arguments.dry_run {
        let prediction = experiment.predict(crate::threads::capped(arguments.threads), backend)?;
        return arguments.output.emit(&prediction, |out| describe(out, &prediction));
    }
    if arguments.select.is_some() || arguments.round.is_some() || arguments.parts.is_some() {
        return share(arguments, &experiment, scale);
    }
    let patience = Duration::from_secs(arguments.wait);
    let Arguments { resume, shard, merge, .. } = arguments;
    let part = Part { resume: *resume, shard: *shard, merge, patience, backend };
    crate::interrupt::advise(if experiment.can_resume() {
        "the same command with --resume goes on where it stopped".to_owned()
    } else {
        format!("nothing of `{}` is kept; the same command begins again", experiment.name)
    });
    let run = recorded(&experiment, scale, &arguments.out, arguments.threads, part)?;
    let written =
        if run.complete { ::report::page(&run.directory).and_then(|page| page.write())? } else { Vec::new() };
    let answer = Answer {
        experiment: experiment.name,
        scale,
        trials: run.trials,
        failed: run.failed,
        complete: run.complete,
        directory: run.directory.path().display().to_string(),
        files: written.into_iter().map(|file| file.name).collect(),
    };
    arguments.output.emit(&answer, |out| {
        writeln!(
            out,
            "{} trials, {} failed, recorded in {}",
            answer.trials, answer.failed, answer.directory
        )?;
        if !answer.complete {
            writeln!(out, "when all shards are there: msm run ... --merge DIR for each of them")?;
        }
        answer.files.iter().try_for_each(|file| writeln!(out, "  {file}"))
    })
}

#[derive(Serialize)]
struct Shared {
    experiment: String,
    scale: Scale,
    round: usize,
    /// None where a round was selected.
    shard: Option<String>,
    pieces: usize,
    parts: String,
}

/// One task of many on a folder that machines share.
fn share(arguments: &Arguments, experiment: &Experiment, scale: Scale) -> Result<(), Failure> {
    if arguments.shard.is_none() && arguments.select.is_none() {
        return Err(Failure::Input(anyhow!("--parts goes with --shard i/N or with --select k")));
    }
    let own = || arguments.out.join(&experiment.name).join(format!("parts-{scale}"));
    let parts = arguments.parts.clone().unwrap_or_else(own);
    let round = arguments.select.or(arguments.round).unwrap_or(0);
    let bar = Bar::new("pieces");
    let progress = |done: usize, total: usize| bar.set(done, total);
    let pieces = experiment.run_part(&PartOptions {
        parts: &parts,
        round,
        shard: arguments.shard,
        patience: Duration::from_secs(arguments.wait),
        scale,
        threads: arguments.threads,
        backend: arguments.backend.into(),
        build: build(),
        progress: &progress,
    })?;
    bar.finish();
    let answer = Shared {
        experiment: experiment.name.clone(),
        scale,
        round,
        shard: arguments.shard.map(|shard| shard.to_string()),
        pieces,
        parts: parts.display().to_string(),
    };
    arguments.output.emit(&answer, |out| match &answer.shard {
        Some(shard) => writeln!(out, "round {round}, shard {shard}: {pieces} pieces in {}", answer.parts),
        None => writeln!(out, "round {round} has {pieces} pieces, written down in {}", answer.parts),
    })
}

/// What of an experiment is run.
#[derive(Default)]
pub(crate) struct Part<'a> {
    pub resume: bool,
    pub shard: Option<Shard>,
    pub merge: &'a [PathBuf],
    pub patience: Duration,
    pub backend: Backend,
}

/// Runs an experiment with a progress bar.
pub(crate) fn recorded(
    experiment: &Experiment,
    scale: Scale,
    results: &Path,
    threads: Option<usize>,
    Part { resume, shard, merge, patience, backend }: Part<'_>,
) -> Result<Run, Failure> {
    let bar = Bar::new("trials");
    let progress = |done: usize, total: usize| bar.set(done, total);
    let (build, command) = (build(), command_line());
    let options = RunOptions {
        results,
        scale,
        threads: crate::threads::capped(threads),
        resume,
        shard,
        merge,
        patience,
        backend,
        build,
        command,
        progress: &progress,
    };
    let run = experiment.run(&options)?;
    bar.finish();
    Ok(run)
}

fn describe(out: &mut dyn std::io::Write, prediction: &Prediction) -> std::io::Result<()> {
    let p = prediction;
    writeln!(out, "candidates          {}", p.candidates)?;
    writeln!(out, "linear programs     {:.3e} on the first block", p.programs as f64)?;
    if p.later_programs > 0 {
        let later = p.later_programs as f64;
        writeln!(out, "                    {later:.3e} on later blocks, if 1 in 50 stays in the race")?;
    }
    writeln!(out, "rate                {:.3e} a second on one thread, measured now", p.programs_per_second)?;
    writeln!(out, "time                {} on {} threads", lasting(p.hours), p.threads)?;
    if let Some(card) = &p.card {
        writeln!(out, "graphics processor  {}", card.adapter)?;
        writeln!(out, "rate there          {:.3e} a second, measured now", card.programs_per_second)?;
        writeln!(out, "left to the CPU     {:.4} %", 100.0 * card.exact)?;
        writeln!(out, "time there          {}", lasting(card.hours))?;
    }
    writeln!(out, "disk                {}", size(p.disk_bytes))
}

/// Hours in a unit that fits.
fn lasting(hours: f64) -> String {
    let seconds = 3600.0 * hours;
    match seconds {
        s if s < 1.0 => "less than a second".to_owned(),
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        _ => format!("{hours:.1} h"),
    }
}

/// Bytes in a unit that fits.
fn size(bytes: u64) -> String {
    match bytes as f64 {
        b if b < 1e4 => format!("{b} bytes"),
        b if b < 1e6 => format!("{:.0} kB", b / 1e3),
        b if b < 1e9 => format!("{:.1} MB", b / 1e6),
        b => format!("{:.1} GB", b / 1e9),
    }
}

/// What this binary is built from.
pub(crate) fn build() -> Build {
    Build {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        commit: env!("MSM_COMMIT").to_owned(),
        dirty: env!("MSM_DIRTY").to_owned(),
        rustc: env!("MSM_RUSTC").to_owned(),
    }
}

/// The command as it would be typed, without the path of the binary.
fn command_line() -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+".contains(c);
    let words = std::env::args_os().skip(1).map(|word| {
        let word = word.to_string_lossy().into_owned();
        if !word.is_empty() && word.chars().all(plain) {
            word
        } else {
            format!("'{}'", word.replace('\'', r"'\''"))
        }
    });
    ["msm".to_owned()].into_iter().chain(words).collect::<Vec<_>>().join(" ")
}
