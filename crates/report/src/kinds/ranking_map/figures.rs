//! Ranks under all settings, a row each.

use super::summary::RankingTables;
use crate::drawing::{Area, Drawn, FINE, GRID, Stroke, anchored, around, legend, mesh, svg};
use crate::error::ReportError;
use crate::page::Drawing;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Height of a row in pixels.
const ROW: u32 = 22;

/// Names in the legend in one row.
const COLUMNS: usize = 2;

pub(super) fn draw(tables: &RankingTables<'_>) -> Result<Vec<Drawing>, ReportError> {
    let rows = tables.records.len() as u32;
    let lines = tables.bases().len().div_ceil(COLUMNS) as u32;
    let size = (820, ROW * rows + 70 + 20 * lines);
    let picture = svg("ranks", size, |root| panel(root, tables))?;
    let title = "Ranks of single bases under each of the settings (further left is better)";
    Ok(vec![Drawing::new("ranks", title, picture)])
}

fn panel(root: &Area<'_>, tables: &RankingTables<'_>) -> Drawn {
    let bases = tables.bases();
    let lines = bases.len().div_ceil(COLUMNS) as i32;
    let (plot, key) = root.split_vertically(root.dim_in_pixel().1 as i32 - 20 * lines * FINE as i32);
    let rows = tables.records.len() as f64;
    let last = tables.records.iter().map(|record| record.candidates).max().unwrap_or(1).max(2) as f64;
    let mut builder = ChartBuilder::on(&plot);
    builder.margin_left(6 * FINE).margin_top(8 * FINE).margin_right(16 * FINE);
    builder.x_label_area_size(42 * FINE).y_label_area_size(210 * FINE);
    let mut chart = builder.build_cartesian_2d((0.8..1.25 * last).log_scale(), rows..0.0)?;
    let mut grid = mesh(&mut chart, 11);
    grid.disable_y_mesh().y_labels(0).x_label_formatter(&|rank| format!("{rank:.0}"));
    grid.x_desc(format!("rank among {last:.0} candidates (logarithmic)"));
    grid.draw()?;
    let (left, top) = plot.get_base_pixel();
    for (row, record) in tables.records.iter().enumerate() {
        let middle = row as f64 + 0.5;
        let ends = [(0.8, middle), (1.25 * last, middle)];
        chart.draw_series([PathElement::new(ends, GRID.stroke_width(2))])?;
        let (x, y) = chart.backend_coord(&ends[0]);
        let at = (x - left - 8 * FINE as i32, y - top);
        plot.draw(&Text::new(record.variation.clone(), at, anchored(11, HPos::Right, VPos::Center)))?;
    }
    let mut entries = Vec::new();
    for (n, basis) in bases.iter().enumerate() {
        let stroke = Stroke::nth(n);
        for (row, record) in tables.records.iter().enumerate() {
            let Some(found) = tables.rank(&record.variation, basis) else { continue };
            let at = (found.rank as f64, row as f64 + 0.5);
            let fill = if stroke.dashed { stroke.style() } else { stroke.colour.filled() };
            chart.draw_series([Circle::new(at, 5 * FINE, fill)])?;
            let label = format!("{basis}, {}: rank {}", record.variation, found.rank);
            around(chart.backend_coord(&at), 6 * FINE as i32, &label);
        }
        entries.push((stroke, (*basis).to_owned()));
    }
    legend(&key, &entries, COLUMNS)
}
