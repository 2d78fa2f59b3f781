//! One parameter varied at a time: tables, charts, and which settings are safe.

use super::summary::SoftTables;
use crate::drawing::{Series, SeriesChart, SeriesPoint, svg};
use crate::error::ReportError;
use crate::kinds::rows::distinct;
use crate::page::{Block, Drawing, Table, Text, in_percent, percent, percent_tick};
use evaluation::{Sweep, SweepRecord, SweepValues};

/// A setting is safe if nothing fails and the error is within this factor of the least of the sweep.
const SAFE: f64 = 1.05;

/// The rows of a technique in a sweep, over all widths.
fn rows<'a>(tables: &'a SoftTables<'_>, sweep: &str, technique: &str) -> Vec<&'a SweepRecord> {
    let of = |r: &&SweepRecord| r.sweep == sweep && r.technique == technique && r.class == "all";
    tables.sweeps.iter().filter(of).collect()
}

fn is_safe(row: &SweepRecord, all: &[&SweepRecord]) -> bool {
    let failures = |r: &SweepRecord| r.refused + r.not_finite;
    let sound = all.iter().filter(|r| failures(r) == 0);
    let least = sound.map(|r| r.mean_error).fold(f64::INFINITY, f64::min);
    failures(row) == 0 && row.mean_error <= SAFE * least
}

/// What is on the axis.
fn label(values: &SweepValues) -> &'static str {
    match values {
        SweepValues::Epsilon(_) => "epsilon, weight of the receiver in the average blocker depth",
        SweepValues::MomentBias(_) => "alpha, the moment bias",
        SweepValues::Region(_) => "N over the texels of the largest region",
        SweepValues::Table(_) => "table",
        SweepValues::Umbra(_) => "share of blockers that counts as umbra",
        SweepValues::Degrees(_) => "angular size of the light in degrees",
    }
}

/// The settings that are safe, a sentence a sweep.
pub(super) fn findings(tables: &SoftTables<'_>) -> Vec<String> {
    let of = |sweep: &Sweep| {
        // The error of larger lights is another one, not a failure.
        if matches!(sweep.values, SweepValues::Degrees(_)) {
            return None;
        }
        let techniques: Vec<String> = sweep
            .techniques
            .iter()
            .filter_map(|technique| {
                let rows = rows(tables, &sweep.id, technique);
                let safe: Vec<&str> =
                    rows.iter().filter(|r| is_safe(r, &rows)).map(|r| r.setting.as_str()).collect();
                let all = rows.len();
                (all > 0).then(|| {
                    let list = if safe.is_empty() { "none".to_owned() } else { safe.join(", ") };
                    format!("{technique}: {list}")
                })
            })
            .collect();
        (!techniques.is_empty()).then(|| {
            format!(
                "Safe in the sweep \"{}\" ({}): {}.",
                sweep.id,
                label(&sweep.values),
                techniques.join("; ")
            )
        })
    };
    tables.experiment.sweep.iter().filter_map(of).collect()
}

pub(super) fn blocks(tables: &SoftTables<'_>) -> Vec<Block> {
    let mut blocks = Vec::new();
    for sweep in &tables.experiment.sweep {
        let mut all: Vec<(&SweepRecord, bool)> = Vec::new();
        for technique in distinct(sweep.techniques.iter()) {
            let rows = rows(tables, &sweep.id, technique);
            all.extend(rows.iter().map(|&row| (row, is_safe(row, &rows))));
        }
        let share =
            |count: usize, row: &SweepRecord| in_percent(count as f64 / row.receivers.max(1) as f64, 2);
        let table = Table::of(all)
            .left("technique", |(r, _)| &r.technique)
            .right(label(&sweep.values), |(r, _)| &r.setting)
            .right("error, %", |(r, _)| in_percent(r.mean_error, 2))
            .right("signed", |(r, _)| in_percent(r.signed_mean, 2))
            .right("p95", |(r, _)| in_percent(r.p95, 1))
            .right("refused, %", |(r, _)| share(r.refused, r))
            .right("no number or outside, %", |(r, _)| share(r.not_finite, r))
            .right("changed, %", |(r, _)| share(r.changed, r))
            .right("mean change, %", |(r, _)| in_percent(r.mean_change, 3))
            .right("largest", |(r, _)| in_percent(r.largest_change, 1))
            .left("safe", |(_, safe)| if safe { "yes" } else { "no" });
        let note = Text::from(format!(
            "Light \"{}\", the first depth bias, {} fragments. Changed: off by more than 1/255 from the same method with exact \
             moments in double precision; what table and arithmetic do. Refused: the region has more texels than the table can \
             sum. Safe: nothing fails, and the error is within 5 % of the least in the sweep.",
            sweep.light,
            tables.sweeps.iter().find(|r| r.sweep == sweep.id && r.class == "all").map_or(0, |r| r.receivers)
        ));
        blocks.extend(Block::section(3, &format!("Sweep: {}", sweep.id), table, Some(note)));
        blocks.extend(by_width(tables, sweep));
    }
    if blocks.is_empty() {
        return blocks;
    }
    [vec![Block::heading(2, "Stability")], blocks].concat()
}

/// Where tables fail: by the size of the filter.
fn by_width(tables: &SoftTables<'_>, sweep: &Sweep) -> Vec<Block> {
    if !matches!(sweep.values, SweepValues::Table(_)) {
        return Vec::new();
    }
    let of = |r: &&SweepRecord| r.sweep == sweep.id && r.class != "all" && r.receivers > 0;
    let table = Table::of(tables.sweeps.iter().filter(of))
        .left("technique", |r| &r.technique)
        .left("table", |r| &r.setting)
        .left("filter, texels", |r| &r.class)
        .right("receivers", |r| r.receivers)
        .right("error, %", |r| in_percent(r.mean_error, 2))
        .right("changed, %", |r| in_percent(r.changed as f64 / r.receivers as f64, 2))
        .right("mean change, %", |r| in_percent(r.mean_change, 3));
    Block::section(3, "Tables by the size of the filter", table, None)
}

/// A chart for each sweep of numbers.
pub(super) fn charts(tables: &SoftTables<'_>) -> Result<Vec<Drawing>, ReportError> {
    let mut drawings = Vec::new();
    for sweep in &tables.experiment.sweep {
        let series = |technique: &String| Series {
            name: technique.clone(),
            points: rows(tables, &sweep.id, technique).into_iter().filter_map(point).collect(),
        };
        let mut curves: Vec<Series> = distinct(sweep.techniques.iter()).into_iter().map(series).collect();
        curves.retain(|series| !series.points.is_empty());
        if curves.iter().all(|series| series.points.len() < 2) {
            continue;
        }
        let id = format!("sweep-{}", sweep.id);
        let title = format!("Error by {}, light \"{}\"", label(&sweep.values), sweep.light);
        let chart = SeriesChart {
            title: &title,
            x_label: label(&sweep.values),
            y_label: "mean |method - truth|",
            y_tick: &|error| percent_tick(*error),
        };
        let picture = svg(&id, (640, 400), |root| chart.draw(root, &curves))?;
        drawings.push(Drawing::new(id, title, picture));
    }
    Ok(drawings)
}

/// Where a setting stands in a chart; nowhere if it answers nothing.
fn point(row: &SweepRecord) -> Option<SeriesPoint> {
    let x = row.value.filter(|_| row.refused < row.receivers)?;
    let label = format!("{} at {}: {}", row.technique, row.setting, percent(row.mean_error, 2));
    Some(SeriesPoint { x, tick: row.setting.clone(), y: row.mean_error, label })
}
