//! What every kind asks of the rows of a table.

use crate::error::ReportError;
use crate::page::{Block, Table, Text, count_of, in_percent};
use evaluation::{Role, RunDirectory, TimedSample, ViewRecord};
use serde::de::DeserializeOwned;

/// Each value once, in the order of their first appearance.
pub(crate) fn distinct<T: PartialEq>(values: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut distinct = Vec::new();
    for value in values {
        if !distinct.contains(&value) {
            distinct.push(value);
        }
    }
    distinct
}

/// A fraction in percent with the digits of most errors, under a heading that says so.
pub(crate) fn percent(fraction: f64) -> String {
    in_percent(fraction, 2)
}

/// Least time of a technique's stage in nanoseconds an item: the repetition that was disturbed least.
pub(crate) fn least_time(samples: &[TimedSample], technique: &str, stage: &str) -> Option<f64> {
    let of_stage = samples.iter().filter(|s| s.technique == technique && s.stage == stage);
    of_stage.map(|s| s.time_ns as f64 / s.items.max(1) as f64).min_by(f64::total_cmp)
}

/// The same in whole nanoseconds.
pub(crate) fn least_ns(samples: &[TimedSample], technique: &str, stage: &str) -> Option<String> {
    least_time(samples, technique, stage).map(|ns| format!("{ns:.0}"))
}

/// The same in millions of items a second; 0 where nothing was timed.
pub(crate) fn millions_a_second(samples: &[TimedSample], technique: &str, stage: &str) -> f64 {
    least_time(samples, technique, stage).map_or(0.0, |ns| 1e3 / ns)
}

/// Techniques of which a stage was timed.
pub(crate) fn timed<'a, T: Role>(
    techniques: &'a [T],
    samples: &'a [TimedSample],
    stage: &'a str,
) -> impl Iterator<Item = &'a T> {
    techniques.iter().filter(move |technique| least_time(samples, technique.name(), stage).is_some())
}

/// How many linear programs were solved, and how many without proof.
pub(crate) fn programs_solved(programs: u64, uncertified: u64) -> Text {
    let programs = count_of(programs);
    format!("{programs} linear programs were solved, {uncertified} remained without a certificate.").into()
}

/// The tables of a run, each a file of the field's name, beside the experiment where rows are read with it; `some_runs` names
/// those that need not be there.
macro_rules! tables {
    (
        $(#[$doc:meta])*
        $name:ident $(<$life:lifetime> of $experiment:ty)? { $($table:ident: $row:ty,)* }
        $(some_runs { $($rare:ident: $rare_row:ty,)* })?
    ) => {
        $(#[$doc])*
        pub(crate) struct $name $(<$life>)? {
            $(pub(crate) experiment: &$life $experiment,)?
            $(pub(crate) $table: Vec<$row>,)*
            $($(pub(crate) $rare: Vec<$rare_row>,)*)?
        }

        impl $(<$life>)? $name $(<$life>)? {
            pub(crate) fn read(
                run: &evaluation::RunDirectory,
                $(experiment: &$life $experiment,)?
            ) -> Result<Self, crate::error::ReportError> {
                Ok(Self {
                    $(experiment: <&$life $experiment>::from(experiment),)?
                    $($table: run.rows(concat!(stringify!($table), ".csv"))?,)*
                    $($($rare: crate::kinds::rows::rows_if_there(run, concat!(stringify!($rare), ".csv"))?,)*)?
                })
            }
        }
    };
}
pub(crate) use tables;

/// The rows of a table that only some runs have.
pub(crate) fn rows_if_there<R: DeserializeOwned>(
    run: &RunDirectory,
    file: &str,
) -> Result<Vec<R>, ReportError> {
    Ok(if run.path().join(file).is_file() { run.rows(file)? } else { Vec::new() })
}

/// The light views that were evaluated, with what their kind recorded of them.
pub(crate) fn views(level: u8, views: &[ViewRecord]) -> Vec<Block> {
    let five_digits = |value: Option<f64>| value.map(|value| format!("{value:.5}"));
    let table = Table::of(views)
        .left("view", |v| format!("{} {}", v.scene, v.view))
        .right_if_any("stack entries", |v| v.stack_entries)
        .right_if_any("layers", |v| v.layers)
        .right("fragments", |v| v.fragments)
        .right("evaluated", |v| v.sampled)
        .right_if_any("texel depth", |v| five_digits(v.texel_depth))
        .right_if_any("median slope", |v| five_digits(v.median_slope))
        .right_if_any("mean F, %", |v| v.mean_reference.map(|mean| in_percent(mean, 1)))
        .right_if_any("clamped", |v| v.clamped_depths);
    Block::section(level, "Views", table, None)
}
