//! The figures of a `single-scattering` run: errors, complexity, cost, moment biases, sheets of error maps.

use super::summary::{ALL, ScatteringTables};
use crate::drawing::{DotChart, DotRow, ErrorColours, Series, SeriesChart, SeriesPoint, error_sheet, svg};
use crate::error::ReportError;
use crate::kinds::rows::distinct;
use crate::page::{Drawing, percent, percent_tick};
use evaluation::{RunDirectory, ScatteringCost, map_name, with_role};

/// What a pixel of an error map shows.
const PIXEL: [&str; 2] =
    ["shadowed share of a pixel's view ray,", "method minus the exact integral of the shadow map"];

/// Size of charts in pixels.
const CHART: (u32, u32) = (700, 420);

pub(super) fn draw(run: &RunDirectory, tables: &ScatteringTables<'_>) -> Result<Vec<Drawing>, ReportError> {
    let mut figures: Vec<Drawing> = errors(tables)?.into_iter().collect();
    figures.extend(by_class(tables, "steps", "depth steps along the row up to the end of the view ray")?);
    figures.extend(by_class(tables, "epipole", "degrees between view ray and light axis")?);
    figures.extend(by_cost(tables)?);
    figures.extend(by_bias(tables)?);
    for picture in &tables.experiment.picture {
        let tiles: Vec<_> = picture
            .techniques
            .iter()
            .map(|name| (name.clone(), run.path().join(map_name(&picture.id, &picture.standpoint, name))))
            .collect();
        let title = format!("method - truth, {}, standpoint \"{}\"", picture.scene, picture.standpoint);
        let sheet = error_sheet(&tiles, &title, ErrorColours::Signed, PIXEL)?;
        figures.push(Drawing::new(format!("leak-{}", picture.id), title, sheet));
    }
    Ok(figures)
}

fn errors(tables: &ScatteringTables<'_>) -> Result<Option<Drawing>, ReportError> {
    let rows = tables.experiment.technique.iter().filter_map(|technique| {
        let row = tables.pooled(&technique.name, ALL)?;
        Some(DotRow {
            name: technique.name.clone(),
            first: row.l1_error,
            margin: row.standard_error.map_or(0.0, |e| 2.0 * e),
            second: Some(row.geometry_error),
        })
    });
    let chart = DotChart {
        title: "Mean distance from the exact integral, over all views (less is better)".to_owned(),
        x: "mean |method - truth|, of the scattering without shadows",
        words: ["map", "geometry"],
        legend: [
            ("truth: the shadow map's, with twice the standard error", 200),
            ("truth: the geometry's", 600),
        ],
        rows: rows.collect(),
    };
    chart.drawing("errors".to_owned())
}

/// Those whose curves are compared, by role.
const COMPARED: [&str; 6] =
    ["two moments", "four moments", "six moments", "eight moments", "convolution", "32 samples"];

/// Errors over a logarithmic axis.
fn chart(id: &str, title: &str, x_label: &str, curves: &[Series]) -> Result<String, ReportError> {
    let chart = SeriesChart {
        title,
        x_label,
        y_label: "mean |method - truth|",
        y_tick: &|error| percent_tick(*error),
    };
    svg(id, CHART, |root| chart.draw(root, curves))
}

fn by_class(tables: &ScatteringTables<'_>, group: &str, x: &str) -> Result<Option<Drawing>, ReportError> {
    let of_group = tables.records.iter().filter(|r| r.scene == "all" && r.group == group);
    let classes = distinct(of_group.map(|r| r.class.as_str()));
    let curve = |role: &&str| {
        let name = &with_role(&tables.experiment.technique, role)?.name;
        let point = |(n, class): (usize, &&str)| {
            let row = tables.pooled(name, (group, class))?;
            Some(SeriesPoint {
                // Classes stand at equal distances on an axis of powers.
                x: 2f64.powi(n as i32),
                tick: (*class).to_owned(),
                y: row.l1_error,
                label: format!("{name}, {class}: {}", percent(row.l1_error, 2)),
            })
        };
        let points: Vec<SeriesPoint> = classes.iter().enumerate().filter_map(point).collect();
        (!points.is_empty()).then(|| Series { name: name.clone(), points })
    };
    let curves: Vec<Series> = COMPARED.iter().filter_map(curve).collect();
    if classes.len() < 2 || curves.is_empty() {
        return Ok(None);
    }
    let title = format!("Error by {x} (less is better)");
    let id = format!("by-{group}");
    let picture = chart(&id, &title, x, &curves)?;
    Ok(Some(Drawing::new(id, title, picture)))
}

/// Error over modelled cost: samples by their number, moments by theirs.
fn by_cost(tables: &ScatteringTables<'_>) -> Result<Option<Drawing>, ReportError> {
    let points = |costs: Vec<&ScatteringCost>, name: &str| {
        let mut costs = costs;
        costs.sort_by(|a, b| a.total.total_cmp(&b.total));
        let point = |cost: &&ScatteringCost| {
            let row = tables.pooled(&cost.technique, ALL)?;
            let words = format!("{}: {} at {:.0} MB", cost.technique, percent(row.l1_error, 2), cost.total);
            Some(SeriesPoint {
                x: cost.total,
                tick: format!("{:.0}", cost.total),
                y: row.l1_error,
                label: words,
            })
        };
        Series { name: name.to_owned(), points: costs.iter().filter_map(point).collect() }
    };
    let playing = |roles: &[&str]| {
        let names = roles.iter().filter_map(|role| with_role(&tables.experiment.technique, role));
        names.filter_map(|t| tables.costs.iter().find(|c| c.technique == t.name)).collect::<Vec<_>>()
    };
    let jittered = tables.experiment.technique.iter().filter(|t| t.method.jitter.is_none());
    let marched: Vec<&ScatteringCost> =
        jittered.filter_map(|t| tables.costs.iter().find(|c| c.technique == t.name && c.steps > 0)).collect();
    let mut curves = vec![
        points(
            playing(&["two moments", "four moments", "six moments", "eight moments"]),
            "2, 4, 6, 8 moments",
        ),
        points(marched, "samples a ray"),
        points(playing(&["convolution"]), "convolution"),
        points(playing(&["six moments, filtered"]), "six moments, filtered"),
    ];
    curves.retain(|series| !series.points.is_empty());
    // Ticks of neighbours would overlap: those of the samples stay.
    for series in curves.iter_mut().filter(|series| series.name != "samples a ray") {
        series.points.iter_mut().for_each(|point| point.tick.clear());
    }
    if curves.iter().map(|series| series.points.len()).sum::<usize>() < 2 {
        return Ok(None);
    }
    let [width, height, side] = tables.experiment.frame;
    let title =
        format!("Error by modelled cost, {width}x{height}, maps of {side}² (left and down is better)");
    let picture = chart("cost", &title, "modelled cost of a frame, megabytes", &curves)?;
    Ok(Some(Drawing::new("cost", title, picture)))
}

/// A chart a bound, a curve a format.
fn by_bias(tables: &ScatteringTables<'_>) -> Result<Vec<Drawing>, ReportError> {
    let mut drawings = Vec::new();
    for bound in distinct(tables.stability.iter().map(|r| r.bound.as_str())) {
        let rows = || tables.stability.iter().filter(|r| r.bound == bound);
        let curve = |format: &str| {
            let point = |row: &evaluation::StoredBiasRecord| {
                let decade = row.alpha.log10();
                let is_tick = (decade - decade.round()).abs() < 1e-6;
                SeriesPoint {
                    x: row.alpha,
                    tick: if is_tick { format!("1e{:.0}", decade.round()) } else { String::new() },
                    y: row.l1_error,
                    label: format!("{format} at {:.1e}: {}", row.alpha, percent(row.l1_error, 2)),
                }
            };
            Series {
                name: format.to_owned(),
                points: rows().filter(|r| r.format == format).map(point).collect(),
            }
        };
        let curves: Vec<Series> =
            distinct(rows().map(|r| r.format.as_str())).into_iter().map(curve).collect();
        if curves.iter().all(|series| series.points.len() < 2) {
            continue;
        }
        let id = format!("bias-{bound}");
        let title = format!("Error by moment bias, {bound} (less is better)");
        let picture = chart(&id, &title, "alpha, the moment bias", &curves)?;
        drawings.push(Drawing::new(id, title, picture));
    }
    Ok(drawings)
}
