//! The table of a `bounds` experiment.

use super::summary::Row;
use crate::page::{Block, Table, Text};

pub(crate) fn table(rows: &[Row]) -> Vec<Block> {
    let table = Table::of(rows)
        .left("figure", |r| &r.figure)
        .left("kernel", |r| &r.kernel)
        .left("technique", |r| &r.technique)
        .right("m", |r| r.moments)
        .right("mean F - G", |r| format!("{:.4}", r.mean_distance))
        .right("largest F - G", |r| format!("{:.4}", r.largest_distance))
        .right("worst certificate gap", |r| format!("{:.0e}", r.worst_gap))
        .right("failed", |r| format!("{} of {}", r.failed, r.trials))
        .right("median time", |r| r.median_time_ns.map(|ns| format!("{:.3} ms", ns / 1e6)));
    let note = Text::from(
        "F and G are fractions of the kernel's weight, F - G averaged over z_f from 0 to 1 (trapezoidal rule). Time \
         is for both bounds with their certificate, one thread.",
    );
    vec![Block::Table(table.into()), Block::Paragraph(note)]
}
