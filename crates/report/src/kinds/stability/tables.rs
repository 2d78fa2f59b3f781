//! The tables of a stability experiment, each with a note on how to read it.

use super::summary::{Count, Inputs, StabilityTables};
use crate::kinds::rows::distinct;
use crate::kinds::rows::views;
use crate::page::{Block, Table, Text, code, percent};
use evaluation::{CheckRecord, StabilityMethod};

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
        views(3, &tables.views),
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
    let rows: Vec<_> = tables
        .experiment
        .technique
        .iter()
        .map(|m| (m, tables.recommended(&m.name, Inputs::Hard), tables.recommended(&m.name, Inputs::Scenes)))
        .collect();
    let table = Table::of(&rows)
        .left("method", |(m, ..)| &m.name)
        .right("alpha", |(m, ..)| format!("{:e}", m.alpha()))
        .right("time", |(m, ..)| tables.nanoseconds(&m.name).map(|ns| format!("{ns:.0} ns")))
        .right("hard inputs: no number", |(_, hard, _)| share(hard.not_finite, hard.inputs))
        .right("outside [0, 1]", |(_, hard, _)| share(hard.outside, hard.inputs))
        .right("bound broken", |(_, hard, _)| share(hard.violated, hard.inputs))
        .right("visibly", |(_, hard, _)| share(hard.visible, hard.inputs))
        .right("scenes: bound broken", |(.., scenes)| share(scenes.violated, scenes.inputs))
        .right("error, 99.9 %", |(.., scenes)| two_digits(scenes.error_999))
        .right("largest", |(.., scenes)| two_digits(scenes.error_max))
        .right("mean loss", |(.., scenes)| two_digits(scenes.mean_loss));
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
    let least = |inputs, count: Count| {
        move |m: &StabilityMethod| shown(tables.smallest_alpha(&m.name, inputs, count))
    };
    let table = Table::of(&tables.experiment.technique)
        .left("method", |m| &m.name)
        .right("recommended", |m| format!("{:e}", m.alpha()))
        .right("hard: a number everywhere", least(Inputs::Hard, |r| r.not_finite))
        .right("inside [0, 1]", least(Inputs::Hard, |r| r.outside))
        .right("bound never broken", least(Inputs::Hard, |r| r.violated))
        .right("never visibly", least(Inputs::Hard, |r| r.visible))
        .right("scenes: bound never broken", least(Inputs::Scenes, |r| r.violated))
        .right("never visibly", least(Inputs::Scenes, |r| r.visible));
    let note = Text::from("Among the biases that were tried; none: not even the largest helps.");
    Block::section(3, "Smallest moment bias from which on a failure is gone", table, Some(note))
}

fn checks(tables: &StabilityTables<'_>) -> Vec<Block> {
    let of = |method| tables.checks.iter().filter(move |c| c.method == method);
    let sum = |count: fn(&CheckRecord) -> u64| move |method| of(method).map(count).sum::<u64>();
    let largest = |method| two_digits(of(method).map(|c| c.largest_excess).fold(0.0, f64::max));
    let table = Table::of(distinct(tables.checks.iter().map(|check| check.method.as_str())))
        .left("method", |method| method)
        .right("inputs", sum(|c| c.inputs))
        .right("no number", sum(|c| c.not_finite))
        .right("outside [0, 1]", sum(|c| c.outside))
        .right("bound broken", sum(|c| c.violated))
        .right("largest G - F - alpha", largest);
    let note = Text::from(
        "Our forms without storage at the recommended bias; F is the only thing that they are compared with.",
    );
    Block::section(3, "Many inputs", table, Some(note))
}

fn pivots(tables: &StabilityTables<'_>) -> Vec<Block> {
    let table = Table::of(&tables.pivots)
        .left("inputs", |p| &p.family)
        .right("moments", |p| p.order)
        .right("smallest pivot below 1e-3", |p| percent(p.below_1e3, 1))
        .right("below 1e-6", |p| percent(p.below_1e6, 1))
        .right("below 1e-9", |p| percent(p.below_1e9, 1))
        .right("median", |p| two_digits(p.median));
    let note = Text::from("B = L D L^T for moments of 2 z - 1, without a bias.");
    Block::section(3, "How nearly singular B is", table, Some(note))
}
