//! What an experiment will cost on a cluster, and which of its usual limits it exceeds.

use super::Arguments;
use super::status::span;
use crate::outcome::Failure;
use evaluation::{Backend, Experiment, Forecast};
use serde::Serialize;

/// MaxArraySize of Slurm is 1001 where nobody has changed it: indices end at 1000.
const LARGEST_ARRAY: usize = 1000;

/// Metadata servers of shared file systems suffer from more files in one project.
const MANY_FILES: usize = 20_000;

/// Below this most of a task is its start.
const SHORT_TASK: f64 = 30.0;

/// Where no limit is given: usual partitions end after a day.
const USUAL_LIMIT: f64 = 24.0 * 3600.0;

#[derive(Serialize)]
struct Answer {
    experiment: String,
    shards: usize,
    threads: usize,
    forecast: Forecast,
    /// By round: indices of its array.
    arrays: Vec<String>,
    files: usize,
    warnings: Vec<String>,
}

/// Seconds of a time limit in Slurm's spelling: MM, MM:SS, HH:MM:SS, D-HH, D-HH:MM, D-HH:MM:SS.
fn seconds(time: &str) -> Option<f64> {
    let (days, rest) = time.split_once('-').map_or((None, time), |(days, rest)| (Some(days), rest));
    let numbers: Vec<f64> = rest.split(':').map(str::parse).collect::<Result<_, _>>().ok()?;
    Some(match (days, numbers.as_slice()) {
        (None, [minutes]) => 60.0 * minutes,
        (None, [minutes, seconds]) => 60.0 * minutes + seconds,
        (None, [hours, minutes, seconds]) => 3600.0 * hours + 60.0 * minutes + seconds,
        (Some(days), [hours, rest @ ..]) if rest.len() <= 2 => {
            let below = rest.first().unwrap_or(&0.0) * 60.0 + rest.get(1).unwrap_or(&0.0);
            days.parse::<f64>().ok()? * 86_400.0 + hours * 3600.0 + below
        }
        _ => return None,
    })
}

/// Bytes of a size in Slurm's spelling; megabytes without a unit.
fn bytes(size: &str) -> Option<f64> {
    let digits = size.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = match &size[digits.len()..] {
        "K" | "KB" => 10,
        "" | "M" | "MB" => 20,
        "G" | "GB" => 30,
        "T" | "TB" => 40,
        _ => return None,
    };
    Some(digits.parse::<f64>().ok()? * 2f64.powi(unit))
}

fn warnings(arguments: &Arguments, forecast: &Forecast, shards: usize, files: usize) -> Vec<String> {
    let mut warnings = Vec::new();
    if shards > LARGEST_ARRAY {
        warnings.push(format!(
            "an array of {shards} tasks needs MaxArraySize above {shards}, usual is {}: ask for it (`scontrol show config`) or \
             take --shards {LARGEST_ARRAY}",
            LARGEST_ARRAY + 1
        ));
    }
    let task = 3600.0 * forecast.task_hours;
    match arguments.time.as_deref().map(|time| (time, seconds(time))) {
        Some((time, None)) => warnings.push(format!("--time {time} is no time that Slurm knows")),
        Some((time, Some(limit))) if limit < 1.3 * task => warnings.push(format!(
            "--time {time} leaves no third above the {} of a task: more --shards or more time",
            span(task)
        )),
        None if task > USUAL_LIMIT => {
            warnings.push(format!("a task takes {}, longer than usual limits: more --shards", span(task)));
        }
        Some(_) | None => {}
    }
    match arguments.mem.as_deref().map(|size| (size, bytes(size))) {
        Some((size, None)) => warnings.push(format!("--mem {size} is no size that Slurm knows")),
        Some((size, Some(limit))) if limit < forecast.memory_bytes as f64 => {
            warnings
                .push(format!("--mem {size} is less than the {} of a task", size_of(forecast.memory_bytes)));
        }
        Some(_) | None => {}
    }
    if files > MANY_FILES {
        warnings.push(format!("{files} files are many for a shared file system: fewer --shards"));
    }
    if task < SHORT_TASK {
        warnings.push(format!("a task takes {}, most of which is its start: fewer --shards do", span(task)));
    }
    if shards as u64 > forecast.pieces {
        warnings.push(format!("{shards} shards of {} pieces: some have nothing to do", forecast.pieces));
    }
    warnings
}

fn size_of(bytes: u64) -> String {
    let mebibytes = bytes as f64 / f64::from(1 << 20);
    if mebibytes < 1024.0 { format!("{mebibytes:.0} MiB") } else { format!("{:.1} GiB", mebibytes / 1024.0) }
}

pub(super) fn execute(arguments: &Arguments, experiment: &Experiment, shards: usize) -> Result<(), Failure> {
    let forecast = experiment.forecast(shards, arguments.threads, Backend::Cpu)?;
    // A part and a log each, and what was selected.
    let files = forecast.rounds * (2 * shards + 3);
    let warnings = warnings(arguments, &forecast, shards, files);
    let arrays = vec![format!("1-{shards}"); forecast.rounds];
    let (name, threads) = (experiment.name.clone(), arguments.threads);
    let answer = Answer { experiment: name, shards, threads, forecast, arrays, files, warnings };
    arguments.output.emit(&answer, |out| {
        let Answer { forecast: f, .. } = &answer;
        writeln!(out, "measured    {}", f.measured)?;
        writeln!(out, "work        {:.2} core hours", f.core_hours)?;
        writeln!(
            out,
            "arrays      {} of 1-{shards}, one after the other, {} pieces in the first",
            f.rounds, f.pieces
        )?;
        writeln!(
            out,
            "a task      {} in the first round, on {threads} threads",
            span(3600.0 * f.task_hours)
        )?;
        writeln!(out, "memory      {} for a task", size_of(f.memory_bytes))?;
        writeln!(out, "disk        {} in {files} files, logs included", size_of(f.disk_bytes))?;
        answer.warnings.iter().try_for_each(|warning| writeln!(out, "warning     {warning}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_sizes_are_read_as_slurm_reads_them() {
        let known =
            [("90", 5400.0), ("1:30", 90.0), ("2:00:00", 7200.0), ("1-0", 86_400.0), ("1-2:3:4", 93_784.0)];
        for (text, expected) in known {
            assert_eq!(seconds(text), Some(expected), "{text}");
        }
        assert_eq!((seconds("soon"), seconds("1:2:3:4")), (None, None));
        assert_eq!(
            (bytes("4G"), bytes("512"), bytes("4Q")),
            (Some(4.0 * 2f64.powi(30)), Some(512.0 * 2f64.powi(20)), None)
        );
    }
}
