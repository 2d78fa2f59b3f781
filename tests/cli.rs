//! The built binary as scripts use it: exit codes, one line per mistake, JSON and nothing else.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn msm(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_msm")).args(arguments).output().unwrap()
}

fn json(arguments: &[&str]) -> Value {
    let output = msm(&[arguments, &["--format", "json"]].concat());
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty(), "standard error is no terminal here");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} in {value}"))
}

/// An empty directory of this test's own.
fn directory(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli").join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

/// Bad input: exit code 2, nothing on standard output, one line on standard error that contains `needle`.
fn rejected(arguments: &[&str], needle: &str) {
    let message = rejected_text(arguments);
    assert!(message.contains(needle), "{arguments:?}: {message}");
}

/// The line of a refusal.
fn rejected_text(arguments: &[&str]) -> String {
    let output = msm(arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    assert_eq!(message.lines().count(), 1, "{arguments:?}: {message}");
    message
}

const TWO: &str = "0.2:0.5,0.7:0.5";

#[test]
fn bad_input_is_one_line_that_names_the_value() {
    let bound = |rest: &[&str], needle: &str| rejected(&[&["bound"], rest].concat(), needle);
    bound(&["--basis", "sinh(z)", "--atoms", TWO, "--depth", "0.8"], "sinh");
    bound(&["--basis", "power:0", "--atoms", TWO, "--depth", "0.8"], "power:0");
    bound(&["--basis", "", "--atoms", TWO, "--depth", "0.8"], "at least one function");
    bound(&["--basis", "power:4", "--moments", "0.5,0.3", "--depth", "0.8"], "2 moments given");
    bound(&["--basis", "power:2", "--moments", "0.5,NaN", "--depth", "0.8"], "NaN");
    bound(&["--basis", "power:2", "--moments", "0.5,1e999", "--depth", "0.8"], "inf");
    bound(&["--basis", "power:2", "--moments", "0.5,x", "--depth", "0.8"], "`x`");
    bound(&["--basis", "power:2", "--moments", "", "--depth", "0.8"], "--moments");
    // A variance of -0.24.
    bound(&["--basis", "power:2", "--moments", "0.5,0.01", "--depth", "0.8"], "no distribution");
    let line = ["--interval", "real"];
    bound(
        &[&["--basis", "power:2", "--moments", "0.5,0.01", "--depth", "0.8"], &line[..]].concat(),
        "no distribution",
    );
    bound(&["--basis", "power:4", "--atoms", "0.2:0.5,0.7:0.4", "--depth", "0.8"], "0.9");
    bound(&["--basis", "power:4", "--atoms", "0.2:0.5,inf:0.5", "--depth", "0.8"], "inf");
    bound(&["--basis", "power:4", "--atoms", "0.2:1.5,0.7:-0.5", "--depth", "0.8"], "-0.5");
    bound(&["--basis", "power:4", "--atoms", "0.2", "--depth", "0.8"], "`0.2`");
    bound(&["--basis", "power:4", "--atoms", "0.2:0.5,", "--depth", "0.8"], "depth:weight");
    bound(&["--basis", "power:4", "--atoms", "", "--depth", "0.8"], "--atoms is empty");
    bound(&["--basis", "power:4", "--atoms", "1.2:0.5,0.7:0.5", "--depth", "0.8"], "1.2");
    bound(&["--basis", "power:4", "--atoms", TWO, "--depth", "1.8"], "1.8");
    bound(&["--basis", "power:4", "--atoms", TWO, "--depth", "nan"], "NaN");
    bound(&["--basis", "power:4", "--atoms", TWO, "--depth", "far"], "far");
    bound(&["--basis", "power:4", "--atoms", TWO, "--moments", "1,1", "--depth", "0.8"], "--moments");
    bound(&["--basis", "power:4", "--depth", "0.8"], "--atoms");
    bound(&["--basis", "power:4", "--atoms", TWO], "--depth");
    bound(&["--basis", "power:4", "--atoms", TWO, "--depth", "0.8", "--interval", "half"], "half");
    bound(&["--basis", "power:4", "--atoms", TWO, "--depth", "0.8", "--solver", "magic"], "magic");
    bound(&["--basis", "power:3", "--atoms", TWO, "--depth", "0.8", "--interval", "real"], "power:2");
    bound(&["--basis", "trig:1", "--atoms", TWO, "--depth", "0.8", "--interval", "real"], "interval unit");
    bound(&["--basis", "power:3", "--atoms", TWO, "--depth", "0.8", "--solver", "closed"], "no closed form");
    let solver = ["--solver", "fast", "--interval", "real"];
    bound(&[&["--basis", "power:4", "--atoms", TWO, "--depth", "0.8"], &solver[..]].concat(), "solver fast");
    rejected(&[], "--help");
    rejected(&["bond"], "bond");
    rejected(&["run", "no-such.toml"], "no-such.toml");
    rejected(&["report", "no-such-run"], "no-such-run");
}

#[test]
fn the_contract_of_the_json_output() {
    let command = ["bound", "--basis", "power:4", "--interval", "unit", "--atoms", TWO, "--depth", "0.5"];
    for solver in ["lp", "fast", "closed"] {
        let answer = json(&[&command[..], &["--solver", solver]].concat());
        for key in ["lower", "upper", "lower_proved", "upper_proved"] {
            // Four moments determine two atoms: both bounds are F.
            assert!((number(&answer, key) - 0.5).abs() < 1e-8, "{solver}: {answer}");
        }
        assert!(number(&answer, "lower_proved") <= 0.5 && number(&answer, "upper_proved") >= 0.5);
        assert_eq!(answer["support"].as_array().unwrap().len(), answer["weights"].as_array().unwrap().len());
        assert!(answer["solver"].is_string());
        assert_eq!((number(&answer, "F"), number(&answer, "F_le")), (0.5, 0.5));
    }
}

#[test]
fn solvers_are_named_and_agree() {
    let command = ["bound", "--basis", "trig:2", "--atoms", "0.2:0.25,0.5:0.25,0.7:0.5", "--depth", "0.6"];
    let answers =
        ["closed", "fast", "lp"].map(|solver| json(&[&command[..], &["--solver", solver]].concat()));
    let names: Vec<&str> = answers.iter().map(|answer| answer["solver"].as_str().unwrap()).collect();
    assert_eq!(names, ["trigonometric 4", "exchange simplex", "linear program"]);
    assert_eq!(json(&command)["solver"], "trigonometric 4");
    for answer in &answers {
        assert!((number(answer, "lower") - number(&answers[0], "lower")).abs() < 1e-8, "{answer}");
        assert!(number(answer, "lower_proved") <= 0.5 && number(answer, "upper_proved") >= 0.5);
    }
}

#[test]
fn moments_give_the_bounds_of_their_atoms() {
    // Mean 0.45, second moment 0.265, so variance 0.0625; Cantelli at 0.8: 1 - v / (v + 0.35^2).
    let variance = 0.265 - 0.45 * 0.45;
    let expected = 1.0 - variance / (variance + 0.35 * 0.35);
    let common = ["bound", "--basis", "power:2", "--interval", "real", "--depth", "0.8"];
    for input in [["--atoms", TWO], ["--moments", "0.45,0.265"]] {
        let answer = json(&[&common[..], &input[..]].concat());
        assert!((number(&answer, "lower") - expected).abs() < 1e-12, "{answer}");
        assert_eq!(answer["solver"], "Chebyshev");
    }
}

#[test]
fn moments_as_a_texture_holds_them_are_bounded_once_they_are_biased() {
    // Four moments of one surface at 0.3 in single precision, which no distribution has.
    let stored = "0.30000001192,0.09000000358,0.02699999884,0.00810000021";
    let command = ["bound", "--basis", "power:4", "--moments", stored, "--depth", "0.5"];
    let message = rejected_text(&command);
    assert!(message.contains("miss") && message.contains("--alpha"), "{message}");
    let alpha = message.split("--alpha ").nth(1).unwrap().split(' ').next().unwrap();
    let answer = json(&[&command[..], &["--alpha", alpha]].concat());
    // All of the surface lies before z_f; the bias takes little of it.
    assert!(number(&answer, "lower_proved") > 0.9 && number(&answer, "lower") <= 1.0, "{answer}");
    assert!((number(&answer, "lower") - number(&answer, "lower_proved")).abs() < 1e-8, "{answer}");
    assert_eq!(answer["bias_vector"].as_array().unwrap().len(), 4);
    for format in ["unorm16", "f16", "f32"] {
        let command = ["bound", "--basis", "trig:2", "--atoms", TWO, "--depth", "0.5", "--storage", format];
        let answer = json(&[&command[..], &["--alpha", "0.01"]].concat());
        assert_eq!(answer["storage"], format);
        assert_eq!(answer["transform"], if format == "unorm16" { "plain" } else { "identity" });
        assert!(number(&answer, "lower_proved") < number(&answer, "F") + 0.01, "{answer}");
    }
    let theta = ["bound", "--basis", "power:4", "--atoms", TWO, "--depth", "0.5", "--storage", "unorm16"];
    let answer = json(
        &[
            &theta[..],
            &[
                "--transform",
                "MSM15 theta_4",
                "--alpha",
                "1e-3",
                "--bias-vector",
                "0.5,0.375,0.3125,0.2734375",
            ],
        ]
        .concat(),
    );
    assert_eq!(answer["transform"], "MSM15 theta_4");
    rejected(&[&theta[..], &["--transform", "no such"]].concat(), "no such");
    rejected(&[&theta[..], &["--alpha", "2"]].concat(), "--alpha 2");
    rejected(&[&theta[..], &["--alpha", "0.1", "--bias-vector", "1,2"]].concat(), "2 numbers");
}

#[test]
fn a_number_with_an_exponent_is_a_number() {
    let command = ["bound", "--atoms", "0.2:0.5,0.45:0.2,0.7:0.3", "--depth", "0.6"];
    let answer = json(&[&command[..], &["--basis", "z,exp(1e1z)"]].concat());
    assert!((number(&answer, "lower") - 0.335874595723).abs() < 1e-9, "{answer}");
    rejected(&[&command[..], &["--basis", "z,exp(1 e1z)"]].concat(), "1*e*1");
}

#[test]
fn negative_numbers_are_no_options() {
    let command = ["bound", "--basis", "power:4", "--interval", "real"];
    let answer = json(&[&command[..], &["--atoms", "-1:0.5,2:0.5", "--depth", "-0.5"]].concat());
    assert!((number(&answer, "lower") - 0.5).abs() < 1e-12, "{answer}");
    let answer = json(&["bound", "--basis", "-z", "--moments", "-0.5", "--depth", "0.9"]);
    assert!(number(&answer, "lower") > 0.0, "{answer}");
}

#[test]
fn human_output_shows_where_the_support_lies() {
    let output = msm(&["bound", "--basis", "power:4", "--atoms", TWO, "--depth", "0.5"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("before z_f") && text.contains("behind z_f") && text.contains("certificate gap"),
        "{text}"
    );
}

#[test]
fn a_plot_is_written_whole_or_not_at_all() {
    let directory = directory("plot");
    let path = directory.join("bounds.svg");
    let command = ["bound", "--basis", "power:2", "--interval", "real", "--depth", "0.5", "--format", "json"];
    let to = |path: &Path| {
        let plot = ["--atoms", TWO, "--plot", path.to_str().unwrap()];
        msm(&[&command[..], &plot[..]].concat())
    };
    let output = to(&path);
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    let svg = std::fs::read_to_string(&path).unwrap();
    for text in [
        "fragment depth z_f",
        "shadow intensity",
        "z_f = 0.5",
        "trig:2",
        "power:4 on [0, 1]",
        "F, percentage",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    let names: Vec<_> =
        std::fs::read_dir(&directory).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names, ["bounds.svg"]);
    let output = to(&directory.join("missing/bounds.svg"));
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), message.lines().count()), (Some(1), 1), "{message}");
    assert!(message.contains("missing"), "{message}");
    // Without atoms there is no F and no reference, but there are bounds.
    let plot = ["--moments", "0.45,0.265", "--plot", path.to_str().unwrap()];
    assert!(msm(&[&command[..], &plot[..]].concat()).status.success());
    let svg = std::fs::read_to_string(&path).unwrap();
    assert!(!svg.contains("percentage") && !svg.contains("trig:2") && svg.contains("z,z^2"));
}

#[test]
fn help_and_version_go_to_standard_output() {
    for arguments in [&["--help"][..], &["--version"], &["bound", "--help"]] {
        let output = msm(arguments);
        assert!(output.status.success() && !output.stdout.is_empty() && output.stderr.is_empty());
    }
}

#[cfg(unix)]
#[test]
fn a_closed_pipe_is_no_panic() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_msm"))
        .args(["bound", "--basis", "power:4", "--atoms", TWO, "--depth", "0.5"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
}

#[test]
fn quantize_keeps_its_contract() {
    let answer = json(&["quantize", "--order", "2"]);
    for key in ["gain_bits", "bound_bits"] {
        assert!((number(&answer, key) - 2.0).abs() < 1e-3, "{answer}");
    }
    assert!(number(&answer, "gain_bits") <= number(&answer, "bound_bits"));
    assert!(number(&answer, "range_min") >= -1e-9 && number(&answer, "range_max") <= 1.0 + 1e-9);
    assert!(number(&answer, "seconds") >= 0.0);
    let shape = |key: &str| -> Vec<usize> {
        let rows = answer[key].as_array().unwrap();
        rows.iter().map(|row| row.as_array().map_or(1, Vec::len)).collect()
    };
    assert_eq!((shape("matrix"), shape("offset")), (vec![2, 2], vec![1, 1]));
    for language in ["wgsl", "hlsl", "rust"] {
        let code = answer["snippets"][language].as_str().unwrap();
        assert!(code.contains("quantise") && code.contains("dequantise"), "{code}");
    }
    // Sparse in depths from -1 to 1, and the same gain as in depths from 0 to 1.
    let options = ["--order", "4", "--structure", "parity", "--starts", "8", "--seed", "3"];
    let signed = json(&[&["quantize"], &options[..], &["--depth-range", "signed"]].concat());
    let unit = json(&[&["quantize"], &options[..]].concat());
    assert!((number(&signed, "gain_bits") - number(&unit, "gain_bits")).abs() < 1e-9);
    let zeros = signed["matrix"].as_array().unwrap().iter().flat_map(|row| row.as_array().unwrap());
    // A row may do without more entries.
    assert!(zeros.filter(|entry| entry.as_f64() == Some(0.0)).count() >= 8, "{signed}");
    let human = msm(&["quantize", "--basis", "trig:1", "--depth-range", "0.25,0.75", "--language", "hlsl"]);
    let text = String::from_utf8(human.stdout).unwrap();
    assert!(text.contains("[0.25, 0.75]") && text.contains("void dequantise(const float s[2]"), "{text}");
}

#[test]
fn quantize_does_not_depend_on_the_unit_of_depth() {
    let metres = json(&["quantize", "--order", "6", "--depth-range", "0.3,1000", "--starts", "48"]);
    assert!((number(&metres, "gain_bits") - 30.587).abs() < 1e-3, "{metres}");
    assert!(number(&metres, "range_min") > -1e-9 && number(&metres, "range_max") < 1.0 + 1e-9, "{metres}");
}

#[test]
fn quantize_rejects_what_cannot_work_and_names_it() {
    let quantize = |rest: &[&str], needle: &str| rejected(&[&["quantize"], rest].concat(), needle);
    quantize(&["--order", "0"], "power:0");
    quantize(&["--order", "17"], "power:17");
    quantize(&["--order", "-3"], "power:-3");
    quantize(&["--order", "four"], "power:four");
    quantize(&["--basis", "z, 1-z"], "flat");
    quantize(&["--basis", "0z"], "0z");
    quantize(&["--basis", "z, z"], "twice");
    quantize(&["--order", "4", "--depth-range", "0.5,0.5"], "0.5 to 0.5");
    quantize(&["--order", "4", "--depth-range", "1,0"], "from 1 to 0");
    quantize(&["--order", "4", "--depth-range", "half"], "half");
    quantize(&["--basis", "z, ln(1+1z)", "--depth-range", "signed"], "ln(1+1z)");
    quantize(&["--order", "4", "--starts", "0"], "0 starts");
    quantize(&["--basis", "z, exp(1z)", "--structure", "parity"], "exp(1z)");
    quantize(&["--order", "4", "--basis", "power:4"], "--basis");
    quantize(&[], "--order");
}
