//! An installed program works in any folder: experiments by name, manuals, bounds by the million.

// A panic is how a test or benchmark reports.
#![allow(clippy::unwrap_used)]

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

fn msm(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_msm")).args(arguments).current_dir(folder).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs and expects one line on standard error with some words.
fn refused(folder: &Path, arguments: &[&str], code: i32, words: &str) {
    let output = msm(folder, arguments);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    assert!(message.contains(words) && message.lines().count() == 1, "{arguments:?}: {message}");
}

#[test]
fn experiments_are_run_by_name_in_an_empty_folder() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let run = ["run", "lp-agreement", "--scale", "smoke", "--format", "json"];
    let output = msm(folder, &run);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let directory = answer["directory"].as_str().unwrap();
    assert!(directory.starts_with("results/lp-agreement/"), "{directory}");
    assert!(folder.join(directory).join("README.md").is_file());
    // The path that worked in a checkout means the same.
    let output = msm(folder, &["run", "experiments/lp-agreement.toml", "--scale", "smoke"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    refused(folder, &["run", "filtrable"], 2, "filterable");
    refused(folder, &["run", "missing/filterable.toml"], 2, "missing/filterable.toml");
    // Files come first.
    std::fs::create_dir(folder.join("experiments")).unwrap();
    std::fs::write(folder.join("experiments/lp-agreement.toml"), "kind = \"bounds\"\ncolour = 1\n").unwrap();
    refused(folder, &run, 2, "experiments/lp-agreement.toml");
}

#[test]
fn scenes_are_checked_before_the_first_run() {
    let folder = tempfile::tempdir().unwrap();
    refused(folder.path(), &["reproduce", "--scale", "smoke", "--scene", "gone.glb"], 2, "gone.glb");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn shells_and_man_are_served() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = msm(folder.path(), &["completions", shell]);
        assert!(output.status.success() && text(&output.stdout).contains("advise"), "{shell}");
    }
    let page = msm(folder.path(), &["man"]);
    assert!(text(&page.stdout).contains(".TH msm 1"), "{}", text(&page.stdout));
    let pages = msm(folder.path(), &["man", "--out", "man1"]);
    assert!(pages.status.success(), "{}", text(&pages.stderr));
    for name in ["msm.1", "msm-advise.1", "msm-run.1"] {
        assert!(folder.path().join("man1").join(name).is_file(), "{name}");
    }
}

/// `.npy` of version 1.0 with rows of doubles.
fn npy(rows: &[[f64; 3]]) -> Vec<u8> {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, 3), }}", rows.len());
    let padded = format!("{header:<width$}\n", width = 117);
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((padded.len() as u16).to_le_bytes());
    bytes.extend(padded.as_bytes());
    bytes.extend(rows.iter().flatten().flat_map(|value| value.to_le_bytes()));
    bytes
}

#[test]
fn bounds_by_the_million_are_those_of_single_ones() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // Moments of a half at 0.2 and a half at 0.6, and some that no distribution has.
    let rows = [[0.4, 0.2, 0.5], [0.4, 0.2, 0.7], [0.4, 0.1, 0.5]];
    std::fs::write(folder.join("in.npy"), npy(&rows)).unwrap();
    let basis = ["bound", "--basis", "power:2", "--interval", "real"];
    let output =
        msm(folder, &[&basis[..], &["--batch", "in.npy", "--out", "out.npz", "--format", "json"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((answer["rows"].as_u64(), answer["failed"].as_u64()), (Some(3), Some(1)), "{answer}");
    assert_eq!(answer["first_failure"][0], 2, "{answer}");
    assert!(std::fs::read(folder.join("out.npz")).unwrap().starts_with(b"PK"));
    // The same as CSV through standard input and output.
    let mut child = Command::new(env!("CARGO_BIN_EXE_msm"))
        .args([&basis[..], &["--batch", "-"]].concat())
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = rows.map(|row| row.map(|value| value.to_string()).join(",")).join("\n");
    child.stdin.take().unwrap().write_all(lines.as_bytes()).unwrap();
    let table = text(&child.wait_with_output().unwrap().stdout);
    let found: Vec<&str> = table.lines().collect();
    assert_eq!(found[0], "lower,upper,lower_proved,upper_proved,ok");
    assert!(found[3].ends_with(",0") && found.len() == 4, "{table}");
    for (line, row) in found[1..3].iter().zip(rows) {
        let moments = format!("{},{}", row[0], row[1]);
        let depth = row[2].to_string();
        let single = msm(
            folder,
            &[&basis[..], &["--moments", &moments, "--depth", &depth, "--format", "json"]].concat(),
        );
        let single: Value = serde_json::from_slice(&single.stdout).unwrap();
        let lower: f64 = line.split(',').next().unwrap().parse().unwrap();
        assert_eq!(Some(lower), single["lower"].as_f64(), "{line} {single}");
    }
    refused(folder, &[&basis[..], &["--batch", "none.csv"]].concat(), 2, "none.csv");
    std::fs::write(folder.join("bad.csv"), "0.4,0.2,0.5\n0.4,0.2\n").unwrap();
    refused(folder, &[&basis[..], &["--batch", "bad.csv"]].concat(), 2, "line 2");
    refused(folder, &basis, 2, "--depth");
}

#[test]
fn what_cannot_be_drawn_or_rendered_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let bound = ["bound", "--basis", "power:2", "--atoms", "0.2:1", "--depth", "0.5", "--plot", "a.png"];
    refused(folder, &bound, 2, ".svg");
    assert!(!folder.join("a.png").exists());
    // No driver is found where none is looked for.
    let output = Command::new(env!("CARGO_BIN_EXE_msm"))
        .args(["render", "stairs", "--size", "32", "--backend", "gpu"])
        .env("WGPU_BACKEND", "empty")
        .env("VK_DRIVER_FILES", "/dev/null")
        .env("VK_ICD_FILENAMES", "/dev/null")
        .current_dir(folder)
        .output()
        .unwrap();
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("no graphics adapter"), "{message}");
    assert!(!folder.join("out").exists());
}

#[test]
fn unknown_keys_name_their_line_and_the_nearest_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/filterable.toml");
    let whole = std::fs::read_to_string(path).unwrap();
    let line = 1 + whole.lines().position(|line| line.starts_with("scenes")).unwrap();
    std::fs::write(folder.path().join("a.toml"), whole.replacen("\nscenes", "\nscense", 1)).unwrap();
    let output = msm(folder.path(), &["run", "a.toml"]);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains(&format!("line {line}")) && message.contains("`scenes` is near"), "{message}");
}

#[test]
fn too_many_threads_are_capped_with_a_note() {
    let folder = tempfile::tempdir().unwrap();
    let output = msm(folder.path(), &["run", "lp-agreement", "--scale", "smoke", "--threads", "100000"]);
    let message = text(&output.stderr);
    assert!(output.status.success() && message.contains("100000 threads"), "{message}");
}
