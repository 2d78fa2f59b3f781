//! The tables of a stability experiment's page.

use crate::stability_claims;
use crate::stability_summary::{Inputs, StabilityTables, Total};
use std::fmt::Write as _;

/// All tables as Markdown.
pub(crate) fn markdown(tables: &StabilityTables<'_>) -> String {
    let mut text = String::new();
    for part in [
        stability_claims::table(tables),
        failures(tables),
        alphas(tables),
        checks(tables),
        pivots(tables),
        views(tables),
    ] {
        text.push_str(&part);
        text.push('\n');
    }
    text.push_str(
        "`worst.csv` has the worst input of every method, family and failure as a command line that prints the exact \
         bound without a bias, where 32 digits of the moments suffice; `cells.csv` has the numbers behind the heat maps.\n",
    );
    text
}

/// A count as a share of all, in per cent with two digits.
fn share(count: u64, all: u64) -> String {
    match count {
        0 => "0".to_owned(),
        _ => format!("{} %", two_digits(100.0 * count as f64 / all.max(1) as f64)),
    }
}

pub(crate) fn two_digits(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = (1 - value.abs().log10().floor() as i32).clamp(0, 9) as usize;
    if value.abs() < 1e-3 { format!("{value:.1e}") } else { format!("{value:.digits$}") }
}

fn failures(tables: &StabilityTables<'_>) -> String {
    let mut text = String::from(
        "### Failures at the recommended bias\n\n\
         | method | alpha | time | hard inputs: no number | outside [0, 1] | bound broken | visibly | scenes: bound \
         broken | error, 99.9 % | largest | mean loss |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for method in &tables.experiment.method {
        let hard = tables.recommended(&method.name, Inputs::Hard);
        let scenes = tables.recommended(&method.name, Inputs::Scenes);
        let Total { inputs, not_finite, outside, violated, visible, .. } = hard;
        let time = tables.nanoseconds(&method.name).map_or("-".to_owned(), |ns| format!("{ns:.0} ns"));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {} | {:e} | {time} | {} | {} | {} | {} | {} | {} | {} | {} |",
            method.name,
            method.alpha,
            share(not_finite, inputs),
            share(outside, inputs),
            share(violated, inputs),
            share(visible, inputs),
            share(scenes.violated, scenes.inputs),
            two_digits(scenes.error_999),
            two_digits(scenes.error_max),
            two_digits(scenes.mean_loss),
        );
    }
    text.push_str(
        "\nShares of inputs. *No number*: the formulas end in NaN or infinity. *Outside*: before clamping, by more than \
         1e-6. *Broken*: G > F + alpha + 1e-6 after clamping; *visibly*: by more than 1/255. *Error*: distance from the \
         exact bound of the exact moments with the same bias. *Loss*: what the exact bound without a bias is larger by. \
         Time: median nanoseconds for decoding, bias and bound, one thread, a call at a time; nearer to zero is better \
         everywhere.\n",
    );
    text
}

fn alphas(tables: &StabilityTables<'_>) -> String {
    let mut text = String::from(
        "### Smallest moment bias from which on a failure is gone\n\n\
         | method | recommended | hard: a number everywhere | inside [0, 1] | bound never broken | never visibly | \
         scenes: bound never broken | never visibly |\n|---|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    let shown = |alpha: Option<f64>| match alpha {
        None => "none".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(alpha) => format!("{alpha:.1e}").replace(".0e", "e"),
    };
    for method in &tables.experiment.method {
        let name = &method.name;
        let hard = |count| shown(tables.smallest_alpha(name, Inputs::Hard, count));
        let scenes = |count| shown(tables.smallest_alpha(name, Inputs::Scenes, count));
        let _ = writeln!(
            text,
            "| {name} | {:e} | {} | {} | {} | {} | {} | {} |",
            method.alpha,
            hard(|r| r.not_finite),
            hard(|r| r.outside),
            hard(|r| r.violated),
            hard(|r| r.visible),
            scenes(|r| r.violated),
            scenes(|r| r.visible),
        );
    }
    text.push_str("\nAmong the biases that were tried; none: not even the largest helps.\n");
    text
}

fn checks(tables: &StabilityTables<'_>) -> String {
    let mut names: Vec<&str> = Vec::new();
    for check in &tables.checks {
        if !names.contains(&check.method.as_str()) {
            names.push(&check.method);
        }
    }
    let mut text = String::from(
        "### Many inputs\n\n| method | inputs | no number | outside [0, 1] | bound broken | largest G - F - alpha |\n\
         |---|--:|--:|--:|--:|--:|\n",
    );
    for name in names {
        let of = || tables.checks.iter().filter(|c| c.method == name);
        let _ = writeln!(
            text,
            "| {name} | {} | {} | {} | {} | {} |",
            of().map(|c| c.inputs).sum::<u64>(),
            of().map(|c| c.not_finite).sum::<u64>(),
            of().map(|c| c.outside).sum::<u64>(),
            of().map(|c| c.violated).sum::<u64>(),
            two_digits(of().map(|c| c.largest_excess).fold(0.0, f64::max)),
        );
    }
    text.push_str(
        "\nOur forms without storage at the recommended bias; F is the only thing that they are compared with.\n",
    );
    text
}

fn pivots(tables: &StabilityTables<'_>) -> String {
    let mut text = String::from(
        "### How nearly singular B is\n\n| inputs | moments | smallest pivot below 1e-3 | below 1e-6 | below 1e-9 | \
         median |\n|---|--:|--:|--:|--:|--:|\n",
    );
    for pivot in &tables.pivots {
        let _ = writeln!(
            text,
            "| {} | {} | {:.1} % | {:.1} % | {:.1} % | {} |",
            pivot.family,
            pivot.order,
            100.0 * pivot.below_1e3,
            100.0 * pivot.below_1e6,
            100.0 * pivot.below_1e9,
            two_digits(pivot.median),
        );
    }
    text.push_str("\nB = L D L^T for moments of 2 z - 1, without a bias.\n");
    text
}

fn views(tables: &StabilityTables<'_>) -> String {
    if tables.views.is_empty() {
        return String::new();
    }
    let mut text = String::from("### Views\n\n| view | fragments | evaluated |\n|---|--:|--:|\n");
    for view in &tables.views {
        let _ = writeln!(text, "| {} {} | {} | {} |", view.scene, view.view, view.fragments, view.sampled);
    }
    text
}
