//! The tables of a `ranking-map` run, each with a note on how to read it.

use super::summary::RankingTables;
use crate::kinds::rows::distinct;
use crate::page::{Block, Table, Text, code, percent, row};

pub(super) fn blocks(tables: &RankingTables<'_>) -> Vec<Block> {
    [settings(tables), followed(tables), classes(tables)].concat()
}

fn settings(tables: &RankingTables<'_>) -> Vec<Block> {
    let table = Table::of(&tables.records)
        .left("settings", |r| &r.variation)
        .left("varied", |r| &r.axis)
        .right("rank correlation", |r| format!("{:.4}", r.correlation))
        .right("among the best", |r| format!("{:.3}", r.best_correlation))
        .right("best kept", |r| percent(r.kept, 0))
        .right("regret", |r| percent(r.regret, 2))
        .left("best basis", |r| code(&r.best))
        .right("its error", |r| percent(r.best_error, 3))
        .right("power moments", |r| percent(r.power_error, 3))
        .right("median", |r| percent(r.median_error, 3))
        .right("fragments", |r| r.fragments)
        .right("programs", |r| r.programs);
    let note = format!(
        "Spearman's correlation of the ranks with those of the first row, over all candidates and over the {0} best of the first \
         row; how many of these are among the {0} best here; by how much the best basis of the first row errs more than the best \
         here. All candidates on all fragments drawn, no race.",
        tables.experiment.best
    );
    Block::section(2, "What moves the ranking", table, Some(note.into()))
}

fn followed(tables: &RankingTables<'_>) -> Vec<Block> {
    let bases = tables.bases();
    let cells = |name: &str| {
        let rank = |basis: &&str| tables.rank(name, basis).map(|row| row.rank).into();
        [row![name], bases.iter().map(rank).collect()].concat()
    };
    let table = Table::default()
        .left(["settings"])
        .right(bases.iter().copied().map(code))
        .rows(tables.records.iter().map(|record| cells(&record.variation)));
    let note = Text::from(
        "Ranks of power and trigonometric moments and of the best of the first row under each of the settings.",
    );
    Block::section(2, "Ranks of single bases", table, Some(note))
}

fn classes(tables: &RankingTables<'_>) -> Vec<Block> {
    let classes = distinct(tables.classes.iter().map(|row| row.class.as_str()));
    let cells = |name: &str| {
        let of = |class: &&str| {
            let is_it = |row: &&evaluation::ClassRecord| row.variation == name && row.class == *class;
            tables
                .classes
                .iter()
                .find(is_it)
                .map(|row| format!("{} ({})", percent(row.l1_error, 2), row.rank))
                .into()
        };
        [row![name], classes.iter().map(of).collect()].concat()
    };
    let table = Table::default()
        .left(["settings"])
        .right(classes.iter().copied())
        .rows(tables.records.iter().map(|record| cells(&record.variation)));
    let note = Text::from(
        "Error of the best basis whose functions are all of one kind, and its rank among all; classes.csv says which it is.",
    );
    Block::section(2, "The best of each class", table, Some(note))
}
