//! Lines over a logarithmic axis whose values are named, as those of a sweep are.

use super::canvas::{Area, Drawn, FINE, Stroke, legend, line, mesh};
use super::hover::around;
use super::kernel::draw_title;
use plotters::prelude::{BindKeyPoints, ChartBuilder, Circle, IntoLogRange};
use plotters::style::Color;

/// Where 0 stands on a logarithmic axis, as a share of the least value above.
const ZERO: f64 = 1.0 / 3.0;

/// A dot of a line.
pub(crate) struct SeriesPoint {
    /// At least 0.
    pub(crate) x: f64,
    /// What stands below it; nothing between ticks.
    pub(crate) tick: String,
    pub(crate) y: f64,
    /// What a pointer sees.
    pub(crate) label: String,
}

/// A line with its name in the legend.
pub(crate) struct Series {
    pub(crate) name: String,
    /// Not empty.
    pub(crate) points: Vec<SeriesPoint>,
}

/// Words around a chart.
pub(crate) struct SeriesChart<'a> {
    pub(crate) title: &'a str,
    pub(crate) x_label: &'a str,
    pub(crate) y_label: &'a str,
    /// Numbers at the vertical axis.
    pub(crate) y_tick: &'a dyn Fn(&f64) -> String,
}

impl SeriesChart<'_> {
    pub(crate) fn draw(&self, root: &Area<'_>, curves: &[Series]) -> Drawn {
        let (top, rest) = root.split_vertically(30 * FINE);
        draw_title(&top, self.title)?;
        let lines = curves.len().div_ceil(3).max(2) as i32;
        let (plot, key) = rest.split_vertically(rest.dim_in_pixel().1 as i32 - 20 * lines * FINE as i32);
        let points = || curves.iter().flat_map(|series| &series.points);
        let least = points().map(|p| p.x).filter(|&x| x > 0.0).fold(f64::INFINITY, f64::min);
        let place = |p: &SeriesPoint| if p.x > 0.0 { p.x } else { ZERO * least };
        let first = points().map(place).fold(f64::INFINITY, f64::min);
        let last = points().map(|p| p.x).fold(0.0, f64::max);
        let highest = points().map(|p| p.y).fold(0.0, f64::max);
        let named = points().filter(|p| !p.tick.is_empty());
        let mut ticks: Vec<(f64, &str)> = named.map(|p| (place(p), p.tick.as_str())).collect();
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
        grid.x_label_formatter(&tick).y_label_formatter(&self.y_tick).y_labels(7);
        grid.x_desc(self.x_label).y_desc(self.y_label);
        grid.draw()?;
        let mut entries = Vec::new();
        let strokes = Stroke::of_techniques(curves.iter().map(|series| series.name.as_str()));
        for (series, stroke) in curves.iter().zip(strokes) {
            line(&mut chart, series.points.iter().map(|p| (place(p), p.y)).collect(), stroke)?;
            for point in &series.points {
                let at = (place(point), point.y);
                chart.draw_series([Circle::new(at, 3 * FINE, stroke.colour.filled())])?;
                around(chart.backend_coord(&at), 6 * FINE as i32, &point.label);
            }
            entries.push((stroke, series.name.clone()));
        }
        legend(&key, &entries, 3)
    }
}
