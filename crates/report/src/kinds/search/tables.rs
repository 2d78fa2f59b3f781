//! The tables of a candidate search, each with a note on how to read it.

use super::summary::{SearchTables, within};
use crate::kinds::rows::distinct;
use crate::page::{Block, Table, Text, code, percent, row};
use evaluation::{MarkRecord, SearchRecord};

/// Rows of the table of the best.
const BEST: usize = 50;

pub(crate) fn blocks(tables: &SearchTables<'_>) -> Vec<Block> {
    [
        best(tables),
        classes(tables),
        sizes(tables),
        marks(tables),
        certainty(tables),
        speed(tables),
        tables.level().blocks(2),
    ]
    .concat()
}

fn candidates<'a>(tables: &SearchTables<'_>, records: impl IntoIterator<Item = &'a SearchRecord>) -> Table {
    Table::of(records)
        .right("rank", |r| r.rank)
        .left("rank range", |r| format!("{} to {}", r.rank_low, r.rank_high))
        .left("basis", |r| code(&r.basis))
        .left("class", |r| &r.class)
        .right("mean error", |r| tables.error(r))
        .right("fragments", |r| r.fragments)
        .into()
}

fn best(tables: &SearchTables<'_>) -> Vec<Block> {
    let m = tables.main_order();
    let all = tables.of(m);
    let marked = [tables.power(), tables.trigonometric()].into_iter().flatten().filter(|r| r.rank > BEST);
    let heading =
        format!("The best {} of {} candidates of {m} functions", BEST.min(all.count()), all.count());
    let note = Text::from(
        "Mean error is |G - F| as a fraction of the kernel's weight, over all fragments of all views, every view \
         weighing the same, with half a 99 % interval of its own, and behind it that of the difference to power moments, \
         which were evaluated on the whole sample. The rank range is what the intervals of the differences allow.",
    );
    Block::section(
        2,
        &heading,
        candidates(tables, all.rows().iter().take(BEST).copied().chain(marked)),
        Some(note),
    )
}

fn classes(tables: &SearchTables<'_>) -> Vec<Block> {
    let all = tables.of(tables.main_order());
    let classes = distinct(all.rows().iter().map(|record| record.class.as_str()));
    let first = |class| all.rows().iter().find(|record| record.class == class).copied();
    let table = candidates(tables, classes.into_iter().filter_map(first));
    let note = Text::from("A class has candidates only if the family has that many functions of one kind.");
    Block::section(2, "The best of each class", table, Some(note))
}

fn sizes(tables: &SearchTables<'_>) -> Vec<Block> {
    let rows = tables.orders().into_iter().filter_map(|m| {
        let all = tables.of(m);
        let first = all.first()?;
        let at = |place: usize| percent(all.at(place).map_or(first.l1_error, |r| r.l1_error), 2);
        let (tenth, median, worst) = (at(9), at(all.count() / 2), at(all.count() - 1));
        Some(row![m, all.count(), code(&first.basis), tables.error(first), tenth, median, worst])
    });
    let table = Table::default()
        .right(["m", "candidates"])
        .left(["best"])
        .right(["its error", "10th", "median", "worst"])
        .rows(rows);
    Block::section(2, "Number of functions", table, None)
}

fn marks(tables: &SearchTables<'_>) -> Vec<Block> {
    let exact = |m: &MarkRecord| Some(within(m.l1_error?, m.standard_error?));
    let change = |m: &MarkRecord| Some(within(m.moved_l1_error - m.l1_error?, m.difference_standard_error?));
    let table = Table::of(&tables.marks)
        .left("technique", |m| &m.technique)
        .right("error", exact)
        .right("moved to the support", |m| within(m.moved_l1_error, m.moved_standard_error))
        .right("change", change);
    let note = format!(
        "Candidates are judged with every depth moved to the nearest end of {} equal cells, and their bounds are those \
         over these depths. ± is one standard error. The change shifts the level of all techniques alike and hardly their \
         differences.",
        tables.experiment.cells
    );
    let heading = "Closed forms on the same fragments, and what moving depths changes";
    Block::section(2, heading, table, Some(note.into()))
}

fn certainty(tables: &SearchTables<'_>) -> Vec<Block> {
    let table = Table::of(&tables.stages)
        .right("m", |s| s.m)
        .right("block", |s| s.block)
        .right("fragments", |s| s.fragments)
        .right("candidates", |s| s.candidates)
        .right("programs", |s| s.programs)
        .right("in double-double", |s| s.exact)
        .right("uncertified", |s| s.uncertified);
    let fragments: usize = tables.views.iter().map(|view| view.fragments).sum();
    let sampled: usize = tables.views.iter().map(|view| view.sampled).sum();
    let active: usize = tables.views.iter().filter_map(|view| view.active).sum();
    let note = format!(
        "{sampled} of {fragments} fragments on {} views were drawn; {} of these have F > 0 and need a program, \
         equal ones only once. A block is for the candidates that can still be among the best after those before it.",
        tables.views.len(),
        percent(active as f64 / sampled.max(1) as f64, 1)
    );
    let mut blocks = Block::section(2, "Linear programs", table, Some(note.into()));
    if !tables.agreement.is_empty() {
        let compared: usize = tables.agreement.iter().map(|a| a.fragments).sum();
        let failed: usize = tables.agreement.iter().map(|a| a.failed).sum();
        let worst = tables.agreement.iter().map(|a| a.largest_disagreement).fold(0.0, f64::max);
        let gap = tables.agreement.iter().map(|a| a.largest_gap).fold(0.0, f64::max);
        blocks.push(Block::paragraph(format!(
            "The double-double simplex method, started cold, on {compared} of these programs for {} bases drawn at \
             random: largest disagreement {worst:.1e} (it failed on {failed}), largest distance between a bound and its \
             proof {gap:.1e}.",
            tables.agreement.len()
        )));
    }
    blocks
}

fn speed(tables: &SearchTables<'_>) -> Vec<Block> {
    let speeds = tables.speeds();
    let solver = speeds.first().map_or("certified", |speed| speed.solver);
    let table = Table::of(&speeds)
        .left("basis", |s| code(&s.basis))
        .right(format!("{solver}, programs/s"), |s| format!("{:.2} million", s.fast / 1e6))
        .right("good_lp with microlp", |s| format!("{:.0}", s.microlp))
        .right("ratio", |s| format!("{:.0}", s.fast / s.microlp))
        .right("microlp wrong or refused", |s| format!("{} of {}", s.microlp_wrong, s.microlp_programs));
    let note = Text::from(format!(
        "One thread, the fastest of all repetitions (samples.csv has each). {solver} includes preparing the columns and \
         a certificate for each bound, and solves every program of the last block to 1e-6; microlp is not checked while it \
         is timed and gets some of the same programs.",
    ));
    Block::section(2, "Speed", table, Some(note))
}
