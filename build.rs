//! Stamps the binary with the commit it was built from, so that a recorded number knows its origin.

use std::process::Command;

fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

/// The list of all experiments with their texts, for the binary to bring along.
fn embed_experiments() {
    println!("cargo::rerun-if-changed=experiments");
    let root = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    let folder = std::path::Path::new(&root).join("experiments");
    let entries = std::fs::read_dir(&folder).into_iter().flatten().flatten();
    let mut files: Vec<_> = entries.map(|entry| entry.path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    files.sort();
    let lines = files.iter().filter_map(|path| {
        let (name, path) = (path.file_stem()?.to_str()?, path.to_str()?);
        Some(format!("({name:?}, include_str!({path:?})),\n"))
    });
    let list = format!("&[\n{}]", lines.collect::<String>());
    let out = std::env::var("OUT_DIR").unwrap_or_default();
    let written = std::fs::write(std::path::Path::new(&out).join("experiments.rs"), list);
    written.unwrap_or_else(|error| panic!("the list of experiments cannot be written to {out}: {error}"));
}

/// The best rows of the newest recorded run of `speed-accuracy`, all scenes together: what shaders that are taken home say
/// about themselves. Nothing where the runs are left out.
fn records() {
    const RUNS: &str = "results/speed-accuracy";
    println!("cargo::rerun-if-changed={RUNS}");
    let runs = std::fs::read_dir(RUNS).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
    let newest = runs.filter(|path| path.join("records.csv").is_file()).max();
    let text = newest.as_ref().and_then(|run| std::fs::read_to_string(run.join("records.csv")).ok());
    let text = text.unwrap_or_default();
    let kept =
        |line: &&str| line.starts_with("scene,") || (line.starts_with("all,all,") && line.contains(",true,"));
    let rows: String = text.lines().filter(kept).map(|line| format!("{line}\n")).collect();
    let folder = std::env::var_os("OUT_DIR").map(std::path::PathBuf::from).unwrap_or_default();
    if let Err(error) = std::fs::write(folder.join("speed_accuracy.csv"), rows) {
        println!("cargo::error=writing the recorded errors: {error}");
    }
    let name = newest.as_deref().and_then(std::path::Path::file_name).unwrap_or_default();
    println!("cargo::rustc-env=MSM_SPEED_ACCURACY_RUN={}", name.to_string_lossy());
}

fn main() {
    const SOURCES: [&str; 4] = ["crates", "build.rs", "Cargo.toml", "Cargo.lock"];
    for path in SOURCES {
        println!("cargo::rerun-if-changed={path}");
    }
    // The log of HEAD changes with every commit; outside a git checkout there is none.
    if let Some(log) = output("git", &["rev-parse", "--git-path", "logs/HEAD"]) {
        println!("cargo::rerun-if-changed={log}");
    }
    let commit = output("git", &["rev-parse", "HEAD"]).unwrap_or_else(|| "unknown".to_owned());
    let mut status = vec!["status", "--porcelain", "--"];
    status.extend(SOURCES);
    let dirty = match output("git", &status) {
        Some(changes) if changes.is_empty() => "false",
        Some(_) => "true",
        None => "unknown",
    };
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let version = output(&rustc, &["--version"]).unwrap_or_else(|| "unknown".to_owned());
    embed_experiments();
    records();
    println!("cargo::rustc-env=MSM_COMMIT={commit}");
    println!("cargo::rustc-env=MSM_DIRTY={dirty}");
    println!("cargo::rustc-env=MSM_RUSTC={version}");
}
