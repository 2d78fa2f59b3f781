//! Where a number comes from: code, machine, inputs, command.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::time::SystemTime;

/// What the binary knows about its own build.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Build {
    /// Version of msm.
    pub version: String,
    /// Commit, or "unknown" outside a git checkout.
    pub commit: String,
    /// "true" if the sources differed from the commit, "false" if not, "unknown" outside a git checkout.
    pub dirty: String,
    /// Compiler.
    pub rustc: String,
}

/// Written beside the records of every run.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Provenance {
    /// The code.
    #[serde(flatten)]
    pub build: Build,
    /// The command line.
    pub command: String,
    /// Scale of the experiment.
    pub scale: String,
    /// Seed of all randomness.
    pub seed: u64,
    /// Worker threads.
    pub threads: usize,
    /// Start, UTC, RFC 3339.
    pub started: String,
    /// Wall-clock seconds until the records were complete.
    pub seconds: f64,
    /// CPU model, or "unknown".
    pub cpu: String,
    /// Logical cores.
    pub logical_cores: usize,
    /// Operating system and architecture.
    pub os: String,
    /// SHA-256 of every input file by its name.
    pub inputs: BTreeMap<String, String>,
}

/// Hexadecimal SHA-256.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// RFC 3339 in UTC, to the second.
pub(crate) fn utc(time: SystemTime) -> String {
    humantime::format_rfc3339_seconds(time).to_string()
}

/// Name of the CPU as the operating system gives it.
pub(crate) fn cpu_model() -> String {
    let from_proc = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    let from_sysctl = || {
        let mut command = std::process::Command::new("sysctl");
        let output = command.args(["-n", "machdep.cpu.brand_string"]).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let from_environment = || std::env::var("PROCESSOR_IDENTIFIER").ok();
    from_proc.or_else(from_environment).or_else(from_sysctl).unwrap_or_else(|| "unknown".to_owned())
}

/// Logical cores this process may use.
pub fn logical_cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sha256_of_the_standard_example() {
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256(b"abc"), expected);
    }
}
