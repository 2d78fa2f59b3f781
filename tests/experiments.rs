//! Every experiment at smoke scale, and what must hold for all of them.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

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

#[test]
fn every_experiment_runs_at_smoke_scale_without_a_failed_trial() {
    for experiment in experiments() {
        let out = directory("smoke");
        let run = smoke(&experiment, &out, &[]);
        for file in ["experiment.toml", "provenance.json", "records.csv", "samples.csv", "README.md"] {
            assert!(run.join(file).is_file(), "{}: {file}", experiment.display());
        }
        let mut reader = csv::Reader::from_path(run.join("records.csv")).unwrap();
        let error = reader.headers().unwrap().iter().position(|name| name == "error").unwrap();
        let mut rows = 0;
        for row in reader.records() {
            let row = row.unwrap();
            assert_eq!(&row[error], "", "{}: {row:?}", experiment.display());
            rows += 1;
        }
        assert!(rows > 0, "{}", experiment.display());
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
fn mistakes_in_the_file_are_errors_that_name_key_and_file() {
    let folder = directory("mistakes");
    let bounds = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/bounds.toml");
    let text = std::fs::read_to_string(bounds).unwrap();
    let cases = [
        ("seed = 1", "seed = 1\nsede = 2", "sede"),
        ("[scale.paper]\ndepths", "[scale.paper]\ndepth", "unknown field `depth`"),
        ("[scale.paper]", "[scale.huge]", "huge"),
        ("kind = \"bounds\"", "kind = \"bonds\"", "bonds"),
        ("kind = \"bounds\"", "", "kind"),
        (
            "[scale.paper]",
            "[[candidate]]\nname = \"VSM\"\n[scale.paper]",
            "[[candidate]] is spelled [[technique]] now",
        ),
        ("question =", "# question =", "line"),
        ("basis = \"z, z^2\"", "basis = \"sinh(z)\"", "sinh"),
        ("interval = \"real\"", "interval = \"unit\", solver = \"magic\"", "magic"),
        ("kernels = [\"two surfaces\"]", "kernels = [\"none\"]", "none"),
        ("seed = 1", "seed = ", "line"),
    ];
    refused(&folder, &text, &cases);
}

/// Old text, new text, word of the message.
type Mistake = (&'static str, &'static str, &'static str);

/// An unknown key, a value that makes no sense and one of another type, for every kind.
#[test]
fn mistakes_in_every_kind_name_line_key_and_value() {
    let cases: [(&str, [Mistake; 5]); 6] = [
        (
            "bounds",
            [
                ("seed = 1", "sede = 1", "unknown field `sede`"),
                ("seed = 1", "seed = \"one\"", "seed"),
                ("depths = 41", "depths = 1", "depths = 1 "),
                ("kernels = [\"two surfaces\"]", "kernels = [\"none\"]", "kernel `none`"),
                ("basis = \"z, z^2\"", "basis = \"sinh(z)\"", "sinh"),
            ],
        ),
        (
            "filterable",
            [
                ("size = 512", "sise = 512", "unknown field `sise`"),
                ("plane_limit = 0.05", "plane_limit = true", "plane_limit"),
                ("size = 1024", "size = 0", "size = 0 "),
                ("surface_gap = 0.004", "surface_gap = -1.0", "surface_gap"),
                ("exponent = 80.0", "exponent = 120.0", "exponent = 120"),
            ],
        ),
        (
            "quantization",
            [
                ("seed = 1", "sede = 1", "unknown field `sede`"),
                ("plane_limit = 0.05", "plane_limit = \"flat\"", "plane_limit"),
                ("hull_points = 201", "hull_points = true", "hull_points"),
                ("basis = \"power:3\"", "basis = \"power:0\"", "power:0"),
                ("alphas = {", "alphas = 3 # {", "alphas"),
            ],
        ),
        (
            "candidate-search",
            [
                ("seed = 1", "sede = 1", "unknown field `sede`"),
                ("cells = 256", "cells = \"many\"", "cells"),
                ("cells = 256", "cells = 8", "cells = 8 "),
                ("plane_limit = 0.05", "plane_limit = []", "plane_limit"),
                ("tolerance = 1e-6", "tolerance = 1.0", "tolerance = 1 "),
            ],
        ),
        (
            "stability",
            [
                ("seed = 1", "sede = 1", "unknown field `sede`"),
                ("seed = 1", "seed = -1", "-1"),
                ("draws = 40", "draws = 4.5", "draws"),
                ("alpha = 1e-9", "alpha = \"little\"", "alpha"),
                ("plane_limit = 0.05", "plane_limits = 0.05", "plane_limits"),
            ],
        ),
        (
            "speed-accuracy",
            [
                ("seed = 1", "sede = 1", "unknown field `sede`"),
                ("plane_limit = 0.05", "plane_limit = \"flat\"", "plane_limit"),
                ("divisors = [1, 2, 4]", "divisors = [3]", "divisors[0] = 3"),
                ("exponent = 11.0", "exponent = 12.0", "12"),
                ("rounds = 2", "rounds = 0", "in 0 rounds"),
            ],
        ),
    ];
    for (name, cases) in cases {
        let folder = directory(&format!("every-{name}"));
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("experiments/{name}.toml"));
        let text = std::fs::read_to_string(file).unwrap();
        refused(&folder, &text, &cases);
        for (i, (old, ..)) in cases.iter().enumerate() {
            let path = folder.join(format!("case-{i}.toml"));
            let message = String::from_utf8(msm(&["run", path.to_str().unwrap()]).stderr).unwrap();
            let line = text[..text.find(old).unwrap()].matches('\n').count() + 1;
            assert!(message.contains(&format!("case-{i}.toml: line {line}: ")), "{line}: {message}");
        }
    }
}

/// Runs an experiment with one mistake after the other, as (old text, new text, word of the message).
fn refused(folder: &Path, text: &str, cases: &[(&str, &str, &str)]) {
    for (i, (old, new, needle)) in cases.iter().enumerate() {
        assert!(text.contains(old), "{old}");
        let path = folder.join(format!("case-{i}.toml"));
        std::fs::write(&path, text.replacen(old, new, 1)).unwrap();
        let out = folder.join("results");
        let output =
            msm(&["run", path.to_str().unwrap(), "--scale", "smoke", "--out", out.to_str().unwrap()]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{new}: {message}");
        assert!(message.contains(needle) && message.contains(&format!("case-{i}.toml")), "{new}: {message}");
        assert!(!out.exists(), "{new}");
    }
}

#[test]
fn mistakes_in_ways_to_store_moments_name_line_and_value() {
    let folder = directory("stores");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/quantization.toml");
    let text = std::fs::read_to_string(file).unwrap();
    let cases = [
        ("\"GDC16 four moments\"]", "\"theta_5\"]", "theta_5"),
        ("formats = [\"unorm16\", \"unorm10\", \"f16\"]", "formats = [\"unorm8\"]", "unorm8"),
        ("kernel = { shape = \"box\", size = 9 }", "", "shape box"),
        ("formats = [\"u32/256\"]", "formats = [\"u32/80\"]", "u32/80"),
        ("baseline = \"MSM15 theta_4\"", "baseline = \"optimal\"", "optimal"),
        ("alphas = { from = 1e-8", "alphas = { from = 0.0", "alphas"),
        ("basis = \"power:3\"", "basis = \"power:0\"", "power:0"),
        (
            "bound = \"trigonometric4\", transforms = [\"plain\", \"optimal\"]",
            "bound = \"trigonometric4\", range = \"signed\", transforms = [\"plain\"]",
            "depths from 0 to 1",
        ),
    ];
    refused(&folder, &text, &cases);
    // The mistake's line is told as well.
    let path = folder.join("case-0.toml");
    let message = String::from_utf8(msm(&["run", path.to_str().unwrap()]).stderr).unwrap();
    assert!(message.contains("line "), "{message}");
}

#[test]
fn mistakes_in_stability_methods_name_line_and_value() {
    let folder = directory("stability");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/stability.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let cases = [
        ("shape = \"pole\"", "shape = \"hole\"", "hole"),
        ("alpha = 1e-9", "alpha = 1.5", "technique[0].method: alpha = 1.5"),
        (
            "centre = [0.0, 0.5]",
            "centre = [0.0]",
            "technique[0].method: centre = [0.0]: are not the 2 numbers",
        ),
        ("name = \"two surfaces\"", "name = \"one surface\"", "family `one surface` appears twice"),
        ("format = \"unorm10\"", "format = \"unorm9\"", "unorm9"),
        ("\"MSM15 theta_4\"", "\"MSM15 theta_5\"", "MSM15 theta_5"),
        (
            "name = \"trigonometric 4, f64\"\n",
            "name = \"trigonometric 4, f64\"\nroute = \"textbook\"\n",
            "not published",
        ),
        ("cells = 12", "cells = 0", "cells = 0"),
        ("x = { from = 1e-8, to = 0.3 }", "x = { from = 0.5, to = 0.3 }", "from = 0.5, to = 0.3"),
    ];
    refused(&folder, &text, &cases);
    let message =
        String::from_utf8(msm(&["run", folder.join("case-1.toml").to_str().unwrap()]).stderr).unwrap();
    assert!(message.contains("line "), "{message}");
}

#[test]
fn mistakes_in_candidates_name_line_and_value() {
    let folder = directory("speed");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/speed-accuracy.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let cases = [
        ("format = \"f16\"", "format = \"unorm16\"", "cannot hold exponential warps"),
        ("exponent = 11.0", "exponent = 12.0", "12"),
        ("transform = \"GDC16 four moments\"", "transform = \"MSM15 theta_2\"", "order of the transform = 2"),
        ("alphas = [5e-7, 5e-6]", "alphas = [1.5]", "alpha = 1.5"),
        ("bound = \"vsm\"", "bound = \"vsm\", alphas = [1e-5]", "`vsm` has no alpha"),
        ("divisors = [1, 2, 4]", "divisors = [3]", "divisors[0] = 3"),
        ("{ leak_reduction = 0.3 }", "{ leak_reduction = 1.0 }", "leak_reduction = 1"),
        ("\"VSM, f32\"", "\"VSM, f64\"", "VSM, f64"),
        ("kernels = [5, 17, 33]", "kernels = [4]", "kernel size 4"),
        ("rounds = 2", "rounds = 0", "in 0 rounds"),
        ("output = [320, 180]", "output = [0, 180]", "every_view"),
        ("gap_tolerances = [0.1, 0.02, 0.004]", "gap_tolerances = [0.0]", "tolerance 0"),
        ("insets = [[112", "insets = [[470", "inset [470"),
    ];
    refused(&folder, &text, &cases);
    let message =
        String::from_utf8(msm(&["run", folder.join("case-1.toml").to_str().unwrap()]).stderr).unwrap();
    assert!(message.contains("line "), "{message}");
}

#[test]
fn the_worst_inputs_are_commands_that_print_their_exact_bound() {
    let stability = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/stability.toml");
    let run = smoke(&stability, &directory("worst"), &[]);
    let mut reader = csv::Reader::from_path(run.join("worst.csv")).unwrap();
    let headers = reader.headers().unwrap().clone();
    let place = |name: &str| headers.iter().position(|header| header == name).unwrap();
    let mut tried = 0;
    for row in reader.records() {
        let row = row.unwrap();
        let (Ok(exact), command) = (row[place("exact")].parse::<f64>(), &row[place("command")]) else {
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
fn mistakes_in_techniques_and_scenes_name_key_and_value() {
    let folder = directory("techniques");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/filterable.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let cases = [
        ("bound = \"vsm\"", "bound = \"vsmm\"", "vsmm"),
        ("bound = \"vsm\"", "kind = \"vsm\"", "bound"),
        ("\nsize = 96", "\nsize = 7", "kernel.size = 9 exceeds the map's size = 7"),
        ("shape = \"box\", size = 1 ", "shape = \"box\", size = 101 ", "comparison.size = 101 exceeds"),
        ("coefficients = 16", "coefficients = \"many\"", "many"),
        ("size = 9, sigma", "size = 8, sigma", "size = 8"),
        ("exponent = 80.0", "exponent = 120.0", "exponent = 120"),
        ("exponent = 42.0", "exponent = 50.0", "exponent = 50"),
        ("texels = 1.0, slopes = 2.0", "texels = -1.0, slopes = 2.0", "texels = -1"),
        ("plane_limit = 0.05", "plane_limit = 7.0", "plane_limit = 7"),
        ("scenes = [\"stairs\"]", "scenes = [\"castle\"]", "castle"),
        ("views = [\"oblique\"]", "views = [\"midnight\"]", "midnight"),
        ("beta = 0.5 }", "beta = 1.5 }", "beta = 1.5"),
        ("layers = 4", "layer = 4", "layer"),
        ("id = \"kernel\",", "id = \"kernel\", texel = [1, 2],", "texel = [1, 2]"),
        ("\nfragments = 400", "\nfragments = 3", "certified_fragments = 4"),
    ];
    for (i, (old, new, needle)) in cases.into_iter().enumerate() {
        assert!(text.contains(old), "{old}");
        let path = folder.join(format!("case-{i}.toml"));
        std::fs::write(&path, text.replacen(old, new, 1)).unwrap();
        let out = folder.join("results");
        let command = ["run", path.to_str().unwrap(), "--scale", "smoke", "--out", out.to_str().unwrap()];
        let output = msm(&command);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{new}: {message}");
        assert!(message.contains(needle), "{new}: {message}");
        // Cases that begin with a newline contradict another key, and that one's line is named.
        let line = text[..text.find(old).unwrap()].matches('\n').count() + 1;
        let place = if old.starts_with('\n') { "line ".to_owned() } else { format!("line {line}: ") };
        assert!(message.contains(&format!("case-{i}.toml: {place}")), "{new}: {place}: {message}");
    }
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
        (changed("version", 2u32.to_le_bytes()), "'version' holds 2"),
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
    let mut reader = csv::Reader::from_path(run.join("records.csv")).unwrap();
    let header = reader.headers().unwrap().clone();
    let column = |name: &str| header.iter().position(|h| h == name).unwrap();
    let wanted =
        ["scene", "technique", "bias", "class", "l1_error", "leak", "unbiased_violations"].map(column);
    let mut pooled = std::collections::BTreeMap::new();
    for row in reader.records().map(Result::unwrap) {
        let [scene, technique, bias, class, l1, leak, violations] = wanted.map(|i| row[i].to_owned());
        assert!(violations.is_empty() || violations == "0", "{technique}: {violations} violations");
        if (scene.as_str(), bias.as_str(), class.as_str()) == ("all", "0", "all") {
            pooled.insert(technique, (l1.parse::<f64>().unwrap(), leak.parse::<f64>().unwrap()));
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
