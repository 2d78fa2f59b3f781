//! Errors of several techniques over a setting, as a figure.

use super::canvas::svg;
use super::series::{Series, SeriesChart, SeriesPoint};
use crate::error::ReportError;
use crate::page::{Drawing, percent, percent_tick};

/// A point of a curve, with the setting as the axis has it.
pub(crate) fn error_point(name: &str, x: f64, tick: impl Into<String>, error: f64) -> SeriesPoint {
    let tick = tick.into();
    let label = format!("{name} at {tick}: {}", percent(error, 2));
    SeriesPoint { x, tick, y: error, label }
}

/// The figure.
pub(crate) fn error_curves(
    id: impl Into<String>,
    title: impl Into<String>,
    (x_label, y_label): (&str, &str),
    curves: &[Series],
) -> Result<Drawing, ReportError> {
    let (id, title) = (id.into(), title.into());
    let chart = SeriesChart { title: &title, x_label, y_label, y_tick: &|error| percent_tick(*error) };
    let picture = svg(&id, (640, 400), |root| chart.draw(root, curves))?;
    Ok(Drawing::new(id, title, picture))
}
