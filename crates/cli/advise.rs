//! `msm advise`: the cheapest filterable shadow map that is good enough for a scene.

use crate::outcome::{Failure, Output};
use crate::progress::Bar;
use anyhow::anyhow;
use evaluation::{Advice, AdviceOptions, Choice};
use std::io::{self, Write};
use std::path::PathBuf;

/// Find the cheapest technique, format, bias and map size whose error on a scene is within a tolerance.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// A procedural scene (stairs, village, grove), a .glb, .gltf or .obj file, or a stack of `msm render` (.npz).
    scene: String,
    /// Largest mean distance from percentage-closer filtering that is accepted, between 0 and 1.
    #[arg(long, default_value_t = 0.02, allow_negative_numbers = true)]
    tolerance: f64,
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
        size: arguments.size,
        seed: arguments.seed,
        candidates: arguments.candidates.as_deref(),
        progress: &progress,
    };
    let advice = Advice::seek_on(&options, arguments.threads)?;
    bar.finish();
    arguments.output.emit(&advice, |out| write_advice(out, &advice))?;
    if advice.recommendation.is_none() {
        let best = advice.next_better.as_ref().map(describe).unwrap_or_default();
        return Err(Failure::Input(anyhow!(
            "tolerance {}: nothing meets it on `{}`; the best is {best}",
            advice.tolerance,
            advice.scene
        )));
    }
    Ok(())
}

fn write_advice(out: &mut dyn Write, advice: &Advice) -> io::Result<()> {
    writeln!(
        out,
        "{}, {} view{}, {} fragments; reference: PCF on a {size}x{size} map, tolerance {}",
        advice.scene,
        advice.views.len(),
        if advice.views.len() == 1 { "" } else { "s" },
        advice.fragments,
        advice.tolerance,
        size = advice.reference_size,
    )?;
    writeln!(out)?;
    writeln!(out, "                 error   interval           cost    map")?;
    let sought = advice.recommendation.is_some();
    for (title, choice, none) in [
        ("use", &advice.recommendation, "none meets the tolerance"),
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
        "{title:<14} {:>7.4}   {:.4} to {:.4}  {:>6.3}  {:>6.2} MiB  {}",
        choice.l1_error,
        choice.l1_error_low,
        choice.l1_error_high,
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
        "{} with {:.4} ({:.4} to {:.4})",
        name(choice),
        choice.l1_error,
        choice.l1_error_low,
        choice.l1_error_high
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
