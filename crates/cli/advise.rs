//! `msm advise`: the cheapest filterable shadow map that is good enough for a scene.

use crate::outcome::{Failure, Output};
use crate::progress::Bar;
use crate::shader::{self, ShaderLanguage};
use anyhow::anyhow;
use evaluation::{Advice, AdviceOptions, Choice};
use std::io::{self, Write};
use std::path::PathBuf;

/// Find the cheapest technique, format, bias and map size whose error on a scene is within a tolerance.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// A procedural scene (stairs, village, grove, hall), a .glb, .gltf or .obj file, or a stack of `msm render` (.npz).
    scene: String,
    /// Largest mean distance from percentage-closer filtering that is accepted, between 0 and 1.
    #[arg(long, default_value_t = 0.02, allow_negative_numbers = true)]
    tolerance: f64,
    /// Largest error that is accepted relative to that of calling every fragment lit, between 0 and 1.
    #[arg(long, default_value_t = 0.5, allow_negative_numbers = true)]
    relative: f64,
    /// View of the scene; repeatable. Without it all of them count alike, fragment by fragment.
    #[arg(long = "view", value_name = "NAME")]
    views: Vec<String>,
    /// Side of the shadow map that percentage-closer filtering uses; techniques may use a half or a quarter of it.
    #[arg(long)]
    size: Option<u32>,
    /// Experiment of kind speed-accuracy whose candidates are considered, in place of the built-in ones.
    #[arg(long, value_name = "FILE.toml")]
    candidates: Option<PathBuf>,
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

/// Races, then says what was found.
pub(crate) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let bar = Bar::new("candidates");
    let progress = |done: usize, all: usize| bar.set(done, all);
    let options = AdviceOptions {
        scene: &arguments.scene,
        views: &arguments.views,
        tolerance: arguments.tolerance,
        relative: arguments.relative,
        size: arguments.size,
        seed: arguments.seed,
        candidates: arguments.candidates.as_deref(),
        progress: &progress,
    };
    let advice = Advice::seek_on(&options, arguments.threads)?;
    bar.finish();
    let shader =
        advice.recommendation.as_ref().zip(arguments.shader).map(|(choice, language)| {
            shader::write_advised(choice, language, arguments.candidates.as_deref())
        });
    arguments.output.emit(&advice, |out| {
        write_advice(out, &advice)?;
        match &shader {
            Some(Ok(path)) => writeln!(out, "shader: {}", path.display()),
            Some(Err(_)) | None => Ok(()),
        }
    })?;
    shader.transpose()?;
    if advice.recommendation.is_none() {
        return Err(Failure::Input(refusal(&advice)));
    }
    Ok(())
}

/// Why nothing is recommended.
fn refusal(advice: &Advice) -> anyhow::Error {
    let Advice { scene, nothing, tolerance, relative, .. } = advice;
    let map = map(advice);
    let Some(best) = advice.next_better.as_ref().map(describe) else {
        return anyhow!(
            "nothing on `{scene}` is in shadow on {map}: all {} fragments are lit, and no technique does better than \
             no shadows at all",
            advice.fragments
        );
    };
    anyhow!(
        "tolerance {tolerance} and {relative} of doing nothing, which errs by {}: nothing meets it on `{scene}` on \
         {map}; the best is {best}",
        fraction(nothing.l1_error)
    )
}

/// Four digits behind the point, or two digits of what these do not show.
fn fraction(value: f64) -> String {
    /// Ten units of the last digit behind the point.
    const SMALL: f64 = 1e-3;
    if value == 0.0 || value >= SMALL { format!("{value:.4}") } else { format!("{value:.1e}") }
}

/// The reference's map, with the size of what it can show.
fn map(advice: &Advice) -> String {
    let size = advice.reference_size;
    let texel = advice.nothing.texel_side.map(|side| format!(" with texels of {side:.3} units"));
    format!("a {size}x{size} map{}", texel.unwrap_or_default())
}

fn write_advice(out: &mut dyn Write, advice: &Advice) -> io::Result<()> {
    writeln!(
        out,
        "{}, {} view{}, {} fragments, {:.3} % of them in shadow; reference: PCF on {}, tolerance {}",
        advice.scene,
        advice.views.len(),
        if advice.views.len() == 1 { "" } else { "s" },
        advice.fragments,
        100.0 * advice.nothing.shadowed_share,
        map(advice),
        advice.tolerance,
    )?;
    writeln!(out)?;
    writeln!(out, "                 error   interval           relative   cost    map")?;
    let nothing = fraction(advice.nothing.l1_error);
    writeln!(
        out,
        "do nothing     {nothing:>7}   {nothing:>6} to {nothing:>6}      1.000   0.000    0.00 MiB  every fragment is lit"
    )?;
    let sought = advice.recommendation.is_some();
    for (title, choice, none) in [
        ("use", &advice.recommendation, "none meets the tolerance and is clearly better than doing nothing"),
        ("next cheaper", &advice.next_cheaper, if sought { "none is cheaper" } else { "not sought" }),
        ("next better", &advice.next_better, "none of the costlier ones erred less"),
    ] {
        match choice {
            Some(choice) => write_choice(out, title, choice)?,
            None => writeln!(out, "{title:<14}  {none}")?,
        }
    }
    writeln!(out)?;
    writeln!(
        out,
        "error: mean distance from PCF, lower is better; all intervals hold with probability {}",
        advice.confidence
    )?;
    if let (Some(used), Some(better)) = (&advice.recommendation, &advice.next_better)
        && better.l1_error_high >= used.l1_error_low
    {
        writeln!(
            out,
            "next better: by the fragments seen; its interval and that of the recommended one overlap"
        )?;
    }
    writeln!(
        out,
        "relative: error over that of doing nothing, which ground in the light does not dilute; at most {} is recommended",
        advice.relative
    )?;
    writeln!(out, "cost: modelled memory traffic and arithmetic of a frame, VSM in f32 at full size is 1")?;
    writeln!(
        out,
        "raced {} combinations with {:.1} % of the work of evaluating all on all fragments",
        advice.candidates,
        100.0 * advice.evaluated_share
    )?;
    write_needs(out, advice)
}

fn write_choice(out: &mut dyn Write, title: &str, choice: &Choice) -> io::Result<()> {
    writeln!(
        out,
        "{title:<14} {:>7}   {:>6} to {:>6}   {:>8.3}  {:>6.3}  {:>6.2} MiB  {}",
        fraction(choice.l1_error),
        fraction(choice.l1_error_low),
        fraction(choice.l1_error_high),
        choice.relative_error,
        choice.cost,
        choice.map_bytes as f64 / f64::from(1 << 20),
        name(choice),
    )
}

fn name(choice: &Choice) -> String {
    let alpha = choice.alpha.map(|alpha| format!(", alpha {alpha:e}")).unwrap_or_default();
    let mut blend = String::new();
    if choice.beta > 0.0 {
        blend += &format!(", beta {}", choice.beta);
    }
    if choice.leak_reduction > 0.0 {
        blend += &format!(", leak reduction {}", choice.leak_reduction);
    }
    format!(
        "{} in {}{alpha}, {size}x{size}, kernel {kernel}x{kernel}, bias {} texels + {} slopes{blend}",
        choice.technique,
        choice.format,
        choice.bias_texels,
        choice.bias_slopes,
        size = choice.size,
        kernel = choice.kernel_size,
    )
}

/// For one line.
fn describe(choice: &Choice) -> String {
    format!(
        "{} with {} ({} to {}), {:.2} of doing nothing",
        name(choice),
        fraction(choice.l1_error),
        fraction(choice.l1_error_low),
        fraction(choice.l1_error_high),
        choice.relative_error
    )
}

/// Shares over all views, each view counting alike.
fn write_needs(out: &mut dyn Write, advice: &Advice) -> io::Result<()> {
    let shares = || advice.needs.iter();
    let mut groups: Vec<(&str, f64)> = Vec::new();
    for share in shares() {
        if !groups.contains(&(share.by.as_str(), share.tolerance)) {
            groups.push((&share.by, share.tolerance));
        }
    }
    writeln!(out)?;
    for (by, tolerance) in groups {
        let mut totals: Vec<(&str, f64)> = Vec::new();
        for share in shares().filter(|share| share.by == by && share.tolerance == tolerance) {
            match totals.iter_mut().find(|(needs, _)| *needs == share.needs) {
                Some((_, total)) => *total += share.share,
                None => totals.push((&share.needs, share.share)),
            }
        }
        let views = advice.views.len().max(1) as f64;
        let list: Vec<String> =
            totals.iter().map(|(needs, total)| format!("{needs}: {:.0} %", 100.0 * total / views)).collect();
        let what = match by {
            "rank" => format!("surfaces in a kernel (rank at {tolerance:e})"),
            "gap" => format!("moments for bounds closer than {tolerance}"),
            _ => format!("moments that lose less than {tolerance} to PCF"),
        };
        writeln!(out, "{what:<40} {}", list.join(", "))?;
    }
    Ok(())
}
