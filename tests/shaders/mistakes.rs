//! What `msm shader` answers: heads, JSON, and one line a mistake.

use super::msm;
use libtest_mimic::{Failed, Trial};
use serde_json::Value;
use std::process::Command;

pub fn trials() -> Vec<Trial> {
    vec![
        Trial::test("mistakes_are_one_line", mistakes),
        Trial::test("a_head_says_what_was_chosen", head),
        Trial::test("json_says_the_same", json),
        Trial::test("names_stay_readable", names),
        Trial::test("advice_leaves_a_shader", advice),
    ]
}

/// Bad input: exit code 2, nothing on standard output, one line that contains `needle`.
fn rejected(arguments: &[&str], needle: &str) -> Result<(), Failed> {
    let output = msm(arguments);
    let message = String::from_utf8(output.stderr)?;
    if output.status.code() == Some(2)
        && output.stdout.is_empty()
        && message.lines().count() == 1
        && message.contains(needle)
    {
        return Ok(());
    }
    Err(format!("{arguments:?}: {:?}, `{needle}` in: {message}", output.status).into())
}

fn mistakes() -> Result<(), Failed> {
    rejected(&["mhamburger4"], "`mhamburger4` is no technique")?;
    rejected(&["mhamburger4"], "hamburger4, hamburger6, hausdorff4")?;
    rejected(&["certified"], "`certified` has no shader (with a shader: vsm, esm")?;
    rejected(&["hamburger8"], "`hamburger8` has no shader")?;
    rejected(&["hamburger4", "--language", "cg"], "cg")?;
    rejected(&["hamburger4", "--alpha", "1.5"], "--alpha 1.5: a bias lies between 0 and 1")?;
    rejected(&["hamburger4", "--alpha", "nan"], "NaN")?;
    rejected(&["vsm", "--format", "f32", "--alpha", "0.1"], "`vsm` has no alpha")?;
    rejected(&["hamburger4", "--format", "f16"], "no bias of hamburger4 in f16 is on record")?;
    rejected(&["hamburger4", "--format", "bf16"], "bf16")?;
    rejected(&["hamburger4", "--format", "u32/256", "--alpha", "0.1"], "needs a summed-area table")?;
    rejected(&["esm", "--format", "unorm16"], "cannot hold exponential warps")?;
    rejected(&["hamburger4", "--stage", "blur"], "blur")?;
    rejected(&["soft-shadows", "--format", "f32"], "takes no --format")?;
    rejected(&["hamburger4", "--language", "spirv", "--json"], "--out")
}

fn text(arguments: &[&str]) -> Result<String, Failed> {
    let output = msm(arguments);
    if !output.status.success() {
        return Err(format!("{arguments:?}: {}", String::from_utf8_lossy(&output.stderr)).into());
    }
    Ok(String::from_utf8(output.stdout)?)
}

fn head() -> Result<(), Failed> {
    let text = text(&["hamburger4"])?;
    let head: String = text.lines().take_while(|line| line.starts_with("//")).collect::<Vec<_>>().join(" ");
    for part in [
        "unorm16, 64 bits",
        "MSM15 Algorithm 3",
        "GDC16 four moments",
        "6e-5",
        "percentage-closer",
        "MIT OR Apache-2.0",
        "stairs",
    ] {
        assert!(head.contains(part), "`{part}` in {head}");
    }
    Ok(())
}

fn json() -> Result<(), Failed> {
    let answer: Value = serde_json::from_str(&text(&["hausdorff4", "--language", "hlsl", "--json"])?)?;
    assert_eq!(answer["transform"], "MSM15 theta_4");
    assert!(answer["l1_error"].as_f64().is_some_and(|error| (0.0..0.5).contains(&error)), "{answer}");
    assert!(answer["source"].as_str().is_some_and(|source| source.contains("float shade(")), "{answer}");
    let given: Value = serde_json::from_str(&text(&["hausdorff4", "--alpha", "0.01", "--json"])?)?;
    assert_eq!((&given["alpha"], &given["l1_error"]), (&Value::from(0.01), &Value::Null));
    Ok(())
}

/// Functions, parameters and constants are called what the WGSL calls them, with its comments.
fn names() -> Result<(), Failed> {
    for language in ["hlsl", "glsl", "msl", "rust"] {
        let text = text(&["hamburger4", "--language", language])?;
        for name in [
            "encode",
            "resolve",
            "filter_taps",
            "decode",
            "shade",
            "shadow",
            "ALPHA",
            "z_f",
            "filtered",
            "The shadow of a fragment",
        ] {
            assert!(text.contains(name), "{language}: no `{name}`");
        }
    }
    Ok(())
}

/// The file of the recommended technique, and its path in the answer.
fn advice() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let scene =
        ["advise", "stairs", "--view", "oblique", "--size", "128", "--tolerance", "0.2", "--relative", "0.9"];
    let output = Command::new(env!("CARGO_BIN_EXE_msm"))
        .current_dir(folder.path())
        .args(scene)
        .args(["--shader", "hlsl"])
        .output()?;
    let said = String::from_utf8(output.stdout)?;
    let path = said.lines().find_map(|line| line.strip_prefix("shader: ")).ok_or(said.clone())?;
    let text = std::fs::read_to_string(folder.path().join(path))?.replace("\n//", " ");
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let format = path.rsplit_once('.').and_then(|(stem, _)| stem.rsplit_once('-')).map(|(_, format)| format);
    assert!(format.is_some_and(|format| said.contains(&format!(" in {format}"))), "{path} in {said}");
    assert!(
        text.contains("on the scene that `msm advise` was asked about") && text.contains("float shadow("),
        "{text}"
    );
    Ok(())
}
