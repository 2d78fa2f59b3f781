//! Every experiment at smoke scale, and what must hold for all of them.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

mod application_mistakes;
mod mistakes;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn msm(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_msm")).args(arguments).output().unwrap()
}

fn directory(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("experiments").join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn experiments() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> =
        files.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    files.sort();
    assert!(!files.is_empty());
    files
}

/// Runs at smoke scale and returns the run directory.
fn smoke(experiment: &Path, out: &Path, more: &[&str]) -> PathBuf {
    let command = ["run", experiment.to_str().unwrap(), "--scale", "smoke", "--format", "json"];
    let output = msm(&[&command[..], &["--out", out.to_str().unwrap()], more].concat());
    assert!(output.status.success(), "{}: {}", experiment.display(), String::from_utf8_lossy(&output.stderr));
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer["failed"], 0, "{answer}");
    PathBuf::from(answer["directory"].as_str().unwrap())
}

/// Rows of a recorded table, by the names of its columns.
fn rows(run: &Path, table: &str) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(run.join(table)).unwrap();
    reader.deserialize().map(Result::unwrap).collect()
}

#[test]
fn every_experiment_runs_at_smoke_scale_without_a_failed_trial() {
    for experiment in experiments() {
        let out = directory("smoke");
        let run = smoke(&experiment, &out, &[]);
        let is_timed = std::fs::read_to_string(&experiment).unwrap().contains("timing");
        let samples = is_timed.then_some("samples.csv");
        let files = ["experiment.toml", "provenance.json", "records.csv", "README.md"];
        for file in files.into_iter().chain(samples) {
            assert!(run.join(file).is_file(), "{}: {file}", experiment.display());
        }
        let records = rows(&run, "records.csv");
        for row in &records {
            assert_eq!(row["error"], "", "{}: {row:?}", experiment.display());
        }
        assert!(!records.is_empty(), "{}", experiment.display());
    }
}

#[test]
fn records_depend_neither_on_threads_nor_on_the_run_and_no_run_is_overwritten() {
    for experiment in experiments() {
        let out = directory("threads");
        let runs: Vec<PathBuf> =
            ["1", "3", "3"].iter().map(|threads| smoke(&experiment, &out, &["--threads", threads])).collect();
        assert!(runs[0] != runs[1] && runs[1] != runs[2] && runs[0] != runs[2], "{runs:?}");
        // Everything but times: tables, kernels and error maps too.
        let names = |run: &PathBuf| {
            let entries =
                std::fs::read_dir(run).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
            let timed = ["samples.csv", "frames.csv", "provenance.json", "README.md", "time.svg", "gpu.svg"];
            let mut names: Vec<String> = entries.filter(|name| !timed.contains(&name.as_str())).collect();
            names.sort();
            names
        };
        assert!(names(&runs[0]) == names(&runs[1]) && names(&runs[1]) == names(&runs[2]));
        for name in names(&runs[0]) {
            let bytes = |run: &PathBuf| std::fs::read(run.join(&name)).unwrap();
            assert!(bytes(&runs[0]) == bytes(&runs[1]) && bytes(&runs[1]) == bytes(&runs[2]), "{name}");
        }
    }
}

#[test]
fn another_seed_is_recorded_and_changes_the_rough_kernel() {
    let bounds = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/bounds.toml");
    let out = directory("seed");
    let read = |run: &Path, file: &str| std::fs::read_to_string(run.join(file)).unwrap();
    let (first, second) = (smoke(&bounds, &out, &["--seed", "1"]), smoke(&bounds, &out, &["--seed", "7"]));
    assert!(read(&second, "provenance.json").contains("\"seed\": 7"));
    assert!(read(&second, "experiment.toml").contains("seed = 7"));
    assert_ne!(read(&first, "records.csv"), read(&second, "records.csv"));
}

#[test]
fn the_worst_inputs_are_commands_that_print_their_exact_bound() {
    let stability = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/stability.toml");
    let run = smoke(&stability, &directory("worst"), &[]);
    let mut tried = 0;
    for row in rows(&run, "worst.csv") {
        let (Ok(exact), command) = (row["exact"].parse::<f64>(), &row["command"]) else {
            continue;
        };
        // On [0, 1] a certificate may need more digits than there are; on the line it never does.
        if tried >= 60 || !command.contains("--interval real") {
            continue;
        }
        let words: Vec<&str> = command.split(' ').skip(1).chain(["--format", "json"]).collect();
        let output = msm(&words);
        assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
        let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let lower = answer["lower"].as_f64().unwrap();
        // Moments to 32 digits, from which the command starts, do not tell thin surfaces from one depth.
        let proved = answer["upper_proved"].as_f64().unwrap();
        assert!(exact <= proved + 1e-6, "{command}: {exact} {answer}");
        tried += usize::from((lower - exact).abs() < 1e-6);
    }
    assert!(tried >= 30, "{tried}");
}

#[test]
fn a_run_that_cannot_start_leaves_nothing_behind() {
    let folder = directory("start");
    let bounds = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/bounds.toml");
    let text = std::fs::read_to_string(bounds).unwrap().replace("basis = \"power:2\"", "basis = \"power:3\"");
    let path = folder.join("odd.toml");
    std::fs::write(&path, text).unwrap();
    let run = |out: &Path| {
        msm(&["run", path.to_str().unwrap(), "--scale", "smoke", "--out", out.to_str().unwrap()])
    };
    let output = run(&folder.join("results"));
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{message}");
    assert!(message.contains("VSM") && message.contains("power:2"), "{message}");
    assert_eq!(std::fs::read_dir(folder.join("results/odd")).unwrap().count(), 0);
    // A file where the results should go.
    let output = run(&path);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), message.lines().count()), (Some(1), 1), "{message}");
    assert!(message.contains("odd.toml"), "{message}");
}

#[test]
fn report_rewrites_the_same_files() {
    let run = smoke(&experiments()[0], &directory("report"), &[]);
    let page = run.join("README.md");
    let before = std::fs::read(&page).unwrap();
    std::fs::remove_file(&page).unwrap();
    assert!(msm(&["report", run.to_str().unwrap()]).status.success());
    assert_eq!(before, std::fs::read(&page).unwrap());
}

#[test]
fn stacks_are_evaluated_and_those_of_another_version_or_with_nan_are_refused() {
    let folder = directory("stacks");
    let out = folder.to_str().unwrap();
    let rendered = msm(&["render", "stairs", "--size", "96", "--backend", "cpu", "--out", out]);
    assert!(rendered.status.success());
    let stack = folder.join("stairs-high.stack.npz");
    let experiment = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/filterable.toml");
    let run = smoke(&experiment, &folder, &["--scene", stack.to_str().unwrap()]);
    assert!(std::fs::read_to_string(run.join("views.csv")).unwrap().contains("stairs-high.stack.npz,stack"));
    let text = std::fs::read_to_string(&experiment).unwrap();
    let intact = std::fs::read(&stack).unwrap();
    // The archive stores arrays as they are: the last four bytes of an array, before the next header "PK".
    let changed = |array: &str, value: [u8; 4]| {
        let mut bytes = intact.clone();
        let find = |from: usize, needle: &[u8]| {
            from + intact[from..].windows(needle.len()).position(|window| window == needle).unwrap()
        };
        let header = find(0, format!("{array}.npy").as_bytes());
        let start = find(header, b"\x93NUMPY");
        let end = find(start, b"PK\x03\x04");
        bytes[end - 4..end].copy_from_slice(&value);
        // The entry's checksum, in its own header and in the directory.
        let checksum = crc32(&bytes[start..end]);
        let local = header - 30;
        let directory = find(header + 1, format!("{array}.npy").as_bytes()) - 46;
        bytes[local + 14..local + 18].copy_from_slice(&checksum.to_le_bytes());
        bytes[directory + 16..directory + 20].copy_from_slice(&checksum.to_le_bytes());
        bytes
    };
    for (i, (bytes, needle)) in [
        (changed("version", 3u32.to_le_bytes()), "'version' holds 3"),
        (changed("depths", f32::NAN.to_le_bytes()), "'depths' is invalid: holds NaN"),
        (changed("gradients", f32::NAN.to_le_bytes()), "'gradients' is invalid"),
        (b"no archive".to_vec(), "no .npz archive"),
    ]
    .into_iter()
    .enumerate()
    {
        let name = format!("bad-{i}.npz");
        std::fs::write(folder.join(&name), bytes).unwrap();
        let path = folder.join(format!("bad-{i}.toml"));
        let scene = folder.join(&name).display().to_string();
        std::fs::write(&path, text.replace("scenes = [\"stairs\"]", &format!("scenes = ['{scene}']")))
            .unwrap();
        let output = msm(&["run", path.to_str().unwrap(), "--scale", "smoke", "--out", out]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{message}");
        for part in [needle, "line ", "scenes[0]", name.as_str()] {
            assert!(
                message.contains(part) || (part == name && message.contains(&scene)),
                "{part}: {message}"
            );
        }
    }
}

/// The checksum of zip archives.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg()))
    })
}

#[test]
fn another_scene_replaces_the_experiments_own() {
    let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments");
    let out = directory("scene");
    // A wall over a ground, from a file.
    let file = out.join("wall.obj");
    let vertices = "v -4 0 -4\nv 4 0 -4\nv 4 0 4\nv -4 0 4\nv -1 1 -1\nv 1 1 -1\nv 1 1 1\nv -1 1 1\n";
    std::fs::write(&file, format!("{vertices}f 4 3 2 1\nf 8 7 6 5\n")).unwrap();
    let run = smoke(&experiments.join("filterable.toml"), &out, &["--scene", file.to_str().unwrap()]);
    let views = std::fs::read_to_string(run.join("views.csv")).unwrap();
    assert!(views.contains("wall.obj,default"), "{views}");
    assert!(std::fs::read_to_string(run.join("provenance.json")).unwrap().contains("wall.obj"));
    assert!(run.join("kernel.svg").is_file() && run.join("leak-wall-default.svg").is_file());
    let reported = msm(&["report", run.to_str().unwrap()]);
    assert!(reported.status.success());
    for (experiment, scene, needle) in
        [("bounds.toml", "stairs", "--scene"), ("filterable.toml", "no-such.glb", "no-such.glb")]
    {
        let path = experiments.join(experiment);
        let out = out.join("none");
        let command = ["run", path.to_str().unwrap(), "--scale", "smoke", "--scene", scene];
        let output = msm(&[&command[..], &["--out", out.to_str().unwrap()]].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{message}");
        assert!(message.contains(needle), "{message}");
    }
}

#[test]
fn the_order_of_techniques_and_bounds_that_hold_at_smoke_scale() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/filterable.toml");
    let run = smoke(&path, &directory("order"), &[]);
    let mut pooled = BTreeMap::new();
    for row in rows(&run, "records.csv") {
        let (technique, violations) = (&row["technique"], &row["unbiased_violations"]);
        assert!(violations.is_empty() || violations == "0", "{technique}: {violations} violations");
        if [&row["scene"], &row["bias"], &row["class"]] == ["all", "0", "all"] {
            let number = |column: &str| row[column].parse::<f64>().unwrap();
            pooled.insert(technique.clone(), (number("l1_error"), number("leak")));
        }
    }
    let leak = |name: &str| pooled[name].1;
    assert_eq!(leak("PCF 9x9"), 0.0);
    // More moments of the same kind, and more prior knowledge, never leak more.
    for pair in ["Hamburger 8", "Hamburger 6", "Hamburger 4", "VSM"].windows(2) {
        assert!(leak(pair[0]) < leak(pair[1]), "{pair:?}: {pooled:?}");
    }
    assert!(leak("Hausdorff 4") <= leak("Hamburger 4") + 1e-9);
    assert!(leak("VSM") < leak("ESM, c = 80"));
    assert!(pooled["Hamburger 4"].0 < pooled["VSM"].0);
}
