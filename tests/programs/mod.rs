//! Tests that need other people's programs: without these they are reported as ignored, or fail if `MSM_REQUIRE_PROGRAMS` is 1.

use libtest_mimic::{Failed, Trial};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Compiles GLSL and HLSL to SPIR-V, from Debian's glslang-tools.
pub const GLSLANG: &str = "glslangValidator";
/// Checks SPIR-V, from Debian's spirv-tools.
#[allow(dead_code, reason = "not every test binary checks")]
pub const SPIRV_VAL: &str = "spirv-val";
/// Reads SPIR-V and writes it in other languages, from Debian's spirv-cross.
#[allow(dead_code, reason = "not every test binary reads back")]
pub const SPIRV_CROSS: &str = "spirv-cross";

fn find(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|folder| folder.join(program)).find(|program| program.is_file())
}

/// A test that no missing program can turn into a pass.
pub fn program_trial(
    name: String,
    programs: &[&str],
    test: impl FnOnce() -> Result<(), Failed> + Send + 'static,
) -> Trial {
    let Some(missing) = programs.iter().find(|program| find(program).is_none()) else {
        return Trial::test(name, test);
    };
    let required = std::env::var("MSM_REQUIRE_PROGRAMS").is_ok_and(|value| value == "1");
    let reason = format!("needs {missing}");
    Trial::test(name, move || Err(reason.into())).with_ignored_flag(!required)
}

/// Runs a program; what it prints is the error where it fails.
pub fn run(program: &str, arguments: &[&str], file: &Path) -> Result<String, Failed> {
    let output = Command::new(program).args(arguments).arg(file).output()?;
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() {
        return Ok(said);
    }
    let errors = String::from_utf8_lossy(&output.stderr);
    Err(format!("{program} {arguments:?} {}: {said}{errors}", file.display()).into())
}

/// SPIR-V of one entry point of an HLSL or GLSL file, by glslang.
pub fn compiled(file: &Path, stage: &str, options: &[&str], to: &Path) -> Result<(), Failed> {
    let target = to.to_string_lossy().into_owned();
    let arguments = [&["-V", "-S", stage, "-o", &target], options].concat();
    run(GLSLANG, &arguments, file).map(|_| ())
}
