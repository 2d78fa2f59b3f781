//! `msm shader`: every technique in every format and language is compiled by other people's compilers, and mistakes are answered.
//!
//! GLSL and HLSL by glslang, SPIR-V checked by spirv-val and read by SPIRV-Cross, Rust by rustc. No compiler for Metal runs here.

// A panic is how a test or benchmark reports.
#![allow(clippy::unwrap_used)]

mod mistakes;
#[path = "../programs/mod.rs"]
mod programs;

use libtest_mimic::{Arguments, Failed, Trial};
use programs::{GLSLANG, SPIRV_CROSS, SPIRV_VAL, compiled, program_trial, run};
use serde_json::Value;
use shaders::{Module, Stage};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Output};

/// What a technique may be stored in; which of these it can be, the binary says.
const FORMATS: [&str; 5] = ["unorm16", "f16", "f32", "unorm10", "unorm8"];

/// Moment bias where none is on record.
const ALPHA: &str = "0.001";

/// Names that must have a shader in one format at least.
const TECHNIQUES: [&str; 10] = [
    "vsm",
    "esm",
    "evsm",
    "lvsm",
    "csm",
    "hamburger2",
    "hamburger4",
    "hamburger6",
    "hausdorff4",
    "trigonometric4",
];

const APPLICATIONS: [&str; 7] = [
    "soft-shadows-table",
    "soft-shadows",
    "percentage-closer-soft-shadows",
    "scattering-resample",
    "scattering-prefix-map",
    "scattering-look-up",
    "scattering-march",
];

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let mut trials = mistakes::trials();
    let needed = [GLSLANG, SPIRV_VAL, SPIRV_CROSS];
    for technique in TECHNIQUES {
        for format in FORMATS {
            let Some(options) = options(technique, format) else { continue };
            let name = format!("compiles::{technique}::{format}");
            trials.push(program_trial(name, &needed, move || compiles(technique, &options)));
        }
    }
    for application in APPLICATIONS {
        let name = format!("compiles::{application}");
        trials.push(program_trial(name, &needed, move || compiles(application, &[])));
    }
    trials.push(program_trial("compiles::every_stage_alone".to_owned(), &needed, || {
        ["encode", "resolve", "filter", "shade"].into_iter().try_for_each(|stage| {
            compiles(
                "hamburger6",
                &["--format".to_owned(), "unorm16".to_owned(), "--stage".to_owned(), stage.to_owned()],
            )
        })
    }));
    trials.push(program_trial("compiles::planted_faults".to_owned(), &needed, faults_are_found));
    trials.push(Trial::test("every_technique_is_there", || {
        let stored = |technique: &&str| FORMATS.iter().any(|format| options(technique, format).is_some());
        match TECHNIQUES.iter().find(|technique| !stored(technique)) {
            None => Ok(()),
            Some(technique) => Err(format!("{technique} has no shader in any format").into()),
        }
    }));
    libtest_mimic::run(&arguments, trials).exit_code()
}

fn msm(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_msm")).arg("shader").args(arguments).output().unwrap()
}

/// Options with which the technique is stored in the format, if it can be.
fn options(technique: &str, format: &str) -> Option<Vec<String>> {
    let plain = ["--format", format];
    let biased = ["--format", format, "--alpha", ALPHA];
    let works = |options: &[&str]| msm(&[&[technique], options].concat()).status.success();
    let options: &[&str] = if works(&plain) {
        &plain
    } else if works(&biased) {
        &biased
    } else {
        return None;
    };
    Some(options.iter().map(|&option| option.to_owned()).collect())
}

/// Where a language's file was written.
fn written(technique: &str, options: &[String], language: &str, folder: &Path) -> Result<PathBuf, Failed> {
    let folder = folder.to_string_lossy();
    let mut arguments = vec![technique, "--language", language, "--out", &folder, "--json"];
    arguments.extend(options.iter().map(String::as_str));
    let output = msm(&arguments);
    if !output.status.success() {
        return Err(format!("{arguments:?}: {}", String::from_utf8_lossy(&output.stderr)).into());
    }
    let answer: Value = serde_json::from_slice(&output.stdout)?;
    Ok(PathBuf::from(answer["file"].as_str().ok_or("no file")?))
}

/// All languages of one technique in one format.
fn compiles(technique: &str, options: &[String]) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let folder = folder.path();
    let wgsl = std::fs::read_to_string(written(technique, options, "wgsl", folder)?)?;
    let module = Module::new(&wgsl)?;
    let entries: Vec<(String, &str)> = (module.entry_points().iter())
        .map(|entry| (entry.name.clone(), if entry.stage == Stage::Compute { "comp" } else { "frag" }))
        .collect();
    assert!(!entries.is_empty(), "{technique} has no entry point");
    let spirv = written(technique, options, "spirv", folder)?;
    run(SPIRV_VAL, &["--target-env", "vulkan1.1"], &spirv)?;
    let [hlsl, glsl] = ["hlsl", "glsl"].map(|language| written(technique, options, language, folder));
    let (hlsl, glsl) = (hlsl?, glsl?);
    let object = folder.join("compiled.spv");
    for (entry, stage) in &entries {
        run(SPIRV_CROSS, &["-V", "--entry", entry, "--stage", stage], &spirv)?;
        compiled(&hlsl, stage, &["-D", "-e", entry], &object)?;
        run(SPIRV_VAL, &[], &object)?;
        run(SPIRV_CROSS, &["-V"], &object)?;
        let chosen = format!("-DENTRY_{}", entry.to_uppercase());
        compiled(&glsl, stage, &[&chosen], &object)?;
        run(SPIRV_VAL, &[], &object)?;
    }
    let msl = std::fs::read_to_string(written(technique, options, "msl", folder)?)?;
    for (entry, _) in &entries {
        assert!(msl.contains(&format!(" {entry}(")), "{entry} is not in the Metal shader");
    }
    // Textures and buffers are left out of Rust, and with them whole passes.
    if !APPLICATIONS.contains(&technique) {
        rust(&written(technique, options, "rust", folder)?, folder)?;
    }
    Ok(())
}

fn rust(file: &Path, folder: &Path) -> Result<(), Failed> {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let to = folder.to_string_lossy();
    let options = [
        "--crate-type",
        "lib",
        "--edition",
        "2021",
        "-D",
        "warnings",
        "--emit",
        "metadata",
        "--out-dir",
        &to,
    ];
    run(&rustc, &options, file).map(|_| ())
}

/// The compilers would notice.
fn faults_are_found() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let folder = folder.path();
    let object = folder.join("compiled.spv");
    let options = ["--stage".to_owned(), "shade".to_owned()];
    for (language, flags) in [("hlsl", &["-D", "-e", "shade_pixel"][..]), ("glsl", &[])] {
        let file = written("hamburger4", &options, language, folder)?;
        compiled(&file, "frag", flags, &object)?;
        let text = std::fs::read_to_string(&file)?;
        assert!(text.contains("z_f"), "{text}");
        std::fs::write(&file, text.replacen("float z_f", "float z", 1))?;
        if compiled(&file, "frag", flags, &object).is_ok() {
            return Err(format!("{language}: a missing variable passed").into());
        }
    }
    Ok(())
}
