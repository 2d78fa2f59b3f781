//! The tables of a stability experiment, each with a note on how to read it.

use super::summary::{Inputs, StabilityTables, Total};
use crate::kinds::rows::distinct;
use crate::page::{Block, Table, Text, code, percent, row};
use evaluation::{PivotRecord, StabilityMethod, StabilityViewRecord};

pub(crate) fn blocks(tables: &StabilityTables<'_>) -> Vec<Block> {
    let files = code("worst.csv")
        .and(
            " has the worst input of every method, family and failure as a command line that prints the exact \
             bound without a bias, where 32 digits of the moments suffice; ",
        )
        .code("cells.csv")
        .and(" has the numbers behind the heat maps.");
    [
        failures(tables),
        alphas(tables),
        checks(tables),
        pivots(tables),
        views(tables),
        vec![Block::Paragraph(files)],
    ]
    .concat()
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

fn failures(tables: &StabilityTables<'_>) -> Vec<Block> {
    let cells = |method: &StabilityMethod| {
        let hard = tables.recommended(&method.name, Inputs::Hard);
        let scenes = tables.recommended(&method.name, Inputs::Scenes);
        let Total { inputs, not_finite, outside, violated, visible, .. } = hard;
        row![
            &method.name,
            format!("{:e}", method.alpha()),
            tables.nanoseconds(&method.name).map(|ns| format!("{ns:.0} ns")),
            share(not_finite, inputs),
            share(outside, inputs),
            share(violated, inputs),
            share(visible, inputs),
            share(scenes.violated, scenes.inputs),
            two_digits(scenes.error_999),
            two_digits(scenes.error_max),
            two_digits(scenes.mean_loss),
        ]
    };
    let table = Table::default()
        .left(["method"])
        .right(["alpha", "time", "hard inputs: no number", "outside [0, 1]", "bound broken", "visibly"])
        .right(["scenes: bound broken", "error, 99.9 %", "largest", "mean loss"])
        .rows(tables.experiment.technique.iter().map(cells));
    let note = Text::from("Shares of inputs. ")
        .emphasis("No number")
        .and(": the formulas end in NaN or infinity. ")
        .emphasis("Outside")
        .and(": before clamping, by more than 1e-6. ")
        .emphasis("Broken")
        .and(": G > F + alpha + 1e-6 after clamping; ")
        .emphasis("visibly")
        .and(": by more than 1/255. ")
        .emphasis("Error")
        .and(": distance from the exact bound of the exact moments with the same bias. ")
        .emphasis("Loss")
        .and(
            ": what the exact bound without a bias is larger by. Time: median nanoseconds for decoding, bias and bound, \
             one thread, a call at a time; nearer to zero is better everywhere.",
        );
    Block::section(3, "Failures at the recommended bias", table, Some(note))
}

fn alphas(tables: &StabilityTables<'_>) -> Vec<Block> {
    let shown = |alpha: Option<f64>| match alpha {
        None => "none".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(alpha) => format!("{alpha:.1e}").replace(".0e", "e"),
    };
    let cells = |method: &StabilityMethod| {
        let hard = |count| shown(tables.smallest_alpha(&method.name, Inputs::Hard, count));
        let scenes = |count| shown(tables.smallest_alpha(&method.name, Inputs::Scenes, count));
        row![
            &method.name,
            format!("{:e}", method.alpha()),
            hard(|r| r.not_finite),
            hard(|r| r.outside),
            hard(|r| r.violated),
            hard(|r| r.visible),
            scenes(|r| r.violated),
            scenes(|r| r.visible),
        ]
    };
    let table = Table::default()
        .left(["method"])
        .right(["recommended", "hard: a number everywhere", "inside [0, 1]", "bound never broken"])
        .right(["never visibly", "scenes: bound never broken", "never visibly"])
        .rows(tables.experiment.technique.iter().map(cells));
    let note = Text::from("Among the biases that were tried; none: not even the largest helps.");
    Block::section(3, "Smallest moment bias from which on a failure is gone", table, Some(note))
}

fn checks(tables: &StabilityTables<'_>) -> Vec<Block> {
    let methods = distinct(tables.checks.iter().map(|check| check.method.as_str()));
    let cells = |name| {
        let of = || tables.checks.iter().filter(move |c| c.method == name);
        row![
            name,
            of().map(|c| c.inputs).sum::<u64>(),
            of().map(|c| c.not_finite).sum::<u64>(),
            of().map(|c| c.outside).sum::<u64>(),
            of().map(|c| c.violated).sum::<u64>(),
            two_digits(of().map(|c| c.largest_excess).fold(0.0, f64::max)),
        ]
    };
    let table = Table::default()
        .left(["method"])
        .right(["inputs", "no number", "outside [0, 1]", "bound broken", "largest G - F - alpha"])
        .rows(methods.into_iter().map(cells));
    let note = Text::from(
        "Our forms without storage at the recommended bias; F is the only thing that they are compared with.",
    );
    Block::section(3, "Many inputs", table, Some(note))
}

fn pivots(tables: &StabilityTables<'_>) -> Vec<Block> {
    let cells = |p: &PivotRecord| {
        let below = [p.below_1e3, p.below_1e6, p.below_1e9].map(|share| percent(share, 1).into());
        [row![&p.family, p.order], below.to_vec(), row![two_digits(p.median)]].concat()
    };
    let table = Table::default()
        .left(["inputs"])
        .right(["moments", "smallest pivot below 1e-3", "below 1e-6", "below 1e-9", "median"])
        .rows(tables.pivots.iter().map(cells));
    let note = Text::from("B = L D L^T for moments of 2 z - 1, without a bias.");
    Block::section(3, "How nearly singular B is", table, Some(note))
}

fn views(tables: &StabilityTables<'_>) -> Vec<Block> {
    let cells = |v: &StabilityViewRecord| row![format!("{} {}", v.scene, v.view), v.fragments, v.sampled];
    let table = Table::default()
        .left(["view"])
        .right(["fragments", "evaluated"])
        .rows(tables.views.iter().map(cells));
    Block::section(3, "Views", table, None)
}
