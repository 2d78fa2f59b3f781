//! Errors by a setting on a logarithmic axis, a curve a technique.

use super::canvas::{Area, Drawn, FINE, Stroke, legend, line, mesh, svg};
use super::hover::around;
use super::kernel::draw_title;
use crate::error::ReportError;
use crate::page::{Drawing, percent};
use plotters::prelude::{BindKeyPoints, ChartBuilder, Circle, IntoLogRange};
use plotters::style::Color;

/// A point of a curve.
pub(crate) struct CurvePoint {
    /// On the axis; positive.
    pub(crate) x: f64,
    /// The setting as the axis has it.
    pub(crate) tick: String,
    pub(crate) error: f64,
}

/// A technique's points, ascending.
pub(crate) struct ErrorCurve {
    pub(crate) name: String,
    pub(crate) points: Vec<CurvePoint>,
}

/// The chart. Every setting that occurs has a tick.
pub(crate) fn error_curves(
    id: impl Into<String>,
    title: impl Into<String>,
    labels: (&str, &str),
    curves: &[ErrorCurve],
) -> Result<Drawing, ReportError> {
    let (id, title) = (id.into(), title.into());
    let rows = curves.len().div_ceil(COLUMNS) as u32;
    let key = rows.max(2) * KEY_ROW + 4;
    let picture = svg(&id, (640, 360 + key), |root| draw(root, (&title, labels), curves, key))?;
    Ok(Drawing::new(id, title, picture))
}

/// Columns of the legend, and the height of one of its rows in pixels.
const COLUMNS: usize = 3;
const KEY_ROW: u32 = 18;

fn draw(
    root: &Area<'_>,
    (title, (x_label, y_label)): (&str, (&str, &str)),
    curves: &[ErrorCurve],
    key: u32,
) -> Drawn {
    let (top, rest) = root.split_vertically(30 * FINE);
    draw_title(&top, title)?;
    let (plot, key) = rest.split_vertically(rest.dim_in_pixel().1 as i32 - (key * FINE) as i32);
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let first = points().map(|p| p.x).fold(f64::INFINITY, f64::min);
    let last = points().map(|p| p.x).fold(0.0, f64::max);
    let highest = points().map(|p| p.error).fold(0.0, f64::max);
    let mut ticks: Vec<(f64, &str)> = points().map(|p| (p.x, p.tick.as_str())).collect();
    ticks.sort_by(|a, b| a.0.total_cmp(&b.0));
    ticks.dedup();
    let mut builder = ChartBuilder::on(&plot);
    builder.margin_left(6 * FINE).margin_top(6 * FINE).margin_right(16 * FINE);
    builder.x_label_area_size(42 * FINE).y_label_area_size(56 * FINE);
    let axis = (0.8 * first..1.25 * last).log_scale();
    let axis = axis.with_key_points(ticks.iter().map(|tick| tick.0).collect());
    let mut chart = builder.build_cartesian_2d(axis, 0.0..1.1 * highest.max(1e-6))?;
    let tick = |value: &f64| {
        let of = ticks.iter().find(|tick| tick.0 == *value);
        of.map_or(String::new(), |tick| tick.1.to_owned())
    };
    let mut grid = mesh(&mut chart, 11);
    grid.x_label_formatter(&tick).y_label_formatter(&|error| percent(*error, 1)).y_labels(7);
    grid.x_desc(x_label).y_desc(y_label);
    grid.draw()?;
    let mut entries = Vec::new();
    for (n, curve) in curves.iter().enumerate() {
        let stroke = Stroke::nth(n);
        line(&mut chart, curve.points.iter().map(|p| (p.x, p.error)).collect(), stroke)?;
        for point in &curve.points {
            let at = (point.x, point.error);
            chart.draw_series([Circle::new(at, 3 * FINE, stroke.colour.filled())])?;
            let label = format!("{} at {}: {}", curve.name, point.tick, percent(point.error, 2));
            around(chart.backend_coord(&at), 6 * FINE as i32, &label);
        }
        if !curve.points.is_empty() {
            entries.push((stroke, curve.name.clone()));
        }
    }
    legend(&key, &entries, COLUMNS)
}
