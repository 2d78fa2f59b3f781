//! Histograms of a candidate search (MSM15 Figure 4).

use super::summary::{Landmark, SearchTables};
use crate::drawing::{Area, Drawn, FINE, Family, GREY, anchored, mesh, spot, svg};
use crate::error::ReportError;
use crate::page::{Drawing, in_percent, percent, percent_tick};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Bins over the whole axis.
const BINS: usize = 150;

/// Height of a panel and of the row of names above it, in pixels.
const PANEL: u32 = 230;
const NAMES: u32 = 96;

/// All figures of a run.
pub(crate) fn draw(tables: &SearchTables<'_>) -> Result<Vec<Drawing>, ReportError> {
    let references = tables.landmarks();
    let marked = references.iter().map(|reference| reference.error).fold(0.01, f64::max);
    let m = tables.main_order();
    let main = svg("histogram", (820, PANEL + NAMES + 60), |root| {
        panel(root, tables, m, 1.08 * marked.max(share(tables, m, 0.995)), &references)
    })?;
    let orders = tables.orders();
    let end = 1.04 * orders.iter().map(|&m| share(tables, m, 0.95)).fold(marked, f64::max);
    let height = (PANEL - 30) * orders.len() as u32 + 20;
    let sizes = svg("sizes", (820, height), |root| {
        let areas = root.split_evenly((orders.len(), 1));
        areas.iter().zip(&orders).try_for_each(|(area, &m)| panel(area, tables, m, end, &[]))
    })?;
    Ok(vec![
        Drawing::new("histogram", "How many candidates have which error (further left is better)", main),
        Drawing::new("sizes", "The same by number of functions (further left is better)", sizes),
    ])
}

/// Error that a share of the candidates of one size does not exceed.
fn share(tables: &SearchTables<'_>, m: usize, share: f64) -> f64 {
    let all = tables.of(m);
    let place = (share * all.count() as f64) as usize;
    all.at(place).map_or(0.0, |record| record.l1_error)
}

fn panel(area: &Area<'_>, tables: &SearchTables<'_>, m: usize, end: f64, references: &[Landmark]) -> Drawn {
    let all = tables.of(m);
    let mut counts = vec![0usize; BINS];
    for (record, weight) in all.weighted().filter(|(record, _)| record.l1_error < end) {
        counts[((record.l1_error / end * BINS as f64) as usize).min(BINS - 1)] += weight;
    }
    let beyond = all.count() - counts.iter().sum::<usize>();
    let most = counts.iter().max().copied().unwrap_or_default().max(1) as f64;
    let names = if references.is_empty() { 0 } else { NAMES };
    let mut builder = ChartBuilder::on(area);
    builder.margin_left(6 * FINE).margin_right(16 * FINE).margin_top((names + 8) * FINE);
    builder.x_label_area_size(44 * FINE).y_label_area_size(64 * FINE);
    let mut chart = builder.build_cartesian_2d(0.0..end, 0.0..1.06 * most)?;
    let count = |value: &f64| format!("{value:.0}");
    let mut mesh = mesh(&mut chart, 11);
    mesh.disable_x_mesh().x_labels(12).y_labels(5);
    mesh.x_label_formatter(&|error| percent_tick(*error)).y_label_formatter(&count);
    let label = format!(
        "mean |G - F| (share of the kernel's weight); m = {m}, {} candidates, {beyond} beyond the axis",
        all.count()
    );
    mesh.x_desc(label).y_desc("candidates");
    mesh.draw()?;
    let width = end / BINS as f64;
    chart.draw_series(counts.iter().enumerate().filter(|(_, count)| **count > 0).map(|(bin, &count)| {
        let left = bin as f64 * width;
        Rectangle::new([(left + 0.06 * width, 0.0), (left + 0.94 * width, count as f64)], GREY.filled())
    }))?;
    for (bin, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let (left, right) = (bin as f64 * width, (bin + 1) as f64 * width);
        let corner = |x: f64, y: f64| chart.backend_coord(&(x, y));
        let (from, to) = (in_percent(left, 2), percent(right, 2));
        let label = format!("{from} to {to}: {count} candidates of {m} functions");
        spot([corner(left, 1.06 * most), corner(right, 0.0)], &label);
    }
    let mut sorted: Vec<&Landmark> = references.iter().collect();
    sorted.sort_by(|a, b| a.error.total_cmp(&b.error));
    for (i, reference) in sorted.iter().enumerate() {
        let colour = &Family::of(&reference.name).colour;
        let line = [(reference.error, 0.0), (reference.error, 1.06 * most)];
        chart.draw_series([PathElement::new(line, colour.stroke_width(6))])?;
        let (x, top) = chart.backend_coord(&(reference.error, 1.06 * most));
        // Names of neighbours stand in rows of their own, each at the end of its line.
        let y = top - (12 + 16 * ((sorted.len() - 1 - i) as i32 % 5)) * FINE as i32;
        area_line(area, (x, top), (x, y), colour)?;
        let text = format!("{} {}", reference.name, percent(reference.error, 2));
        let (origin_x, origin_y) = area.get_base_pixel();
        // Names near the right edge stand on the left of their line.
        let (side, gap) = if reference.error < 0.8 * end { (HPos::Left, 4) } else { (HPos::Right, -4) };
        let at = (x - origin_x + gap * FINE as i32, y - origin_y);
        area.draw(&Text::new(text, at, anchored(12, side, VPos::Center)))?;
    }
    Ok(())
}

fn area_line(area: &Area<'_>, from: (i32, i32), to: (i32, i32), colour: &RGBColor) -> Drawn {
    let (x, y) = area.get_base_pixel();
    let local = |point: (i32, i32)| (point.0 - x, point.1 - y);
    area.draw(&PathElement::new([local(from), local(to)], colour.stroke_width(6)))?;
    Ok(())
}
