//! `msm reproduce`: all experiments, one report; interrupted anywhere it ends with the same records.

// A panic is how a test or benchmark reports.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

fn command(out: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_msm"));
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command.args(["reproduce", "--scale", "smoke", "--format", "json", "--out", out.to_str().unwrap()]);
    command
}

fn reproduce(out: &Path) -> Value {
    let output = command(out).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// records.csv of each experiment's reported run.
fn records(answer: &Value) -> BTreeMap<String, Vec<u8>> {
    let all = answer["experiments"].as_array().unwrap().iter();
    all.map(|of| {
        let directory = PathBuf::from(of["directory"].as_str().unwrap());
        (of["experiment"].as_str().unwrap().to_owned(), std::fs::read(directory.join("records.csv")).unwrap())
    })
    .collect()
}

#[test]
fn all_experiments_are_run_once_and_reported_in_one_page() {
    let out = tempfile::tempdir().unwrap();
    let answer = reproduce(out.path());
    let files = std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments")).unwrap();
    assert_eq!(answer["experiments"].as_array().unwrap().len(), files.count());
    for of in answer["experiments"].as_array().unwrap() {
        assert_eq!((of["was_there"].as_bool(), of["failed"].as_u64()), (Some(false), Some(0)), "{of}");
        assert!(of["answer"].as_str().unwrap().len() > 20, "{of}");
    }
    let page = std::fs::read_to_string(answer["report"].as_str().unwrap()).unwrap();
    // Nothing is fetched: no picture, script or style comes from elsewhere.
    for outside in ["src=\"http", "src=\"//", "href=\"http", "@import", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
    for of in answer["experiments"].as_array().unwrap() {
        let name = of["experiment"].as_str().unwrap();
        assert!(page.contains(&format!("<section id=\"{name}\">")), "{name}");
    }
    assert!(
        page.matches(" role=\"img\" aria-label").count() > 15 && page.contains("data:image/webp;base64,")
    );
    for application in ["hard shadows", "soft shadows", "single scattering", "smoke and glass"] {
        assert!(
            page.contains(&format!("{{&quot;application&quot;:&quot;{application}&quot;")),
            "{application}"
        );
    }
    // A second call has nothing to do.
    let again = reproduce(out.path());
    assert!(again["experiments"].as_array().unwrap().iter().all(|of| of["was_there"] == true), "{again}");
    assert_eq!(records(&answer), records(&again));
}

#[test]
fn killed_at_any_moment_it_ends_with_the_same_records() {
    let whole = tempfile::tempdir().unwrap();
    let expected = records(&reproduce(whole.path()));
    let out = tempfile::tempdir().unwrap();
    let mut kills = 0;
    for milliseconds in [50, 300, 700, 1200, 2000] {
        let mut child = command(out.path()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let begin = Instant::now();
        while begin.elapsed() < Duration::from_millis(milliseconds) {
            if child.try_wait().unwrap().is_some() {
                break;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        if child.try_wait().unwrap().is_none() {
            kills += 1;
            child.kill().unwrap();
        }
        child.wait().unwrap();
    }
    assert!(kills > 0, "it was always faster than the test");
    assert_eq!(records(&reproduce(out.path())), expected);
}

#[test]
fn mistakes_are_told_on_one_line() {
    let out = tempfile::tempdir().unwrap();
    let empty = tempfile::tempdir().unwrap();
    for (arguments, named) in [
        (vec!["--experiments", "nowhere"], "nowhere"),
        (vec!["--experiments", empty.path().to_str().unwrap()], "holds no experiment"),
        (vec!["--scene", "missing.glb"], "missing.glb"),
        (vec!["--threads", "0"], "0 threads"),
    ] {
        let output = command(out.path()).args(&arguments).output().unwrap();
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(named) && message.trim().lines().count() == 1, "{arguments:?}: {message}");
    }
    let output =
        Command::new(env!("CARGO_BIN_EXE_msm")).args(["reproduce", "--scale", "huge"]).output().unwrap();
    assert!(output.status.code() == Some(2) && String::from_utf8_lossy(&output.stderr).contains("huge"));
    // Where nothing can be written it fails at once.
    let output = command(Path::new("/proc/nothing")).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("/proc/nothing"), "{message}");
}
