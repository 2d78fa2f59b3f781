//! `msm shader`: a technique as one file to paste into an engine.

mod applications;
mod head;
mod language;
mod preset;

use crate::outcome::Failure;
use crate::staging::Staging;
use anyhow::{Context, anyhow};
use clap::ValueEnum;
use evaluation::Choice;
use language::Language;
use preset::Preset;
use quantization::NumberFormat;
use serde::Serialize;
use shaders::reachable;
use shadow_filtering::{RealTime, ShadowPass, Surroundings};
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

/// Where `msm advise` puts its file, as `msm render` does.
pub(crate) const DEFAULT_FOLDER: &str = "out";

/// Depth samples of a pixel for `resolve`.
const SAMPLES: usize = 4;

/// Write a technique as a shader, self-contained, with all constants in place.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Name of a bound as in experiments (vsm, hamburger4, ...), or of a part of an application (soft-shadows, ...); an unknown
    /// name lists all.
    technique: String,
    /// Number format of the shadow map: unorm16, f16, f32, unorm10 or unorm8. Without this the smallest that is on record.
    #[arg(long)]
    format: Option<NumberFormat>,
    /// Moment bias, from 0 to 1; without this the one that errs least on the recorded scenes.
    #[arg(long, allow_hyphen_values = true)]
    alpha: Option<f64>,
    /// Language of the file.
    #[arg(long, value_enum, default_value_t)]
    language: Language,
    /// Part of the technique.
    #[arg(long, value_enum, default_value_t)]
    stage: Stage,
    /// Folder for the file; without this it goes to standard output.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// One JSON object on standard output: what was chosen, and the file's path or the source itself.
    #[arg(long)]
    json: bool,
}

/// Which functions, with the fragment shaders that call them.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq, ValueEnum)]
enum Stage {
    /// From a depth to a texel.
    Encode,
    /// From the depth samples of a pixel to a texel.
    Resolve,
    /// The separable Gaussian of 9 x 9 texels.
    Filter,
    /// From a filtered texel and the depth of a fragment to its shadow.
    Shade,
    /// All of them.
    #[default]
    All,
}

impl Stage {
    fn passes(self) -> &'static [ShadowPass] {
        match self {
            Self::Encode => &[ShadowPass::Encode],
            Self::Resolve => &[ShadowPass::Resolve],
            Self::Filter => &[ShadowPass::Filter],
            Self::Shade => &[ShadowPass::Shade],
            Self::All => &ShadowPass::ALL,
        }
    }

    fn suffix(self) -> String {
        match self {
            Self::All => String::new(),
            Self::Encode | Self::Resolve | Self::Filter | Self::Shade => {
                format!("-{}", self.passes()[0].name())
            }
        }
    }
}

/// A file before it is written.
struct File {
    name: String,
    bytes: Vec<u8>,
}

/// The answer as JSON.
#[derive(Serialize)]
struct Answer<'a> {
    technique: &'a str,
    language: &'static str,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    preset: Option<head::Facts>,
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    source: Option<&'a str>,
}

fn input(problem: String) -> Failure {
    Failure::Input(anyhow!(problem))
}

/// Writes the file.
pub(crate) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let language = arguments.language;
    let (file, facts) = match applications::source(&arguments.technique)? {
        Some(wgsl) => {
            if arguments.format.is_some() || arguments.alpha.is_some() || arguments.stage != Stage::All {
                let name = &arguments.technique;
                return Err(input(format!(
                    "`{name}` is a whole pass: it takes no --format, --alpha or --stage"
                )));
            }
            let bytes =
                language.translated(&wgsl, &wgsl, &head::of_application(&arguments.technique, language)?)?;
            (File { name: format!("{}.{}", arguments.technique, language.extension()), bytes }, None)
        }
        None => {
            let preset = Preset::of(&arguments.technique, arguments.format, arguments.alpha)?;
            (written(&preset, language, arguments.stage)?, Some(preset.facts()))
        }
    };
    let path = arguments.out.as_deref().map(|folder| put(folder, &file)).transpose()?;
    if arguments.json {
        let source = if path.is_none() { std::str::from_utf8(&file.bytes).ok() } else { None };
        if path.is_none() && source.is_none() {
            return Err(input("--language spirv is binary: --json needs --out".to_owned()));
        }
        let answer = Answer {
            technique: &arguments.technique,
            language: language.name(),
            preset: facts,
            file: path.map(|path| path.display().to_string()),
            source,
        };
        let mut text = serde_json::to_vec(&answer).context("formatting the result")?;
        text.push(b'\n');
        return print(&text);
    }
    match path {
        Some(path) => print(format!("{}\n", path.display()).as_bytes()),
        None if language == Language::Spirv && io::stdout().is_terminal() => {
            Err(input("--language spirv is binary: give --out, or redirect standard output".to_owned()))
        }
        None => print(&file.bytes),
    }
}

/// The file of what `msm advise` recommends.
pub(crate) fn write_advised(
    choice: &Choice,
    language: Language,
    candidates: Option<&Path>,
) -> Result<PathBuf, Failure> {
    let preset = Preset::advised(choice, candidates)?;
    put(Path::new(DEFAULT_FOLDER), &written(&preset, language, Stage::All)?)
}

pub(crate) use language::Language as ShaderLanguage;

fn written(preset: &Preset, language: Language, stage: Stage) -> Result<File, Failure> {
    let around =
        Surroundings { kernel: &preset.kernel, samples: SAMPLES, leak_reduction: preset.leak_reduction };
    let whole = preset.technique.standalone(stage.passes(), &around).ok_or_else(|| {
        let name = preset.technique.name();
        match preset.technique.real_time().and_then(RealTime::shader) {
            None => input(format!(
                "{name} has no shader; `msm shader NAME` lists what has one for an unknown name"
            )),
            Some(_) => input(format!("{name} stores more values than eight textures hold")),
        }
    })?;
    // Rust has no textures.
    let functions: Vec<&str> = stage.passes().iter().flat_map(|pass| pass.functions()).copied().collect();
    let pure = reachable(&whole, &functions);
    let name = format!("{}-{}{}.{}", preset.key, preset.format_name(), stage.suffix(), language.extension());
    let bytes = language.translated(
        &whole,
        &pure,
        &head::of_technique(preset, language, stage.suffix().trim_start_matches('-')),
    )?;
    Ok(File { name, bytes })
}

/// Writes a file into a folder, whole or not at all.
fn put(folder: &Path, file: &File) -> Result<PathBuf, Failure> {
    let names = [file.name.replace('/', "-")];
    let staging = Staging::new(folder, &names)?;
    let path = staging.path(&names[0]);
    std::fs::write(&path, &file.bytes).with_context(|| path.display().to_string())?;
    Ok(staging.publish(&names)?.remove(0))
}

fn print(bytes: &[u8]) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => Ok(written.context("standard output")?),
    }
}
