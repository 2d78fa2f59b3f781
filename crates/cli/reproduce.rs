//! `msm reproduce`: every experiment, one after another, and one page about all of them.

use crate::outcome::{Failure, Output};
use crate::run::{Part, ScaleName, build, recorded};
use ::report::Page;
use evaluation::{Experiment, Scale, write_whole};
use serde::Serialize;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime};

/// Run all experiments and write a report. A command that was interrupted goes on where it stopped.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// How much of each: smoke takes seconds, brief minutes on two cores, quick about half an hour, paper hours and more.
    #[arg(long, value_enum, default_value = "brief")]
    scale: ScaleName,
    /// Scene in place of the procedural ones: a procedural name, a .glb, .gltf or .obj file, or a stack; repeatable.
    #[arg(long = "scene", value_name = "FILE", value_parser = crate::scene_name())]
    scenes: Vec<String>,
    /// Where the experiments are; without this `experiments` if it is there, else those that msm brings along.
    #[arg(long, value_name = "DIR")]
    experiments: Option<PathBuf>,
    /// Where EXPERIMENT/RUN/ and the report are written; without this target/reproduced in a checkout, else results.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Worker threads; without this one per logical core. The records do not depend on it.
    #[arg(long)]
    threads: Option<usize>,
    #[command(flatten)]
    output: Output,
}

#[derive(Serialize)]
struct Answer {
    scale: Scale,
    seconds: f64,
    report: String,
    experiments: Vec<Reproduced>,
}

#[derive(Serialize)]
struct Reproduced {
    experiment: String,
    directory: String,
    /// Whether an earlier call had finished it.
    was_there: bool,
    trials: Option<usize>,
    failed: Option<usize>,
    seconds: f64,
    answer: String,
}

/// Seconds of each experiment at scale brief, measured once on two cores, for what is left to wait; others count as a minute.
const SECONDS: [(&str, f64); 15] = [
    ("bounds", 3.0),
    ("depth-bias", 7.0),
    ("lp-agreement", 5.0),
    ("filterable", 20.0),
    ("speed-accuracy", 83.0),
    ("quantization", 97.0),
    ("stability", 43.0),
    ("candidate-search", 14.0),
    ("ranking-map", 44.0),
    ("larger-bases", 20.0),
    ("soft-shadows", 36.0),
    ("single-scattering", 24.0),
    ("temporal-shadows", 50.0),
    ("stochastic-shadows", 41.0),
    ("translucent-shadows", 15.0),
];

fn expected(name: &str) -> f64 {
    SECONDS.iter().find(|(known, _)| *known == name).map_or(60.0, |(_, seconds)| *seconds)
}

/// Runs what has not been run, then reports.
pub(crate) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let scale = Scale::from(arguments.scale);
    let begin = Instant::now();
    let out = match &arguments.out {
        Some(out) => out.clone(),
        None if Path::new("experiments").is_dir() => PathBuf::from("target/reproduced"),
        None => PathBuf::from("results"),
    };
    // Before the first run, which may take an hour.
    arguments.scenes.iter().try_for_each(|scene| evaluation::check_scene(scene))?;
    let experiments = experiments(arguments, scale)?;
    crate::interrupt::advise("the same command goes on where it stopped".to_owned());
    let built = built();
    let whole: f64 = experiments.iter().map(|(experiment, _)| expected(&experiment.name)).sum();
    let mut before = 0.0;
    // What the machine takes for a second of the table, once there is something to go by.
    let mut pace = 1.0;
    let mut worked = (0.0, 0.0);
    let mut done: Vec<(Reproduced, Page)> = Vec::new();
    for (number, (experiment, has_scenes)) in experiments.iter().enumerate() {
        let place = format!("[{}/{}] {}", number + 1, experiments.len(), experiment.name);
        let start = Instant::now();
        let found = experiment.finished(&out, scale, (&build(), built));
        let was_there = found.is_some();
        let (directory, trials, failed) = match found {
            Some(directory) => {
                say(&format!("{place}: finished before"));
                (directory, None, None)
            }
            None => {
                let left = pace * (whole - before);
                say(&format!("{place}: running, about {} left for all", duration(left)));
                // A search keeps what it has found; the others begin anew.
                let part = Part { resume: experiment.can_resume(), ..Part::default() };
                let run = recorded(experiment, scale, &out, arguments.threads, part)?;
                (run.directory, Some(run.trials), Some(run.failed))
            }
        };
        before += expected(&experiment.name);
        let seconds = start.elapsed().as_secs_f64();
        if !was_there {
            worked = (worked.0 + seconds, worked.1 + expected(&experiment.name));
            pace = worked.0 / worked.1;
        }
        let page = ::report::page(&directory)?;
        page.write()?;
        let answer = page.finding();
        let reproduced = Reproduced {
            experiment: experiment.name.clone(),
            directory: directory.path().display().to_string(),
            was_there,
            trials,
            failed,
            seconds,
            answer: if *has_scenes || arguments.scenes.is_empty() {
                answer
            } else {
                format!("(needs no scene) {answer}")
            },
        };
        done.push((reproduced, page));
    }
    let report = out.join("README.md");
    let (reproduced, pages): (Vec<Reproduced>, Vec<Page>) = done.into_iter().unzip();
    write_whole(&report, index(scale, &out, &reproduced).as_bytes())?;
    let html = out.join("report.html");
    let page = ::report::html(&pages)?;
    write_whole(&html, page.as_bytes())?;
    let answer = Answer {
        scale,
        seconds: begin.elapsed().as_secs_f64(),
        report: html.display().to_string(),
        experiments: reproduced,
    };
    arguments.output.emit(&answer, |out| {
        for of in &answer.experiments {
            writeln!(out, "{}: {}", of.experiment, of.answer)?;
        }
        writeln!(out, "\nreport: {} ({} at scale {scale})", answer.report, duration(answer.seconds))
    })
}

/// All experiments of the folder, with the scenes that were asked for, the shortest first.
fn experiments(arguments: &Arguments, scale: Scale) -> Result<Vec<(Experiment, bool)>, Failure> {
    let mut experiments = Vec::new();
    for experiment in crate::experiments::all(arguments.experiments.as_deref(), scale)? {
        let has_scenes = experiment.has_scenes();
        let experiment = if has_scenes { experiment.with_scenes(&arguments.scenes)? } else { experiment };
        experiments.push((experiment, has_scenes));
    }
    experiments.sort_by(|(a, _), (b, _)| {
        expected(&a.name).total_cmp(&expected(&b.name)).then_with(|| a.name.cmp(&b.name))
    });
    Ok(experiments)
}

/// When this program was built; where that is unknown, nothing counts as run by it.
fn built() -> SystemTime {
    let modified = std::env::current_exe().and_then(std::fs::metadata).and_then(|data| data.modified());
    modified.unwrap_or_else(|_| SystemTime::now())
}

/// On a terminal only, as all progress.
fn say(line: &str) {
    if std::io::stderr().is_terminal() {
        // A closed standard error is no reason to stop.
        let _ = writeln!(std::io::stderr().lock(), "{line}");
    }
}

fn duration(seconds: f64) -> String {
    if seconds < 90.0 { format!("{seconds:.0} s") } else { format!("{:.0} min", seconds / 60.0) }
}

fn index(scale: Scale, root: &Path, reproduced: &[Reproduced]) -> String {
    let mut text = format!(
        "<!-- Written by `msm reproduce`. -->\n# All experiments at scale {scale}\n\n| experiment | answer | seconds |\n|---|---|--:|\n"
    );
    for of in reproduced {
        let directory = Path::new(&of.directory);
        let link = directory.strip_prefix(root).unwrap_or(directory).display();
        let seconds = if of.was_there { "-".to_owned() } else { format!("{:.0}", of.seconds) };
        text += &format!(
            "| [{}]({link}/README.md) | {} | {seconds} |\n",
            of.experiment,
            of.answer.replace('|', "\\|")
        );
    }
    text
}
