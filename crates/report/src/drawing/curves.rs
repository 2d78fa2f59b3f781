//! Curves over a logarithmic axis whose ticks are the settings that were tried.

use super::canvas::{Area, Drawn, FINE, Stroke, legend, line, mesh};
use super::{around, draw_title};
use crate::page::percent;
use plotters::prelude::{BindKeyPoints, ChartBuilder, Circle, IntoLogRange};
use plotters::style::Color;

/// A point of a curve.
pub(crate) struct Tried {
    /// Place on the axis, above 0.
    pub(crate) place: f64,
    /// What stands there on the axis; nothing for points between ticks.
    pub(crate) tick: String,
    /// A fraction, shown in percent.
    pub(crate) value: f64,
    /// What appears under the pointer.
    pub(crate) label: String,
}

/// Curves with their names.
pub(crate) struct CurveChart<'a> {
    pub(crate) title: &'a str,
    pub(crate) x: &'a str,
    pub(crate) y: &'a str,
    pub(crate) curves: Vec<(String, Vec<Tried>)>,
}

impl CurveChart<'_> {
    pub(crate) fn draw(&self, root: &Area<'_>) -> Drawn {
        let (top, rest) = root.split_vertically(30 * FINE);
        draw_title(&top, self.title)?;
        let (plot, key) = rest.split_vertically(rest.dim_in_pixel().1 as i32 - 40 * FINE as i32);
        let points = || self.curves.iter().flat_map(|(_, points)| points);
        let first = points().map(|point| point.place).fold(f64::INFINITY, f64::min);
        let last = points().map(|point| point.place).fold(0.0, f64::max);
        let highest = points().map(|point| point.value).fold(0.0, f64::max);
        let mut ticks: Vec<(f64, &str)> = points()
            .filter(|point| !point.tick.is_empty())
            .map(|point| (point.place, point.tick.as_str()))
            .collect();
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
        grid.x_desc(self.x).y_desc(self.y);
        grid.draw()?;
        let mut entries = Vec::new();
        for (n, (name, points)) in self.curves.iter().enumerate() {
            let stroke = Stroke::nth(n);
            line(&mut chart, points.iter().map(|point| (point.place, point.value)).collect(), stroke)?;
            for point in points {
                let at = (point.place, point.value);
                chart.draw_series([Circle::new(at, 3 * FINE, stroke.colour.filled())])?;
                around(chart.backend_coord(&at), 6 * FINE as i32, &point.label);
            }
            entries.push((stroke, name.clone()));
        }
        legend(&key, &entries, 3)
    }
}
