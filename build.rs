//! Stamps the binary with the commit it was built from, so that a recorded number knows its origin.

use std::process::Command;

fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
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
    println!("cargo::rustc-env=MSM_COMMIT={commit}");
    println!("cargo::rustc-env=MSM_DIRTY={dirty}");
    println!("cargo::rustc-env=MSM_RUSTC={version}");
}
