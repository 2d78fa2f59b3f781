//! The table of a `bounds` experiment.

use super::summary::Row;
use crate::page::{Block, Table, Text, row};

pub(crate) fn table(rows: &[Row]) -> Vec<Block> {
    let cells = |r: &Row| {
        row![
            &r.figure,
            &r.kernel,
            &r.technique,
            r.moments,
            format!("{:.4}", r.mean_distance),
            format!("{:.4}", r.largest_distance),
            format!("{:.0e}", r.worst_gap),
            format!("{} of {}", r.failed, r.trials),
            r.median_time_ns.map(|ns| format!("{:.3} ms", ns / 1e6)),
        ]
    };
    let table = Table::default()
        .left(["figure", "kernel", "technique"])
        .right(["m", "mean F - G", "largest F - G", "worst certificate gap", "failed", "median time"])
        .rows(rows.iter().map(cells));
    let note = Text::from(
        "F and G are fractions of the kernel's weight, F - G averaged over z_f from 0 to 1 (trapezoidal rule). Time \
         is for both bounds with their certificate, one thread.",
    );
    vec![Block::Table(table), Block::Paragraph(note)]
}
