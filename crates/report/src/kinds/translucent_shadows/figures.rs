//! The figures of a `translucent-shadows` run: errors, by layers and opacity, moment biases, sheets of error maps.

use super::summary::{COMPARED, TranslucentTables};
use crate::drawing::{
    DotChart, DotRow, ErrorColours, Series, SeriesChart, SeriesPoint, error_curves, error_point, error_sheet,
    svg,
};
use crate::error::ReportError;
use crate::kinds::rows::distinct;
use crate::page::Drawing;
use evaluation::{RunDirectory, map_name};

/// What a pixel of an error map shows.
const PIXEL: [&str; 2] = [
    "shadow minus truth on the opaque surface of each pixel;",
    "pixels that do not face the light count as right",
];

pub(super) fn draw(run: &RunDirectory, tables: &TranslucentTables<'_>) -> Result<Vec<Drawing>, ReportError> {
    let mut figures: Vec<Drawing> = errors(tables)?.into_iter().collect();
    let layers = ("layers", "translucent layers in front of the receiver");
    figures.extend(by_group(tables, layers, "Error by translucent layers in front (less is better)")?);
    let opacity = ("opacity", "mean opacity of the layers in front");
    figures.extend(by_group(tables, opacity, "Error by the opacity of layers (less is better)")?);
    figures.extend(biases(tables)?);
    for picture in &tables.experiment.picture {
        // The name of a view that was left out is that of the first one.
        let first = tables.views.iter().find(|view| view.scene == picture.scene);
        let view =
            if picture.view.is_empty() { first.map_or("", |v| v.view.as_str()) } else { &picture.view };
        let map = |name: &String| (name.clone(), run.path().join(map_name(&picture.id, view, name)));
        let tiles: Vec<_> = picture.techniques.iter().map(map).collect();
        let title = format!("shadow - truth, {}, view \"{view}\"", picture.scene);
        let sheet = error_sheet(&tiles, &title, ErrorColours::Signed, PIXEL)?;
        figures.push(Drawing::new(format!("leak-{}", picture.id), title, sheet));
    }
    Ok(figures)
}

fn errors(tables: &TranslucentTables<'_>) -> Result<Option<Drawing>, ReportError> {
    let rows = tables.experiment.technique.iter().filter_map(|technique| {
        let row = tables.row(&technique.name, "surfaces")?;
        Some(DotRow {
            name: technique.name.clone(),
            first: row.l1_error,
            margin: 2.0 * row.standard_error,
            second: tables.row(&technique.name, "inside").map(|row| row.l1_error),
        })
    });
    let chart = DotChart {
        title: "Mean distance from the truth, over all views (less is better)".to_owned(),
        x: "mean |shadow - truth|, of the light",
        words: ["surfaces", "inside"],
        legend: [("opaque surfaces, with twice the standard error", 200), ("inside smoke and glass", 600)],
        rows: rows.collect(),
    };
    chart.drawing("errors".to_owned())
}

fn by_group(
    tables: &TranslucentTables<'_>,
    (by, x): (&str, &str),
    title: &str,
) -> Result<Option<Drawing>, ReportError> {
    let groups: Vec<&str> = distinct(tables.groups.iter().filter(|g| g.by == by).map(|g| g.group.as_str()));
    let curve = |role: &&str| {
        let name = tables.named(role)?;
        let point = |(n, group): (usize, &&str)| {
            let mut rows = tables.groups.iter();
            let row = rows.find(|g| g.by == by && g.group == **group && g.technique == name)?;
            // Groups stand at equal distances on an axis of powers.
            Some(error_point(name, 2f64.powi(n as i32), *group, row.l1_error))
        };
        let points: Vec<_> = groups.iter().enumerate().filter_map(point).collect();
        (!points.is_empty()).then(|| Series { name: name.to_owned(), points })
    };
    let curves: Vec<Series> = COMPARED.iter().filter_map(curve).collect();
    if groups.len() < 2 || curves.is_empty() {
        return Ok(None);
    }
    error_curves(format!("by-{by}"), title, (x, "mean |shadow - truth|"), &curves).map(Some)
}

/// The smallest moment bias by the number of layers, for each opacity, of four moments in 16 bits. Layers at one depth are the
/// hard case, as their moments lie at the border of what distributions have.
fn biases(tables: &TranslucentTables<'_>) -> Result<Option<Drawing>, ReportError> {
    let of_four: Vec<_> = tables
        .stability
        .iter()
        .filter(|r| r.bound == "hamburger4" && r.format == "unorm16" && r.case == "coincident")
        .filter(|r| r.opacity > 0.0 && r.opacity < 1.0)
        .collect();
    let mut opacities: Vec<f64> = of_four.iter().map(|r| r.opacity).collect();
    opacities.dedup();
    let curves: Vec<Series> = opacities
        .iter()
        .map(|&opacity| {
            let rows = of_four.iter().filter(|r| r.opacity == opacity);
            let point = |r: &&&evaluation::BlendingRecord| {
                let alpha = r.smallest_alpha?;
                Some(SeriesPoint {
                    x: r.layers as f64,
                    tick: r.layers.to_string(),
                    y: alpha,
                    label: format!("opacity {opacity}, {} layers: {alpha:.1e}", r.layers),
                })
            };
            Series { name: format!("opacity {opacity}"), points: rows.filter_map(|r| point(&r)).collect() }
        })
        .filter(|series| series.points.len() > 1)
        .collect();
    if curves.is_empty() {
        return Ok(None);
    }
    let title = "Smallest moment bias, coincident layers, four moments in 16 bits (less is better)";
    let chart = SeriesChart {
        title,
        x_label: "layers blended into a texel",
        y_label: "smallest moment bias alpha",
        y_tick: &|alpha| format!("{alpha:.0e}"),
    };
    let picture = svg("biases", (640, 400), |root| chart.draw(root, &curves))?;
    Ok(Some(Drawing::new("biases", title, picture)))
}
