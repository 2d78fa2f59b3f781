//! The candidate search survives being killed, divided and fed with nonsense.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

/// Files whose bytes depend on the experiment alone.
const RECORDS: [&str; 6] =
    ["experiment.toml", "records.csv", "stages.csv", "marks.csv", "views.csv", "agreement.csv"];

fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("search").join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn command(experiment: &Path, out: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_msm"));
    command
        .arg("run")
        .arg(experiment)
        .args(["--scale", "smoke", "--format", "json", "--out"])
        .arg(out)
        .args(more);
    command
}

fn experiment() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/candidate-search.toml")
}

fn directory(output: &Output) -> PathBuf {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    PathBuf::from(answer["directory"].as_str().unwrap())
}

fn run(out: &Path, more: &[&str]) -> PathBuf {
    directory(&command(&experiment(), out, more).output().unwrap())
}

fn records(run: &Path) -> Vec<Vec<u8>> {
    RECORDS.iter().map(|name| std::fs::read(run.join(name)).unwrap()).collect()
}

/// One line on standard error, with this exit code, and what it must say.
fn refused(output: &Output, code: i32, needles: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), message.lines().count()), (Some(code), 1), "{message}");
    assert!(needles.iter().all(|needle| message.contains(needle)), "{needles:?}: {message}");
}

#[test]
fn killed_twenty_times_and_resumed_gives_the_same_bytes() {
    let out = folder("kill");
    let undisturbed = records(&run(&out.join("whole"), &["--threads", "2"]));
    let resumed = out.join("killed");
    let mut kills = 0;
    let mut with_checkpoint = 0;
    let mut left = 0;
    // Delays that a golden-ratio sequence spreads over what a run takes; a run that is done too early is begun again.
    for attempt in 0..200 {
        let delay = Duration::from_millis(15 + (300.0 * (f64::from(attempt) * 0.618_034).fract()) as u64);
        let mut child = command(&experiment(), &resumed, &["--resume", "--threads", "1"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(delay);
        if child.try_wait().unwrap().is_some() {
            let output = child.wait_with_output().unwrap();
            assert_eq!(records(&directory(&output)), undisturbed);
            if kills >= 20 && with_checkpoint >= 5 {
                break;
            }
            left += 1;
            continue;
        }
        child.kill().unwrap();
        child.wait().unwrap();
        kills += 1;
        let runs = std::fs::read_dir(resumed.join("candidate-search")).map_or(0, |entries| {
            entries.filter(|entry| entry.as_ref().unwrap().path().join("checkpoint.log").exists()).count()
        });
        with_checkpoint += runs;
        if kills >= 20 && with_checkpoint >= 5 && left > 0 {
            break;
        }
    }
    assert!(kills >= 20 && with_checkpoint >= 5, "{kills} kills, {with_checkpoint} after the first write");
    assert_eq!(records(&run(&resumed, &["--resume"])), undisturbed);
}

#[test]
fn shards_merge_to_the_bytes_of_the_whole() {
    let out = folder("shards");
    let whole = records(&run(&out.join("whole"), &[]));
    let shards: Vec<PathBuf> = (1..=3).map(|i| run(&out, &["--shard", &format!("{i}/3")])).collect();
    let text: Vec<&str> = shards.iter().map(|shard| shard.to_str().unwrap()).collect();
    let before: Vec<Vec<u8>> =
        shards.iter().map(|shard| std::fs::read(shard.join("checkpoint.log")).unwrap()).collect();
    // In any order, with any number of threads.
    let merge = ["--merge", text[2], "--merge", text[0], "--merge", text[1], "--threads", "1"];
    assert_eq!(records(&run(&out.join("merged"), &merge)), whole);
    let attempt = |more: &[&str]| command(&experiment(), &out.join("refused"), more).output().unwrap();
    refused(&attempt(&["--merge", text[0], "--merge", text[1]]), 2, &["shard 3/3 is missing"]);
    refused(&attempt(&["--merge", text[0], "--merge", text[0]]), 2, &["once more"]);
    let seed = ["--seed", "9", "--merge", text[0], "--merge", text[1], "--merge", text[2]];
    refused(&attempt(&seed), 2, &["checkpoint.log", "another search"]);
    refused(&attempt(&["--merge", out.to_str().unwrap()]), 2, &["checkpoint.log"]);
    // An unfinished shard.
    let log = shards[1].join("checkpoint.log");
    std::fs::write(&log, &before[1][..before[1].len() / 2]).unwrap();
    let merge = ["--merge", text[0], "--merge", text[1], "--merge", text[2]];
    refused(&attempt(&merge), 2, &["candidates are in none"]);
    std::fs::write(&log, &before[1]).unwrap();
    let after: Vec<Vec<u8>> =
        shards.iter().map(|shard| std::fs::read(shard.join("checkpoint.log")).unwrap()).collect();
    assert_eq!(before, after);
}

/// Every kind that works view by view is divided and merged by the same room.
#[test]
fn views_in_shards_merge_to_the_bytes_of_the_whole() {
    let out = folder("views");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/filterable.toml");
    let text = std::fs::read_to_string(file).unwrap();
    assert!(text.contains("\nviews = [\"oblique\"]"));
    let experiment = out.join("filterable.toml");
    std::fs::write(&experiment, text.replace("\nviews = [\"oblique\"]", "\nviews = []")).unwrap();
    let attempt = |more: &[&str]| command(&experiment, &out, more).output().unwrap();
    let run = |more: &[&str]| directory(&attempt(more));
    let records = |run: &Path| {
        let timed = ["samples.csv", "provenance.json", "README.md", "time.svg"];
        let names = std::fs::read_dir(run).unwrap().map(|entry| entry.unwrap().file_name());
        let mut names: Vec<String> = names.map(|name| name.into_string().unwrap()).collect();
        names.retain(|name| !timed.contains(&name.as_str()));
        names.sort();
        names.into_iter().map(|name| (std::fs::read(run.join(&name)).unwrap(), name)).collect::<Vec<_>>()
    };
    let whole = records(&run(&[]));
    assert!(whole.iter().any(|(_, name)| name == "kernels.csv") && whole.len() > 6);
    let shards: Vec<PathBuf> = (1..=2).map(|i| run(&["--shard", &format!("{i}/2")])).collect();
    let text: Vec<&str> = shards.iter().map(|shard| shard.to_str().unwrap()).collect();
    assert!(shards.iter().all(|shard| shard.join("checkpoint.log").is_file()));
    let merged = run(&["--merge", text[1], "--merge", text[0], "--threads", "1"]);
    assert!(records(&merged) == whole, "{}", merged.display());
    refused(&attempt(&["--merge", text[0]]), 2, &["shard 2/2 is missing"]);
    refused(
        &attempt(&["--seed", "9", "--merge", text[0], "--merge", text[1]]),
        2,
        &["checkpoint.log", "inputs"],
    );
    // A killed shard goes on behind its last whole line.
    let log = shards[0].join("checkpoint.log");
    let before = std::fs::read(&log).unwrap();
    std::fs::write(&log, &before[..before.len() - 9]).unwrap();
    refused(&attempt(&["--merge", text[0], "--merge", text[1]]), 2, &["views are in none"]);
}

#[test]
fn a_damaged_or_foreign_checkpoint_is_refused_and_left_alone() {
    let out = folder("damage");
    let shard = run(&out, &["--shard", "1/2"]);
    let log = shard.join("checkpoint.log");
    let whole = std::fs::read(&log).unwrap();
    let resume = |more: &[&str]| command(&experiment(), &out, more).output().unwrap();
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 1;
    std::fs::write(&log, &damaged).unwrap();
    refused(&resume(&["--shard", "1/2", "--resume"]), 2, &["checkpoint.log", "damaged"]);
    assert_eq!(std::fs::read(&log).unwrap(), damaged);
    std::fs::write(&log, &whole).unwrap();
    refused(&resume(&["--shard", "1/2", "--resume", "--seed", "4"]), 2, &["another search"]);
    assert_eq!(std::fs::read(&log).unwrap(), whole);
    // A torn last line costs that line only.
    std::fs::write(&log, &whole[..whole.len() - 5]).unwrap();
    assert_eq!(directory(&resume(&["--shard", "1/2", "--resume"])), shard);
    let mut lines: Vec<&[u8]> = whole.split(|&byte| byte == b'\n').collect();
    let again = std::fs::read(&log).unwrap();
    let mut repaired: Vec<&[u8]> = again.split(|&byte| byte == b'\n').collect();
    lines.sort_unstable();
    repaired.sort_unstable();
    assert_eq!(lines, repaired);
}

#[test]
#[cfg(unix)]
fn a_full_disk_loses_nothing() {
    let out = folder("full");
    let whole = records(&run(&out.join("whole"), &[]));
    let place = out.join("limited");
    // No file may grow beyond 8 KiB, and the signal for that is ignored: writes fail as on a full disk.
    let script = format!(
        "trap '' XFSZ; ulimit -f 8; exec '{}' run '{}' --scale smoke --out '{}'",
        env!("CARGO_BIN_EXE_msm"),
        experiment().display(),
        place.display()
    );
    let output = Command::new("bash").args(["-c", &script]).output().unwrap();
    refused(&output, 1, &["cannot write", "checkpoint.log"]);
    assert_eq!(records(&run(&place, &["--resume"])), whole);
}

#[test]
fn mistakes_are_named_before_anything_is_rendered() {
    let out = folder("mistakes");
    let text = std::fs::read_to_string(experiment()).unwrap();
    let cases = [
        ("\"exp(-2z)\"]", "\"expp(-2z)\"]", "expp"),
        ("\"exp(-2z)\"]", "\"exp(-2z)\", \"z^2\"]", "z^2"),
        ("orders = [2, 3, 4]", "orders = [2, 11]", "11"),
        ("orders = [2, 3, 4]", "orders = [0]", "m = 0"),
        ("orders = [2, 3, 4]", "orders = [3, 3]", "twice"),
        ("cells = 256", "cells = 3", "cells = 3"),
        ("tolerance = 1e-6", "tolerance = 0.5", "tolerance = 0.5"),
        ("best = 5\n", "best = 0\n", "best = 0"),
        ("method = { bound = \"vsm\" }", "method = { bound = \"vsmm\" }", "vsmm"),
        ("views = [\"oblique\", \"high\"]", "views = [\"noon\"]", "noon"),
        ("seed = 1", "sed = 1", "sed"),
    ];
    for (i, (old, new, needle)) in cases.into_iter().enumerate() {
        assert!(text.contains(old), "{old}");
        let path = out.join(format!("case-{i}.toml"));
        std::fs::write(&path, text.replacen(old, new, 1)).unwrap();
        refused(&command(&path, &out.join("results"), &[]).output().unwrap(), 2, &[needle]);
    }
    let attempt = |more: &[&str]| command(&experiment(), &out.join("results"), more).output().unwrap();
    for shard in ["0/4", "5/4", "x"] {
        let output = attempt(&["--shard", shard]);
        assert_eq!(output.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&output.stderr).contains(shard));
    }
    let bounds = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/bounds.toml");
    for option in [&["--resume"][..], &["--shard", "1/2"], &["--merge", "x"], &["--dry-run"]] {
        refused(&command(&bounds, &out.join("results"), option).output().unwrap(), 2, &[option[0], "bounds"]);
    }
    // Nothing was left behind.
    let left = std::fs::read_dir(out.join("results"))
        .map_or(0, |kinds| kinds.map(|kind| std::fs::read_dir(kind.unwrap().path()).unwrap().count()).sum());
    assert_eq!(left, 0);
}

#[test]
fn functions_that_say_nothing_new_are_left_out_with_their_names() {
    let out = folder("dependent");
    let text = std::fs::read_to_string(experiment()).unwrap();
    let start = text.find("family = [").unwrap();
    let end = start + text[start..].find(']').unwrap() + 1;
    let family = "family = [\"z\", \"1-2z\", \"z^2\", \"(z+1)^2\", \"sin(2pi z)\"]";
    let path = out.join("dependent.toml");
    std::fs::write(&path, [&text[..start], family, &text[end..]].concat()).unwrap();
    let run = directory(&command(&path, &out, &[]).output().unwrap());
    let mut reader = csv::Reader::from_path(run.join("records.csv")).unwrap();
    let rows: Vec<evaluation::SearchRecord> = reader.deserialize().map(Result::unwrap).collect();
    let find =
        |basis: &str| rows.iter().find(|row| row.basis.replace(' ', "") == basis.replace(' ', "")).unwrap();
    let reduced = find("z, 1-2z");
    assert_eq!((reduced.reduced.replace(' ', ""), reduced.error.as_str()), ("1-2z".to_owned(), ""));
    // Both span the same functions.
    assert!((find("z, z^2").l1_error - find("z, (z+1)^2").l1_error).abs() < 1e-6);
    assert!(find("z, z^2, (z+1)^2").reduced.contains("z+1"));
}

#[test]
fn without_a_race_every_candidate_is_judged_on_all_fragments() {
    let out = folder("exhaustive");
    let whole = run(&out.join("one"), &["--exhaustive", "--threads", "1"]);
    assert_eq!(records(&run(&out.join("two"), &["--exhaustive", "--threads", "2"])), records(&whole));
    let stages = std::fs::read_to_string(whole.join("stages.csv")).unwrap();
    // One block for each of three orders, nothing uncertified.
    assert_eq!(stages.lines().count(), 4, "{stages}");
    assert!(stages.lines().skip(1).all(|line| line.ends_with(",0")), "{stages}");
    // Without a race all orders see the fragments that only the best see otherwise.
    let seen = |text: &str| -> Vec<u64> {
        text.lines().skip(1).map(|line| line.split(',').nth(2).unwrap().parse().unwrap()).collect()
    };
    let race = std::fs::read_to_string(run(&out.join("race"), &[]).join("stages.csv")).unwrap();
    let blocks = seen(&race).len() / 3;
    let all: u64 = seen(&race)[..blocks].iter().sum();
    assert!(blocks > 1 && seen(&stages).iter().all(|&fragments| fragments == all), "{stages} {race}");
    // In parts, killed and resumed.
    let shards: Vec<PathBuf> =
        (1..=2).map(|i| run(&out, &["--exhaustive", "--shard", &format!("{i}/2")])).collect();
    let log = shards[1].join("checkpoint.log");
    let written = std::fs::read(&log).unwrap();
    std::fs::write(&log, &written[..written.len() / 2]).unwrap();
    run(&out, &["--exhaustive", "--shard", "2/2", "--resume"]);
    let text: Vec<&str> = shards.iter().map(|shard| shard.to_str().unwrap()).collect();
    let merged = run(&out.join("merged"), &["--exhaustive", "--merge", text[0], "--merge", text[1]]);
    assert_eq!(records(&merged), records(&whole));
    // What a race has found is none of its business.
    let attempt = |more: &[&str]| command(&experiment(), &out.join("refused"), more).output().unwrap();
    refused(&attempt(&["--merge", text[0], "--merge", text[1]]), 2, &["another search"]);
    let backend = command(&experiment(), &out, &["--backend", "gpu"]).output().unwrap();
    assert_eq!(backend.status.code(), Some(2));
}
