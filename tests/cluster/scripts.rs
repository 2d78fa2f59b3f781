//! The folder that `msm cluster` writes, without a cluster.

use libtest_mimic::Failed;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A new folder for a test.
pub fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cluster").join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

/// A program, in the places where daemons are, too.
pub fn found(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let places = std::env::split_paths(&path).chain(["/usr/sbin".into(), "/usr/local/sbin".into()]);
    let found = places.map(|place| place.join(program)).find(|program| program.is_file())?;
    // There is another program of this name.
    let is_meant = || {
        let version = Command::new(&found).arg("--version").output();
        version.is_ok_and(|output| String::from_utf8_lossy(&output.stdout).contains("GNU"))
    };
    (program != "parallel" || is_meant()).then_some(found)
}

pub fn experiment(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments").join(format!("{name}.toml"))
}

pub fn msm(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_msm"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments);
    command
}

pub fn succeeded(output: &Output) -> Result<(), Failed> {
    if output.status.success() {
        return Ok(());
    }
    Err(format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
        .into())
}

/// The tables of a run whose bytes depend on the experiment alone.
pub fn records(run: &Path) -> Vec<(String, Vec<u8>)> {
    let names = std::fs::read_dir(run).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<String> = names.map(|name| name.into_string().unwrap()).collect();
    names.retain(|name| name.ends_with(".csv") && name != "samples.csv");
    names.sort();
    names.into_iter().map(|name| (name.clone(), std::fs::read(run.join(&name)).unwrap())).collect()
}

/// Records of the search at scale smoke, on one machine.
pub fn whole(out: &Path) -> Result<Vec<(String, Vec<u8>)>, Failed> {
    let search = experiment("candidate-search");
    let out = out.to_str().unwrap();
    let arguments = ["run", search.to_str().unwrap(), "--scale", "smoke", "--format", "json", "--out", out];
    let output = msm(&arguments).output()?;
    succeeded(&output)?;
    let answer: Value = serde_json::from_slice(&output.stdout)?;
    let records = records(Path::new(answer["directory"].as_str().unwrap()));
    assert!(records.iter().any(|(name, bytes)| name == "records.csv" && bytes.len() > 10_000));
    Ok(records)
}

pub fn status(folder: &Path) -> Result<Value, Failed> {
    let output = msm(&["cluster", "status", folder.to_str().unwrap(), "--format", "json"]).output()?;
    succeeded(&output)?;
    Ok(serde_json::from_slice(&output.stdout)?)
}

pub fn gnu_parallel() -> Result<(), Failed> {
    let out = folder("parallel it's");
    let whole = whole(&out.join("one"))?;
    let search = experiment("candidate-search");
    let many = out.join("many");
    let text = many.to_str().unwrap();
    let arguments =
        ["cluster", search.to_str().unwrap(), "--scale", "smoke", "--shards", "5", "--engine", "parallel"];
    succeeded(&msm(&arguments).args(["--out", text, "--submit"]).output()?)?;
    let told = status(&many)?;
    assert_eq!(records(Path::new(told["run"].as_str().unwrap())), whole);
    assert!(told["resubmit"].is_null());
    // Something is lost, and the line that was told brings it back.
    std::fs::remove_file(many.join("parts/round-1/shard-0003-of-0005.part"))?;
    std::fs::remove_dir_all(many.join("results"))?;
    let told = status(&many)?;
    assert_eq!(told["rounds"][1]["missing"], serde_json::json!([3]));
    let line = told["resubmit"].as_str().unwrap();
    assert!(line.ends_with("submit.sh' 1 '3'"), "{line}");
    succeeded(&Command::new("sh").args(["-c", line]).output()?)?;
    assert_eq!(records(Path::new(status(&many)?["run"].as_str().unwrap())), whole);
    Ok(())
}

pub fn mistakes() -> Result<(), Failed> {
    let out = folder("mistakes");
    let (search, bounds) = (experiment("candidate-search"), experiment("bounds"));
    let (search, bounds) = (search.to_str().unwrap(), bounds.to_str().unwrap());
    let new = out.join("new");
    let new = new.to_str().unwrap();
    let cases: [(&[&str], &str); 9] = [
        (&[bounds, "--shards", "4", "--out", new], "kind \"bounds\", which is not divided"),
        (&[search, "--shards", "0", "--out", new], "--shards 0 is not between 1 and 9999"),
        (&[search, "--shards", "4", "--threads", "0", "--out", new], "--threads 0"),
        (&[search, "--shards", "4", "--time", "1:00\n#SBATCH", "--out", new], "--time"),
        (&[search, "--shards", "4", "--setup", "nowhere.sh", "--out", new], "--setup nowhere.sh"),
        (&[search, "--shards", "4", "--engine", "pbs", "--out", new], "pbs"),
        (&[search, "--shards", "4"], "--out"),
        (&["nowhere.toml", "--shards", "4", "--out", new], "nowhere.toml"),
        (&["status", out.to_str().unwrap()], "plan.json"),
    ];
    for (arguments, needle) in cases {
        let output = msm(&["cluster"]).args(arguments).output()?;
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{arguments:?}: {message}");
        assert!(message.contains(needle), "{needle}: {message}");
        assert_eq!(std::fs::read_dir(&out)?.count(), 0, "{arguments:?}");
    }
    // A folder with something in it is left alone.
    std::fs::create_dir(new)?;
    std::fs::write(Path::new(new).join("mine"), "mine")?;
    let output = msm(&["cluster", search, "--shards", "4", "--out", new]).output()?;
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("not empty"));
    assert_eq!(std::fs::read_dir(new)?.count(), 1);
    Ok(())
}

pub fn forecast() -> Result<(), Failed> {
    let search = experiment("candidate-search");
    let arguments =
        ["cluster", search.to_str().unwrap(), "--scale", "smoke", "--dry-run", "--format", "json"];
    let ask = |more: &[&str]| -> Result<Value, Failed> {
        let output = msm(&arguments).args(more).output()?;
        succeeded(&output)?;
        Ok(serde_json::from_slice(&output.stdout)?)
    };
    let answer = ask(&["--shards", "2000", "--time", "later", "--mem", "1M"])?;
    let warnings = answer["warnings"].to_string();
    for needle in ["MaxArraySize", "--time later", "--mem 1M", "have nothing to do", "its start"] {
        assert!(warnings.contains(needle), "{needle}: {warnings}");
    }
    assert_eq!(
        (answer["arrays"].as_array().unwrap().len(), answer["arrays"][2].as_str()),
        (3, Some("1-2000"))
    );
    assert!(answer["forecast"]["core_hours"].as_f64().unwrap() > 0.0);
    let answer = ask(&["--shards", "4", "--time", "1:00:00", "--mem", "4G"])?;
    assert!(!answer["warnings"].to_string().contains("--time"), "{answer}");
    Ok(())
}
