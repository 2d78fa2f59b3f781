//! Every kind that can be divided, in rounds of shards on a folder that machines share: the bytes of one machine, whatever happens
//! to the files in between.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

use evaluation::{Experiment, Scale};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("shards").join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn experiments() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments")).unwrap();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "toml"));
    paths.sort();
    paths
}

fn command(experiment: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_msm"));
    command.arg("run").arg(experiment).args(["--scale", "smoke", "--format", "json"]).args(more);
    command
}

fn answer(output: &Output) -> serde_json::Value {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn directory(output: &Output) -> PathBuf {
    PathBuf::from(answer(output)["directory"].as_str().unwrap())
}

/// One line on standard error, with this exit code, and what it must say.
fn refused(output: &Output, code: i32, needles: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), message.lines().count()), (Some(code), 1), "{message}");
    assert!(needles.iter().all(|needle| message.contains(needle)), "{needles:?}: {message}");
}

/// Files of a run without those that hold times.
fn records(run: &Path) -> Vec<(String, Vec<u8>)> {
    let names = std::fs::read_dir(run).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<String> = names.map(|name| name.into_string().unwrap()).collect();
    let timed =
        ["samples.csv", "frames.csv", "passes.csv", "provenance.json", "README.md", "time.svg", "gpu.svg"];
    names.retain(|name| !timed.contains(&name.as_str()));
    names.sort();
    names.into_iter().map(|name| (name.clone(), std::fs::read(run.join(&name)).unwrap())).collect()
}

fn same(experiment: &Path, one: &Path, other: &Path) {
    let (one, other) = (records(one), records(other));
    let names = |files: &[(String, Vec<u8>)]| files.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&one), names(&other), "{}", experiment.display());
    for ((name, one), (_, other)) in one.iter().zip(&other) {
        assert!(one == other, "{}: {name}", experiment.display());
    }
}

#[test]
fn every_kind_that_is_divided_merges_to_the_bytes_of_one_machine() {
    let mut kinds = Vec::new();
    for experiment in experiments() {
        let read = Experiment::read(&experiment, Scale::Smoke, None).unwrap();
        if read.rounds() == 0 {
            refused(&command(&experiment, &["--shard", "1/2"]).output().unwrap(), 2, &["--shard"]);
            continue;
        }
        kinds.push(read.kind_name());
        let out = folder(&read.name);
        let text = out.to_str().unwrap();
        let whole = directory(&command(&experiment, &["--out", text]).output().unwrap());
        let parts = out.join("parts");
        let parts = parts.to_str().unwrap();
        for round in 0..read.rounds() {
            let round = round.to_string();
            let selected =
                answer(&command(&experiment, &["--parts", parts, "--select", &round]).output().unwrap());
            let mut pieces = 0;
            // In any order, with any number of threads.
            for (shard, threads) in [("3/3", "1"), ("1/3", "3"), ("2/3", "2")] {
                let arguments = ["--parts", parts, "--round", &round, "--shard", shard, "--threads", threads];
                let told = answer(&command(&experiment, &arguments).output().unwrap());
                pieces += told["pieces"].as_u64().unwrap();
            }
            assert_eq!(selected["pieces"].as_u64(), Some(pieces), "{}", experiment.display());
        }
        let merged = directory(&command(&experiment, &["--out", text, "--merge", parts]).output().unwrap());
        same(&experiment, &whole, &merged);
    }
    kinds.sort_unstable();
    kinds.dedup();
    for kind in ["search", "stability", "filterable", "quantization", "soft-shadows", "temporal-shadows"] {
        assert!(kinds.contains(&kind), "{kind} is not among {kinds:?}");
    }
}

/// Without a selection a shard finds out itself what its round is made of, and the folder has a name of its own.
#[test]
fn shards_need_nothing_but_the_rounds_before_theirs() {
    let out = folder("alone");
    let search = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/candidate-search.toml");
    let text = out.to_str().unwrap();
    let attempt = |more: &[&str]| command(&search, &[&["--out", text], more].concat()).output().unwrap();
    let whole = directory(&attempt(&[]));
    refused(&attempt(&["--shard", "1/2", "--round", "1"]), 2, &["round-0", "no shard of round 0"]);
    for round in ["0", "1", "2"] {
        answer(&attempt(&["--shard", "1/2", "--round", round]));
        refused(
            &attempt(&["--select", &(round.parse::<u32>().unwrap() + 1).to_string()]),
            2,
            if round == "2" { &["round 3 is none of 3"] } else { &["1 of 2 shards are missing: 2"] },
        );
        answer(&attempt(&["--shard", "2/2", "--round", round]));
    }
    let parts = out.join("candidate-search/parts-smoke");
    same(&search, &whole, &directory(&attempt(&["--merge", parts.to_str().unwrap()])));
    refused(
        &attempt(&["--seed", "8", "--merge", parts.to_str().unwrap()]),
        2,
        &["another search or run", "round-0"],
    );
    refused(&attempt(&["--seed", "8", "--shard", "1/2", "--round", "0"]), 2, &["shard-0001-of-0002.part"]);
    refused(&attempt(&["--round", "0"]), 2, &["--shard"]);
    refused(&attempt(&["--parts", text]), 2, &["--parts goes with"]);
}

#[test]
#[cfg(unix)]
fn kills_full_disks_and_late_files_lose_nothing() {
    let out = folder("trouble");
    let search = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/candidate-search.toml");
    let text = out.to_str().unwrap();
    let whole = directory(&command(&search, &["--out", text]).output().unwrap());
    let parts = out.join("parts");
    let parts = parts.to_str().unwrap();
    let task = |more: &[&str]| command(&search, &[&["--parts", parts, "--threads", "1"], more].concat());
    answer(&task(&["--select", "0"]).output().unwrap());
    // Killed at any time, begun again, and twice at the same time.
    let mut kills = 0;
    for attempt in 0..40 {
        let mut child = task(&["--round", "0", "--shard", "1/2"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(5 + 7 * attempt));
        if child.try_wait().unwrap().is_some() {
            break;
        }
        child.kill().unwrap();
        child.wait().unwrap();
        kills += 1;
    }
    assert!(kills >= 2, "{kills}");
    let first = Path::new(parts).join("round-0/shard-0001-of-0002.part");
    let _ = std::fs::remove_file(&first);
    let twice =
        [0, 1].map(|_| task(&["--round", "0", "--shard", "1/2"]).stdout(Stdio::piped()).spawn().unwrap());
    for child in twice {
        assert!(child.wait_with_output().unwrap().status.success());
    }
    // A full disk: no file may grow beyond 4 KiB, and the signal for that is ignored.
    let before = std::fs::read(&first).unwrap();
    let script = format!(
        "trap '' XFSZ; ulimit -f 4; exec '{}' run '{}' --scale smoke --parts '{parts}' --round 0 --shard 2/2",
        env!("CARGO_BIN_EXE_msm"),
        search.display()
    );
    let output = Command::new("bash").args(["-c", &script]).output().unwrap();
    refused(&output, 1, &["cannot write", "shard-0002-of-0002.part"]);
    assert_eq!(std::fs::read(&first).unwrap(), before);
    // The folder shows the second shard late.
    let late = task(&["--select", "1", "--wait", "60"]).stdout(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(700));
    answer(&task(&["--round", "0", "--shard", "2/2"]).output().unwrap());
    assert!(late.wait_with_output().unwrap().status.success());
    for round in ["1", "2"] {
        answer(&task(&["--select", round]).output().unwrap());
        for shard in ["1/2", "2/2"] {
            answer(&task(&["--round", round, "--shard", shard]).output().unwrap());
        }
    }
    let merged = directory(&command(&search, &["--out", text, "--merge", parts]).output().unwrap());
    same(&search, &whole, &merged);
    // What was made once for all shards is damaged, and nobody works with that.
    let supply = Path::new(parts).join("search-block-1.supply");
    let mut bytes = std::fs::read(&supply).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&supply, bytes).unwrap();
    std::fs::remove_file(Path::new(parts).join("round-1/shard-0001-of-0002.part")).unwrap();
    let output = task(&["--round", "1", "--shard", "1/2"]).output().unwrap();
    refused(&output, 2, &["search-block-1.supply", "damaged"]);
}
