//! `msm advise`: the cheapest shadow maps that are good enough for a scene.

mod applications;
mod text;

use crate::outcome::{Failure, Output};
use crate::progress::Bar;
use crate::shader::{self, ShaderLanguage};
use crate::staging::Staging;
use anyhow::anyhow;
use evaluation::{
    Advice, AdviceOptions, Answer, BANDWIDTH, Budget, KernelSpec, Lighting, Measured, MediumSetting,
    RecordedFile,
};
use scenes::AreaLight;
use std::path::{Path, PathBuf};

/// Find the cheapest technique, format, bias and map size whose error on a scene is within a tolerance.
///
/// Hard shadows are always answered; soft shadows where a light has some size, translucent
/// casters where light passes through something. Exit code 3 where nothing meets the tolerance.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// A procedural scene (stairs, village, grove, hall, smoke, glasshouse), a .glb, .gltf or .obj file, or a stack of `msm render` (.npz).
    #[arg(value_parser = crate::scene_name())]
    scene: String,
    /// Largest mean error that is accepted, between 0 and 1. Without it 1.25 times what the most accurate technique reaches,
    /// one step of an 8-bit display at least.
    #[arg(long, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Largest error that is accepted relative to that of calling every fragment lit, between 0 and 1.
    #[arg(long, default_value_t = 0.5, allow_negative_numbers = true)]
    relative: f64,
    /// Most milliseconds of a frame, as modelled for a card of --bandwidth. With a budget and no tolerance the most accurate
    /// within it is recommended.
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    budget_ms: Option<f64>,
    /// Most bytes of the filtered map or table.
    #[arg(long, value_name = "BYTES")]
    budget_bytes: Option<u64>,
    /// Memory traffic of the card in GB/s, by which modelled costs become milliseconds; that of a GTX 780 without.
    #[arg(long, value_name = "GB/S", default_value_t = BANDWIDTH, allow_negative_numbers = true)]
    bandwidth: f64,
    /// View of the scene by name, or a direction in which light travels; repeatable. Without it all views count alike whose
    /// light has no extent, fragment by fragment.
    #[arg(long = "view", value_name = "NAME|X,Y,Z", allow_hyphen_values = true)]
    view: Vec<String>,
    /// Light views in place of the scene's own: a TOML file of `view` tables with name, direction and light.
    #[arg(long, value_name = "FILE.toml")]
    views: Option<PathBuf>,
    /// A light of some size in place of the views': sun:DEGREES or sun:AxB along each view, or in space rect:CENTRE;U;V or
    /// disc:CENTRE;U;V with the half axes U and V, shining along U x V; vectors are x,y,z.
    #[arg(long, value_name = "LIGHT", allow_hyphen_values = true)]
    light: Option<AreaLight>,
    /// Side of the shadow map that percentage-closer filtering uses; techniques may use a half or a quarter of it.
    #[arg(long)]
    size: Option<u32>,
    /// Filter of hard shadows: gaussian:SIZE:SIGMA, box:SIZE or binomial:SIZE, in texels of a map of full size. Without it
    /// that of the candidates' experiment, gaussian:9:2.4.
    #[arg(long, value_name = "KERNEL")]
    kernel: Option<KernelSpec>,
    /// A medium that scatters light: its extinction over half the diagonal of the scene, and if they are not 0.9 and 0.3, its
    /// albedo and the g of Henyey and Greenstein.
    #[arg(long, value_name = "EXTINCTION[,ALBEDO[,G]]", value_parser = parse_medium, allow_hyphen_values = true)]
    medium: Option<MediumSetting>,
    /// Time every candidate's frame on this machine's graphics processor, in place of modelled costs of hard shadows; all other
    /// costs are calibrated by it. Without a graphics processor costs stay modelled, and the answer says so.
    #[arg(long)]
    gpu: bool,
    /// Experiment of kind speed-accuracy whose candidates are considered, in place of the built-in ones.
    #[arg(long, value_name = "FILE.toml")]
    candidates: Option<PathBuf>,
    /// Folder for pictures of the first view at 1920x1080: reference, recommended, next cheaper, differences, and all of them
    /// with the worst parts magnified.
    #[arg(long, value_name = "DIR")]
    picture: Option<PathBuf>,
    /// Seed of the sample.
    #[arg(long)]
    seed: Option<u64>,
    /// Worker threads; without this one per logical core. The answer does not depend on it.
    #[arg(long)]
    threads: Option<usize>,
    /// Also write the recommended technique as a shader in this language, into out/.
    #[arg(long, value_enum, value_name = "LANGUAGE")]
    shader: Option<ShaderLanguage>,
    #[command(flatten)]
    output: Output,
}

/// As in the experiment `single-scattering`.
const ALBEDO: f64 = 0.9;
const ANISOTROPY: f64 = 0.3;

fn parse_medium(text: &str) -> Result<MediumSetting, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse::<f64>()).collect();
    let (extinction, albedo, anisotropy) = match numbers.as_deref() {
        Ok(&[extinction]) => (extinction, ALBEDO, ANISOTROPY),
        Ok(&[extinction, albedo]) => (extinction, albedo, ANISOTROPY),
        Ok(&[extinction, albedo, anisotropy]) => (extinction, albedo, anisotropy),
        Ok(_) | Err(_) => return Err("expected EXTINCTION[,ALBEDO[,G]]".to_owned()),
    };
    Ok(MediumSetting { extinction, albedo, anisotropy })
}

/// Races, then says what was found.
pub(crate) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let folders = [
        ("--picture", arguments.picture.as_deref()),
        ("--shader", arguments.shader.map(|_| Path::new(shader::DEFAULT_FOLDER))),
    ];
    for (option, folder) in folders {
        if let Some(folder) = folder.filter(|folder| folder.exists() && !folder.is_dir()) {
            return Err(Failure::Input(anyhow!("{option}: {} is no folder", folder.display())));
        }
    }
    let bar = Bar::new("candidates");
    let progress = |done: usize, all: usize| bar.set(done, all);
    let options = AdviceOptions {
        scene: &arguments.scene,
        lighting: Lighting {
            views: arguments.view.clone(),
            file: arguments.views.clone(),
            light: arguments.light,
        },
        tolerance: arguments.tolerance,
        relative: arguments.relative,
        budget: Budget {
            milliseconds: arguments.budget_ms,
            bytes: arguments.budget_bytes,
            bandwidth: arguments.bandwidth,
        },
        size: arguments.size,
        kernel: arguments.kernel,
        seed: arguments.seed,
        candidates: arguments.candidates.as_deref(),
        medium: arguments.medium,
        gpu: arguments.gpu,
        pictures: arguments.picture.is_some(),
        progress: &progress,
    };
    let (advice, pictures) = Advice::seek_on(&options, crate::threads::capped(arguments.threads))?;
    bar.finish();
    let drawn = match &arguments.picture {
        Some(folder) => publish(folder, &pictures)?,
        None => Vec::new(),
    };
    let shader =
        advice.hard.recommendation.as_ref().zip(arguments.shader).map(|(choice, language)| {
            shader::write_advised(choice, language, arguments.candidates.as_deref())
        });
    arguments.output.emit(&advice, |out| {
        text::write(out, &advice, &drawn)?;
        match &shader {
            Some(Ok(path)) => writeln!(out, "shader: {}", path.display()),
            Some(Err(_)) | None => Ok(()),
        }
    })?;
    shader.transpose()?;
    refused(&advice)
}

/// Writes the pictures, all or none; their paths.
fn publish(folder: &Path, pictures: &[RecordedFile]) -> Result<Vec<PathBuf>, Failure> {
    if pictures.is_empty() {
        return Ok(Vec::new());
    }
    let names: Vec<String> = pictures.iter().map(|file| file.name.clone()).collect();
    let staging = Staging::new(folder, &names)?;
    for file in pictures {
        evaluation::write_whole(&staging.path(&file.name), &file.bytes)?;
    }
    Ok(staging.publish(&names)?)
}

/// Why nothing is recommended, if nothing is.
fn refused(advice: &Advice) -> Result<(), Failure> {
    if advice.nothing.shadowed_share == 0.0 {
        return Err(Failure::Input(anyhow!(
            "nothing on `{}` is in shadow on {}: all {} fragments are lit, and no technique does better than no shadows at \
             all",
            advice.scene,
            text::map(advice),
            advice.fragments
        )));
    }
    let hard = &advice.hard;
    if hard.recommendation.is_none() {
        let best = hard.next_better.as_ref().map(text::describe).unwrap_or_default();
        return Err(Failure::Unmet(anyhow!(
            "{}: nothing meets it on `{}` on {}; the best is {best}",
            limits(hard, advice.nothing.l1_error),
            advice.scene,
            text::map(advice),
        )));
    }
    if let Some(soft) = &advice.soft_shadows {
        let name = |choice: &_| (applications::soft_name(choice), choice.error);
        met(advice, ("soft shadows", soft.nothing.l1_error), &soft.answer, name)?;
    }
    if let Some(scattering) = &advice.scattering {
        let name = |choice: &_| (applications::scattering_name(choice), choice.error);
        met(advice, ("single scattering", scattering.nothing), &scattering.answer, name)?;
    }
    if let Some(casters) = &advice.translucent_casters {
        let name = |choice: &_| (applications::translucent_name(choice), choice.error);
        met(advice, ("translucent casters", casters.nothing), &casters.answer, name)?;
    }
    Ok(())
}

/// Complains where an application other than hard shadows has something to do and no way to do it.
fn met<C>(
    advice: &Advice,
    (application, nothing): (&str, f64),
    answer: &Answer<C>,
    name: impl Fn(&C) -> (String, Measured),
) -> Result<(), Failure> {
    let (None, Some(best)) = (&answer.recommendation, &answer.next_better) else { return Ok(()) };
    let (name, error) = name(best);
    Err(Failure::Unmet(anyhow!(
        "{application}: {}: nothing meets it on `{}`; the best is {name} with {}",
        limits(answer, nothing),
        advice.scene,
        text::interval(&error)
    )))
}

/// What was asked, and what would be met.
fn limits<C>(answer: &Answer<C>, nothing: f64) -> String {
    let reachable = answer.reachable.unwrap_or(1.0);
    // Rounded up, so that what is said is met.
    let met = (reachable * 1e4).ceil() / 1e4;
    let would = if reachable <= answer.relative * nothing {
        format!("--tolerance {met} would be met")
    } else {
        format!("no technique errs by less than {} of doing nothing", answer.relative)
    };
    format!(
        "tolerance {} and {} of doing nothing, which errs by {} ({would})",
        text::fraction(answer.tolerance),
        answer.relative,
        text::fraction(nothing)
    )
}
