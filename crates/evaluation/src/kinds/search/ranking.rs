//! From what blocks say about candidates to rows by rank.

use super::candidates::class;
use super::judge::{Finding, Key};
use super::records::SearchRecord;
use super::sweep::Sweep;
use crate::statistics::{Mean, joined, rounded_to};
use moment_problem::BasisFunction;
use std::collections::HashMap;

/// Steps in 1 of the tables: far below the intervals of errors.
pub(crate) const STEPS: f64 = 1e7;

/// Normal quantile of the intervals: 99 % lie within.
const INTERVAL_DEVIATIONS: f64 = 2.576;

/// A candidate before it is ranked: difference to the control, half its interval, number of the subset.
struct Row {
    value: f64,
    deviation: f64,
    number: u32,
}

/// Rows of one order, the least error first: all candidates, or those that the experiment records.
pub(crate) fn ranked(
    sweep: &Sweep<'_>,
    functions: &[BasisFunction],
    known: &HashMap<Key, Finding>,
    order: usize,
) -> Vec<SearchRecord> {
    let blocks = sweep.workload.blocks.len();
    let row = |number: u32| {
        let (value, deviation) = match sweep.estimate(known, blocks, order, number) {
            Some((mean, _)) => (mean.value, INTERVAL_DEVIATIONS * mean.variance.sqrt()),
            None => (f64::INFINITY, 0.0),
        };
        Row { value, deviation, number }
    };
    let mut rows: Vec<Row> = (0..sweep.subsets[order].len() as u32).map(row).collect();
    rows.sort_by(|a, b| a.value.total_cmp(&b.value).then(a.number.cmp(&b.number)));
    let sorted = |of: &dyn Fn(&Row) -> f64| {
        let mut values: Vec<f64> = rows.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let (lows, highs) = (sorted(&|row| row.value - row.deviation), sorted(&|row| row.value + row.deviation));
    let is_recorded = recorded_places(sweep.experiment.recorded, rows.len());
    let always = sweep.always(order);
    let mut records = Vec::new();
    for (place, Row { value, deviation, number }) in rows.iter().enumerate() {
        let error = complaint(sweep, known, order, *number);
        if error.is_empty() && !is_recorded(place) && !always.contains(number) {
            continue;
        }
        records.push(SearchRecord {
            rank: place + 1,
            rank_low: highs.partition_point(|high| *high < value - deviation) + 1,
            rank_high: lows.partition_point(|low| *low <= value + deviation),
            error,
            ..record(sweep, functions, known, (order, *number))
        });
    }
    records
}

/// Which places of a ranking are recorded: the first ones, and as many spread evenly over the others with the last of them.
fn recorded_places(recorded: Option<usize>, all: usize) -> impl Fn(usize) -> bool {
    let first = recorded.unwrap_or(all);
    let step = all.saturating_sub(first).div_ceil(first.max(1)).max(1);
    move |place| place < first || (all - 1 - place).is_multiple_of(step)
}

/// Why a candidate has no error, or none that is certain; or empty.
fn complaint(sweep: &Sweep<'_>, known: &HashMap<Key, Finding>, order: usize, number: u32) -> String {
    let blocks = sweep.workload.blocks.len();
    let uncertified: u32 = (0..blocks)
        .filter_map(|block| known.get(&(block as u16, order as u16, number)))
        .map(|finding| finding.verdict.uncertified)
        .sum();
    if uncertified > 0 {
        return format!("{uncertified} programs without a certificate");
    }
    match sweep.estimate(known, blocks, order, number) {
        Some(_) => String::new(),
        None => "all functions are constant on the support".to_owned(),
    }
}

/// A row without its rank.
fn record(
    sweep: &Sweep<'_>,
    functions: &[BasisFunction],
    known: &HashMap<Key, Finding>,
    (order, number): (usize, u32),
) -> SearchRecord {
    let blocks = sweep.workload.blocks.len();
    let members = sweep.members(order, number);
    let basis: Vec<&BasisFunction> = members.iter().map(|&member| &functions[member]).collect();
    let names = |keep: &dyn Fn(usize) -> bool| {
        let kept = basis.iter().enumerate().filter(|(i, _)| keep(*i)).map(|(_, f)| f.name());
        kept.collect::<Vec<_>>().join(", ")
    };
    let dropped = known.get(&(0, order as u16, number)).map_or(0, |finding| finding.dropped);
    let mut record = SearchRecord {
        m: sweep.subsets[order].order(),
        rank: 0,
        rank_low: 0,
        rank_high: 0,
        basis: names(&|_| true),
        class: class(&basis).to_owned(),
        l1_error: 0.0,
        interval: 0.0,
        fragments: 0,
        reduced: names(&|i| dropped & (1 << i) != 0),
        error: String::new(),
    };
    if let Some((mean, judged)) = sweep.estimate(known, blocks, order, number) {
        let level = control_error(sweep, order).value;
        record.fragments = (0..judged).map(|block| sweep.workload.blocks[block].fragments_drawn()).sum();
        record.l1_error = rounded_to((level + mean.value).max(0.0), STEPS);
        record.interval = rounded_to(INTERVAL_DEVIATIONS * mean.variance.sqrt(), STEPS);
    }
    record
}

/// Error of the control over all blocks.
pub(crate) fn control_error(sweep: &Sweep<'_>, order: usize) -> Mean {
    let blocks = &sweep.workload.blocks;
    joined(sweep.controls[order].iter().zip(blocks).map(|(control, block)| {
        (Mean { value: control.verdict.error, variance: 0.0 }, block.fragments_drawn())
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_places_and_an_even_share_of_the_others_are_recorded() {
        let kept = |recorded, all| {
            (0..all).filter(|&place| recorded_places(recorded, all)(place)).collect::<Vec<_>>()
        };
        assert_eq!(kept(None, 5), [0, 1, 2, 3, 4]);
        assert_eq!(kept(Some(9), 5), [0, 1, 2, 3, 4]);
        assert_eq!(kept(Some(3), 12), [0, 1, 2, 5, 8, 11]);
        let many = kept(Some(100), 2_324_784);
        assert!(
            many.len() <= 200 && many[..100].iter().copied().eq(0..100) && many.last() == Some(&2_324_783)
        );
    }
}
