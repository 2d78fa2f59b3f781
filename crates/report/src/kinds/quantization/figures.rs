//! The figures of a quantisation experiment: hulls, stored codes, failures and errors against the moment bias.

use super::summary::QuantizationTables;
use crate::drawing::{
    Area, BLACK, CURVE_COLOURS, Drawn, FINE, GRID, LEGEND_ROW, Stroke, anchored, around, font, legend, line,
    mesh, power_of_ten, svg,
};
use crate::error::ReportError;
use crate::kinds::rows::distinct;
use crate::page::{Drawing, percent};
use evaluation::{CodeRecord, HullRecord, QuantizationRecord};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// All figures of a run.
pub(crate) fn draw(tables: &QuantizationTables<'_>) -> Result<Vec<Drawing>, ReportError> {
    let mut figures = vec![Drawing::new(
        "hulls",
        "The curve of three power moments and its convex hull in the box of stored values (a larger hull is better)",
        hulls(tables)?,
    )];
    if !tables.codes.is_empty() {
        let title = "How often which values are stored (flatter is better)";
        figures.push(Drawing::new("codes", title, codes(tables)?));
    }
    let bounds = bounds(tables);
    if !bounds.is_empty() {
        let title = "Invalid moment vectors by moment bias (lower and further left is better)";
        figures.push(Drawing::new("failures", title, over_alpha(tables, &bounds, &FAILURES)?));
        let title = "Error against PCF by moment bias (lower is better)";
        figures.push(Drawing::new("errors", title, over_alpha(tables, &bounds, &ERRORS)?));
    }
    Ok(figures)
}

fn hulls(tables: &QuantizationTables<'_>) -> Result<String, ReportError> {
    svg("hulls", (820, 400), |root| {
        let panels = root.split_evenly((1, 2));
        for (panel, curve) in panels.iter().zip(["original", "transformed"]) {
            let points: Vec<&HullRecord> = tables.hull.iter().filter(|p| p.curve == curve).collect();
            hull(panel, curve, &points)?;
        }
        Ok(())
    })
}

/// Parallel projection of the unit box onto the panel; the third axis points up.
fn project(p: [f64; 3]) -> (f64, f64) {
    let (turn, tilt) = (0.55f64, 0.42f64);
    let (x, y, z) = (p[0] - 0.5, p[1] - 0.5, p[2] - 0.5);
    let (right, back) = (x * turn.cos() + y * turn.sin(), y * turn.cos() - x * turn.sin());
    (right, z * tilt.cos() + back * tilt.sin())
}

fn hull(area: &Area<'_>, curve: &str, points: &[&HullRecord]) -> Drawn {
    let mut builder = ChartBuilder::on(area);
    builder.margin(10 * FINE).margin_top(44 * FINE);
    let (height, width) = (area.dim_in_pixel().1 as f64, area.dim_in_pixel().0 as f64);
    // Same scale along both axes.
    let half = 0.86;
    let wide = half * (width - f64::from(20 * FINE)) / (height - f64::from(54 * FINE));
    let mut chart = builder.build_cartesian_2d(-wide..wide, -half..half)?;
    let corner = |i: usize| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f64);
    for i in 0..8usize {
        for axis in [1, 2, 4] {
            if i & axis == 0 {
                let edge = [project(corner(i)), project(corner(i | axis))];
                chart.draw_series([PathElement::new(edge, GRID.stroke_width(4))])?;
            }
        }
    }
    let at = |p: &HullRecord| project([p.x, p.y, p.z]);
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return Ok(()) };
    for (end, colour) in [(first, CURVE_COLOURS[1]), (last, CURVE_COLOURS[5])] {
        for edge in points.windows(2) {
            let face = vec![at(end), at(edge[0]), at(edge[1])];
            chart.draw_series([Polygon::new(face, colour.mix(0.18).filled())])?;
        }
        for point in points.iter().step_by((points.len() / 40).max(1)) {
            let line = PathElement::new([at(end), at(point)], colour.mix(0.6).stroke_width(1));
            chart.draw_series([line])?;
        }
    }
    let line: Vec<(f64, f64)> = points.iter().map(|p| at(p)).collect();
    chart.draw_series([PathElement::new(line, BLACK.stroke_width(7))])?;
    for (axis, name) in [(1, "1"), (2, "2"), (4, "3")] {
        let end = project(corner(axis));
        let style = anchored(12, HPos::Center, VPos::Center);
        chart.draw_series([Text::new(format!("value {name}"), (end.0, end.1 + 0.05), style)])?;
    }
    let what = if curve == "original" { "z, z^2, z^3" } else { "after the best transform" };
    let title = format!("{what}: hull of volume {:.4}", first.hull_volume);
    let middle = (area.dim_in_pixel().0 as i32 / 2, 22 * FINE as i32);
    area.draw(&Text::new(title, middle, anchored(13, HPos::Center, VPos::Center)))?;
    Ok(())
}

/// A row of histograms for each transform in the first format of those that were counted.
fn codes(tables: &QuantizationTables<'_>) -> Result<String, ReportError> {
    let Some(first) = tables.codes.first() else {
        return Err(ReportError::Empty { figure: "codes".to_owned() });
    };
    let shown = |c: &&CodeRecord| c.bound == first.bound && c.format == first.format;
    let transforms = distinct(tables.codes.iter().filter(shown).map(|code| code.transform.as_str()));
    let channels = tables.codes.iter().filter(shown).map(|c| c.channel).max().unwrap_or_default() + 1;
    let most = tables.codes.iter().filter(shown).map(|c| c.share).fold(0.0, f64::max);
    svg("codes", (860, 40 + 170 * transforms.len() as u32), |root| {
        let (top, rest) = root.split_vertically(36 * FINE);
        let title = format!("{}, {}: share of filtered texels by stored value", first.bound, first.format);
        top.draw(&Text::new(
            title,
            (12 * FINE as i32, 18 * FINE as i32),
            anchored(13, HPos::Left, VPos::Center),
        ))?;
        for (row, transform) in rest.split_evenly((transforms.len(), 1)).iter().zip(&transforms) {
            for (channel, area) in row.split_evenly((1, channels)).iter().enumerate() {
                let bins: Vec<&CodeRecord> = tables
                    .codes
                    .iter()
                    .filter(shown)
                    .filter(|c| c.transform == *transform && c.channel == channel)
                    .collect();
                histogram(area, transform, &bins, most)?;
            }
        }
        Ok(())
    })
}

fn histogram(area: &Area<'_>, transform: &str, bins: &[&CodeRecord], most: f64) -> Drawn {
    let Some(first) = bins.first() else { return Ok(()) };
    let caption = format!("{transform}, value {}: {:.1} bits", first.channel + 1, first.entropy_bits);
    let mut builder = ChartBuilder::on(area);
    builder.margin_right(8 * FINE).margin_top(4 * FINE).caption(caption, font(11));
    builder.x_label_area_size(20 * FINE).y_label_area_size(38 * FINE);
    // A few bins hold most of the texels: on a logarithmic axis the others are seen too.
    let least = 1e-5;
    let mut chart =
        builder.build_cartesian_2d(0.0..1.0, (least..most.max(10.0 * least) * 1.2).log_scale())?;
    let mut mesh = mesh(&mut chart, 11);
    mesh.disable_x_mesh().x_labels(3).y_labels(5);
    mesh.x_label_formatter(&|x| format!("{x:.1}")).y_label_formatter(&power_of_ten);
    mesh.set_all_tick_mark_size(3 * FINE).draw()?;
    let width = 1.0 / bins.len() as f64;
    chart.draw_series(bins.iter().filter(|bin| bin.share > least).map(|bin| {
        Rectangle::new([(bin.from, least), (bin.from + width, bin.share)], CURVE_COLOURS[1].filled())
    }))?;
    Ok(())
}

/// What is drawn over the moment bias.
struct Quantity {
    figure: &'static str,
    label: &'static str,
    value: fn(&QuantizationRecord) -> Option<f64>,
    /// Whether the error without quantisation is drawn.
    floor: bool,
}

const NOT_QUANTISED: Stroke = Stroke { colour: BLACK, width: 4, dashed: true };

/// Shares of less than one fragment in a hundred thousand are not known.
const LEAST_SHARE: f64 = 1e-5;

const FAILURES: Quantity = Quantity {
    figure: "failures",
    label: "share of invalid vectors",
    value: |r| r.failure_share,
    floor: false,
};
const ERRORS: Quantity =
    Quantity { figure: "errors", label: "mean |G - F|", value: |r| Some(r.l1_error), floor: true };

/// Bounds with their filter, in the order of the records.
fn bounds<'a>(tables: &'a QuantizationTables<'_>) -> Vec<(&'a str, &'a str)> {
    let steps = tables.records.iter().filter(|r| r.role == "step");
    distinct(steps.map(|r| (r.bound.as_str(), r.kernel.as_str())))
}

/// One panel a bound: all its transforms and formats over alpha, with the b* that is fastest (else the first).
fn over_alpha(
    tables: &QuantizationTables<'_>,
    bounds: &[(&str, &str)],
    quantity: &Quantity,
) -> Result<String, ReportError> {
    const PANEL: u32 = 290;
    let columns = 2.min(bounds.len());
    let rows = bounds.len().div_ceil(columns);
    svg(quantity.figure, (500 * columns as u32, (PANEL + 5 * LEGEND_ROW) * rows as u32), |root| {
        for (area, &bound) in root.split_evenly((rows, columns)).iter().zip(bounds) {
            panel(area, tables, bound, quantity)?;
        }
        Ok(())
    })
}

/// Biases and values of one transform and format.
type Line<'a> = ((&'a str, &'a str, &'a str), Vec<(f64, f64)>);

fn panel(
    area: &Area<'_>,
    tables: &QuantizationTables<'_>,
    (bound, kernel): (&str, &str),
    quantity: &Quantity,
) -> Drawn {
    let mut lines: Vec<Line<'_>> = Vec::new();
    let mut targets: Vec<&str> = Vec::new();
    let steps =
        || tables.records.iter().filter(|r| r.role == "step" && r.bound == bound && r.kernel == kernel);
    for r in steps() {
        let key = (r.transform.as_str(), r.range.as_str(), r.format.as_str());
        let place = lines.iter().position(|(known, _)| *known == key).unwrap_or_else(|| {
            targets.push(&r.target);
            lines.push((key, Vec::new()));
            lines.len() - 1
        });
        if let (true, Some(value)) = (targets[place] == r.target, (quantity.value)(r)) {
            lines[place].1.push((r.alpha, value));
        }
    }
    let all = || lines.iter().flat_map(|(_, points)| points);
    let (from, to) = all().fold((1.0, 0.0f64), |(from, to), &(x, _)| (x.min(from), x.max(to)));
    let exact = tables.exact(bound, kernel).filter(|_| quantity.floor);
    let most = all().map(|&(_, y)| y).fold(0.0, f64::max);
    // Errors far above the best ones need no room.
    let (least, top) = match exact {
        Some(exact) => (0.9 * exact, most.min(2.2 * exact).max(1.1 * exact)),
        None if quantity.floor => (0.0, most.max(1e-3)),
        None => (LEAST_SHARE.log10(), 0.05),
    };
    let rows = lines.len().div_ceil(2) + 1;
    let (_, height) = area.dim_in_pixel();
    let (upper, lower) = area.split_vertically(height as i32 - (rows as u32 * LEGEND_ROW * FINE) as i32);
    let mut builder = ChartBuilder::on(&upper);
    builder.margin_left(6 * FINE).margin_right(14 * FINE).margin_top(6 * FINE);
    builder.caption(format!("{bound}, {kernel}x{}", kernel.rsplit(' ').next().unwrap_or_default()), font(13));
    builder.x_label_area_size(38 * FINE).y_label_area_size(58 * FINE);
    let mut chart = builder.build_cartesian_2d((from..to).log_scale(), least..top)?;
    let value = |y: &f64| if quantity.floor { percent(*y, 1) } else { format!("1e{y:.0}") };
    let mut mesh = mesh(&mut chart, 11);
    mesh.x_labels(8).y_labels(6).x_label_formatter(&power_of_ten).y_label_formatter(&value);
    mesh.x_desc("moment bias alpha").y_desc(quantity.label).draw()?;
    if let Some(exact) = exact {
        line(&mut chart, vec![(from, exact), (to, exact)], NOT_QUANTISED)?;
    }
    let mut entries = Vec::new();
    for (i, ((transform, range, format), points)) in lines.iter().enumerate() {
        let stroke = Stroke::nth(i);
        let height = |y: f64| if quantity.floor { y } else { y.max(f64::MIN_POSITIVE).log10() };
        let points: Vec<(f64, f64)> = points.iter().map(|&(x, y)| (x, height(y))).collect();
        for &(x, y) in points.iter().filter(|(_, y)| (least..=top).contains(y)) {
            let shown = if quantity.floor { percent(y, 2) } else { format!("{:.1e}", 10f64.powf(y)) };
            let label = format!("{transform} ({range}), {format}, alpha = {x:.1e}: {shown}");
            around(chart.backend_coord(&(x, y)), 5 * FINE as i32, &label);
        }
        for piece in points.split(|&(_, y)| y < least || y > top) {
            line(&mut chart, piece.to_vec(), stroke)?;
        }
        // The range is told where a name stands for two.
        let twice = lines.iter().filter(|((t, _, f), _)| (t, f) == (transform, format)).count() > 1;
        let range = if twice { format!(" ({range})") } else { String::new() };
        entries.push((stroke, format!("{transform}{range}, {format}")));
    }
    if exact.is_some() {
        entries.push((NOT_QUANTISED, "not quantised".to_owned()));
    }
    legend(&lower, &entries, 2)
}
