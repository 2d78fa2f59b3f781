//! The candidate search without a race: the graphics processor's records against the CPU's.

use std::path::{Path, PathBuf};
use std::process::Command;

use libtest_mimic::Failed;

use super::adapter::double_trial;

pub fn trial() -> libtest_mimic::Trial {
    double_trial("search::records_are_those_of_the_cpu".into(), compare)
}

/// Errors differ by no more than the certificates of both leave open, and are rounded in the table.
const TOLERANCE: f64 = 2e-6;

fn records(backend: &str) -> Result<Vec<(String, f64)>, Failed> {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("search-backends").join(backend);
    let _ = std::fs::remove_dir_all(&out);
    let experiment = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/candidate-search.toml");
    let output = Command::new(env!("CARGO_BIN_EXE_msm"))
        .arg("run")
        .arg(experiment)
        .args(["--scale", "smoke", "--exhaustive", "--backend", backend, "--format", "json", "--out"])
        .arg(&out)
        .output()?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned().into());
    }
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout)?;
    let directory = PathBuf::from(answer["directory"].as_str().ok_or("no directory")?);
    let mut rows = Vec::new();
    for row in csv::Reader::from_path(directory.join("records.csv"))?.deserialize() {
        let row: evaluation::SearchRecord = row?;
        assert!(row.error.is_empty(), "{}: {}", row.basis, row.error);
        rows.push((row.basis, row.l1_error));
    }
    rows.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(rows)
}

fn compare() -> Result<(), Failed> {
    let (cpu, gpu) = (records("cpu")?, records("gpu")?);
    assert!(cpu.len() == gpu.len() && cpu.len() > 300, "{} and {} records", cpu.len(), gpu.len());
    for ((basis, a), (other, b)) in cpu.iter().zip(&gpu) {
        assert!(basis == other && (a - b).abs() <= TOLERANCE, "{basis}: {a} and {b}");
    }
    Ok(())
}
