//! The answer of `msm advise` for people.

use super::applications;
use evaluation::{Advice, Answer, BiasInView, Choice, CostSource, Measured};
use std::io::{self, Write};
use std::path::PathBuf;

/// Four digits behind the point, or two digits of what these do not show.
pub(super) fn fraction(value: f64) -> String {
    /// Ten units of the last digit behind the point.
    const SMALL: f64 = 1e-3;
    if value == 0.0 || value >= SMALL { format!("{value:.4}") } else { format!("{value:.1e}") }
}

/// The reference's map, with the size of what it can show.
pub(super) fn map(advice: &Advice) -> String {
    let size = advice.reference_size;
    let texel = advice.nothing.texel_side.map(|side| format!(" with texels of {side:.3} units"));
    format!("a {size}x{size} map{}", texel.unwrap_or_default())
}

/// An error with its interval and share of doing nothing.
pub(super) fn interval(error: &Measured) -> String {
    format!(
        "{} ({} to {}), {:.2} of doing nothing",
        fraction(error.l1_error),
        fraction(error.l1_error_low),
        fraction(error.l1_error_high),
        error.relative_error
    )
}

pub(super) fn blend(beta: f64, leak_reduction: f64) -> String {
    let mut blend = String::new();
    if beta > 0.0 {
        blend += &format!(", beta {beta}");
    }
    if leak_reduction > 0.0 {
        blend += &format!(", leak reduction {leak_reduction}");
    }
    blend
}

fn name(choice: &Choice) -> String {
    let alpha = choice.alpha.map(|alpha| format!(", alpha {alpha:e}")).unwrap_or_default();
    format!(
        "{} in {}{alpha}, {size}x{size}, kernel {kernel}x{kernel}, bias {} texels + {} slopes{}",
        choice.technique,
        choice.format,
        choice.bias_texels,
        choice.bias_slopes,
        blend(choice.beta, choice.leak_reduction),
        size = choice.size,
        kernel = choice.kernel_size,
    )
}

/// For one line.
pub(super) fn describe(choice: &Choice) -> String {
    format!("{} with {}", name(choice), interval(&choice.error))
}

/// Everything.
pub(super) fn write(out: &mut dyn Write, advice: &Advice, drawn: &[PathBuf]) -> io::Result<()> {
    writeln!(
        out,
        "{}, {} view{}, {} fragments, {:.3} % of them in shadow; reference: PCF on {}, {}, {}",
        advice.scene,
        advice.views.len(),
        if advice.views.len() == 1 { "" } else { "s" },
        advice.fragments,
        100.0 * advice.nothing.shadowed_share,
        map(advice),
        advice.reference.kernel,
        tolerance(&advice.hard),
    )?;
    writeln!(out)?;
    heading(out)?;
    nothing(out, advice.nothing.l1_error)?;
    let row = |choice: &Choice| (choice.error, choice.cost, choice.cost_ms, choice.map_bytes, name(choice));
    rows(out, &advice.hard, row)?;
    writeln!(out)?;
    writeln!(
        out,
        "error: mean distance from PCF, lower is better; all intervals hold with probability {}",
        advice.confidence
    )?;
    notes(out, &advice.hard, |choice| choice.error)?;
    writeln!(
        out,
        "relative: error over that of doing nothing, which ground in the light does not dilute; at most {} is recommended",
        advice.hard.relative
    )?;
    writeln!(
        out,
        "cost: modelled memory traffic and arithmetic of a frame, VSM in f32 at full size is 1; ms on a card of the bandwidth given"
    )?;
    costs(out, advice)?;
    raced(out, &advice.hard, "all fragments")?;
    advice.left_out.iter().try_for_each(|what| writeln!(out, "left out: {what}"))?;
    if let Some(choice) = &advice.hard.recommendation {
        implementation(out, advice, choice)?;
    }
    match &advice.soft_shadows {
        Some(soft) => applications::soft_shadows(out, soft)?,
        None => writeln!(out, "\nsoft shadows: no light has an extent; --light sun:0.53 asks for the sun's")?,
    }
    if let Some(scattering) = &advice.scattering {
        applications::scattering(out, scattering)?;
    }
    if let Some(casters) = &advice.translucent_casters {
        applications::translucent_casters(out, casters)?;
    }
    if let Some(together) = &advice.together {
        applications::together(out, together)?;
    }
    if !drawn.is_empty() {
        writeln!(out)?;
        drawn.iter().try_for_each(|path| writeln!(out, "  {}", path.display()))?;
    }
    needs(out, advice)
}

pub(super) fn tolerance<C>(answer: &Answer<C>) -> String {
    let given = if answer.tolerance_is_given { "" } else { " (1.25 times what the best reaches)" };
    format!("tolerance {}{given}", fraction(answer.tolerance))
}

pub(super) fn heading(out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "                 error   interval           relative    cost        ms       map")
}

pub(super) fn nothing(out: &mut dyn Write, error: f64) -> io::Result<()> {
    let error = fraction(error);
    writeln!(
        out,
        "do nothing     {error:>7}   {error:>6} to {error:>6}      1.000    0.000    0.000    0.00 MiB  everything is lit"
    )
}

pub(super) type Row = (Measured, f64, f64, u64, String);

pub(super) fn rows<C>(out: &mut dyn Write, answer: &Answer<C>, row: impl Fn(&C) -> Row) -> io::Result<()> {
    let mut line = |title: &str, choice: &C| {
        let (error, cost, milliseconds, bytes, name) = row(choice);
        writeln!(
            out,
            "{title:<14} {:>7}   {:>6} to {:>6}   {:>8.3}  {cost:>7.3}  {milliseconds:>7.3}  {:>6.2} MiB  {name}",
            fraction(error.l1_error),
            fraction(error.l1_error_low),
            fraction(error.l1_error_high),
            error.relative_error,
            bytes as f64 / f64::from(1 << 20),
        )
    };
    let mut missing = Vec::new();
    let sought = answer.recommendation.is_some();
    for (title, choice, none) in [
        ("use", &answer.recommendation, "none meets the tolerance and is clearly better than doing nothing"),
        ("next cheaper", &answer.next_cheaper, if sought { "none is cheaper" } else { "not sought" }),
        ("next better", &answer.next_better, "none of the costlier ones erred less"),
    ] {
        match choice {
            Some(choice) => line(title, choice)?,
            None => missing.push(format!("{title:<14}  {none}")),
        }
    }
    for choice in &answer.near_ties {
        let is_within = row(choice).0.l1_error_high <= answer.tolerance;
        line(if is_within { "near tie" } else { "near, beyond" }, choice)?;
    }
    for choice in &answer.undecided {
        line("undecided", choice)?;
    }
    missing.iter().try_for_each(|line| writeln!(out, "{line}"))
}

pub(super) fn notes<C>(
    out: &mut dyn Write,
    answer: &Answer<C>,
    error: impl Fn(&C) -> Measured,
) -> io::Result<()> {
    if let (Some(used), Some(better)) = (&answer.recommendation, &answer.next_better)
        && error(better).l1_error_high >= error(used).l1_error_low
    {
        writeln!(
            out,
            "next better: by the fragments seen; its interval and that of the recommended one overlap"
        )?;
    }
    if !answer.near_ties.is_empty() {
        writeln!(
            out,
            "near tie: errors within a tenth and costs within a quarter of the recommended one, some beyond the tolerance; measure on your \
             card"
        )?;
    }
    if !answer.undecided.is_empty() {
        writeln!(out, "undecided: cheaper, and neither within the tolerance nor beyond it for certain")?;
    }
    Ok(())
}

pub(super) fn raced<C>(out: &mut dyn Write, answer: &Answer<C>, all: &str) -> io::Result<()> {
    writeln!(
        out,
        "raced {} combinations with {:.1} % of the work of evaluating all on {all}",
        answer.candidates,
        100.0 * answer.evaluated_share
    )
}

/// Where costs come from, where times were asked for.
fn costs(out: &mut dyn Write, advice: &Advice) -> io::Result<()> {
    let CostSource { source, adapter, measured, unit_ms, model_factor } = &advice.costs;
    match (unit_ms, model_factor) {
        (Some(unit), Some([most, all])) => writeln!(
            out,
            "costs: {source} on {adapter} for {measured} combinations of technique, format and size, 1 is {unit:.3} ms; the model is \
             within a factor of {most:.2} of two thirds of them and of {all:.2} of all"
        ),
        (_, _) if adapter.is_empty() => Ok(()),
        (_, _) => writeln!(out, "costs: {source}: {adapter}"),
    }
}

/// What has to be built.
fn implementation(out: &mut dyn Write, advice: &Advice, choice: &Choice) -> io::Result<()> {
    let shipping = &choice.shipping;
    writeln!(out, "\nto implement it")?;
    writeln!(
        out,
        "  store          {} in {}, {} bits a texel",
        shipping.functions, choice.format, choice.bits_per_texel
    )?;
    writeln!(
        out,
        "  transform      {}: a texel holds T b + offset{}",
        choice.transform,
        if choice.transform == "identity" { ", T = 1, offset = 0" } else { "" }
    )?;
    if choice.transform != "identity" {
        for (row, offset) in shipping.matrix.iter().zip(&shipping.offset) {
            let row: Vec<String> = row.iter().map(|value| format!("{value:>14.10}")).collect();
            writeln!(out, "                 [{}]   {offset:>14.10}", row.join(" "))?;
        }
    }
    writeln!(
        out,
        "  filter         {}x{} texels, separable: {}",
        choice.kernel_size,
        choice.kernel_size,
        list(&shipping.kernel)
    )?;
    if let Some(alpha) = choice.alpha {
        writeln!(out, "  moment bias    alpha {alpha:e}: {}", advice.definitions.alpha)?;
        writeln!(out, "                 b* = ({})", list(&shipping.centre))?;
    }
    depth_bias(out, (choice.bias_texels, choice.bias_slopes), &shipping.depth_bias)?;
    writeln!(out, "                 {}", advice.definitions.bias_texels)?;
    writeln!(out, "                 {}", advice.definitions.bias_slopes)?;
    writeln!(
        out,
        "  shadow         {}, beta {}, leak reduction {}",
        advice.definitions.shadow, choice.beta, choice.leak_reduction
    )?;
    writeln!(out, "  error          {}", advice.definitions.error)?;
    writeln!(
        out,
        "  reference      {} with a bias of {} texels + {} slopes beside the receiver's plane",
        advice.reference.kernel, advice.reference.bias.texels, advice.reference.bias.slopes
    )
}

fn list(values: &[f64]) -> String {
    values.iter().map(|value| format!("{value:.6}")).collect::<Vec<_>>().join(", ")
}

pub(super) fn depth_bias(
    out: &mut dyn Write,
    (texels, slopes): (f64, f64),
    views: &[BiasInView],
) -> io::Result<()> {
    writeln!(out, "  depth bias     {texels} texels + {slopes} slopes")?;
    for bias in views {
        let world = match (bias.world, bias.texel_side) {
            (Some(world), Some(side)) => {
                format!(", {world:.6} world units; a texel is {side:.6} units wide")
            }
            (_, _) => String::new(),
        };
        writeln!(out, "                 {}: {:.3e} of the depth range{world}", bias.view, bias.depth)?;
    }
    Ok(())
}

/// Shares over all views, each view counting alike.
fn needs(out: &mut dyn Write, advice: &Advice) -> io::Result<()> {
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
