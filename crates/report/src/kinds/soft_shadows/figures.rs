//! The figures of a `soft-shadows` run: errors of all techniques, sweeps, single receivers, sheets of error maps.

use super::receiver;
use super::summary::SoftTables;
use super::sweeps;
use crate::drawing::{
    Area, BLUE, Drawn, ErrorColours, FINE, GRID, TITLE, VERMILLION, WIDTH, anchored, around, draw_title,
    error_sheet, mesh, svg,
};
use crate::error::ReportError;
use crate::page::{Drawing, percent};
use evaluation::{Population, RunDirectory, SoftRecord, map_name};
use plotters::prelude::{ChartBuilder, Circle, PathElement, RGBColor, Text};
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, VPos};

/// What a pixel of an error map shows.
const PIXEL: [&str; 2] =
    ["method minus truth at each pixel; pixels", "that do not face the light count as right"];

pub(super) fn draw(run: &RunDirectory, tables: &SoftTables<'_>) -> Result<Vec<Drawing>, ReportError> {
    let mut figures = Vec::new();
    for light in tables.lights() {
        figures.extend(errors(tables, light)?);
    }
    figures.extend(sweeps::charts(tables)?);
    figures.extend(tables.gpu_charts()?);
    figures.extend(receiver::draw(tables)?);
    for picture in &tables.experiment.picture {
        let tiles: Vec<_> = picture
            .techniques
            .iter()
            .map(|name| (name.clone(), run.path().join(map_name(&picture.id, &picture.light, name))))
            .collect();
        for (what, colours) in [("error", ErrorColours::Magnitude), ("leak", ErrorColours::Signed)] {
            let words = if what == "error" { "|method - truth|" } else { "method - truth" };
            let title = format!("{words}, {}, light \"{}\"", picture.scene, picture.light);
            let sheet = error_sheet(&tiles, &title, colours, PIXEL)?;
            figures.push(Drawing::new(format!("{what}-{}", picture.id), title, sheet));
        }
    }
    Ok(figures)
}

/// A row a technique, with a dot for fragments and one for the camera.
fn errors(tables: &SoftTables<'_>, light: &str) -> Result<Option<Drawing>, ReportError> {
    const ROW: u32 = 19;
    let of = |population| {
        let techniques = tables.experiment.technique.iter();
        techniques.filter_map(|t| tables.whole(light, population, &t.name)).collect::<Vec<&SoftRecord>>()
    };
    let (mut fragments, camera) = (of(Population::Fragments), of(Population::Camera));
    if fragments.is_empty() {
        return Ok(None);
    }
    fragments.sort_by(|a, b| b.mean_error.total_cmp(&a.mean_error));
    let id = format!("errors-{}", tables.experiment.scenery.words(light));
    let title = format!("Mean distance from the area light, light \"{light}\" (less is better)");
    let height = TITLE + ROW * fragments.len() as u32 + 84;
    let picture = svg(&id, (WIDTH, height), |root| {
        let (top, rest) = root.split_vertically(TITLE * FINE);
        draw_title(&top, &title)?;
        dots(&rest, &fragments, &camera)
    })?;
    Ok(Some(Drawing::new(id, title, picture)))
}

fn dots(area: &Area<'_>, fragments: &[&SoftRecord], camera: &[&SoftRecord]) -> Drawn {
    let (plot, key) = area.split_vertically(area.dim_in_pixel().1 as i32 - 26 * FINE as i32);
    let all = fragments.iter().chain(camera);
    let most = all.map(|r| r.mean_error).fold(0.0, f64::max).max(1e-6);
    let mut builder = ChartBuilder::on(&plot);
    builder.margin_left(6 * FINE).margin_top(4 * FINE).margin_right(20 * FINE);
    builder.x_label_area_size(42 * FINE).y_label_area_size(190 * FINE);
    let rows = fragments.len() as f64;
    let mut chart = builder.build_cartesian_2d(0.0..1.08 * most, -0.5..rows - 0.5)?;
    let mut grid = mesh(&mut chart, 11);
    grid.x_label_formatter(&|error| percent(*error, 1)).x_desc("mean |method - truth|, of the light");
    grid.disable_y_axis().disable_y_mesh().draw()?;
    for (place, row) in fragments.iter().enumerate() {
        let y = place as f64;
        let seen = camera.iter().find(|r| r.technique == row.technique);
        let (x, at) = (row.mean_error, chart.backend_coord(&(0.0, y)));
        let (left, above) = area.get_base_pixel();
        let label = anchored(12, HPos::Right, VPos::Center);
        area.draw(&Text::new(row.technique.clone(), (at.0 - left - 8 * FINE as i32, at.1 - above), label))?;
        if let Some(seen) = seen {
            chart.draw_series([PathElement::new([(x, y), (seen.mean_error, y)], GRID.stroke_width(4))])?;
            chart.draw_series([Circle::new((seen.mean_error, y), 4 * FINE, VERMILLION.filled())])?;
            let at = chart.backend_coord(&(seen.mean_error, y));
            around(
                at,
                5 * FINE as i32,
                &format!("{}, camera: {}", row.technique, percent(seen.mean_error, 2)),
            );
        }
        let margin = row.standard_error.map_or(0.0, |e| 2.0 * e);
        chart.draw_series([PathElement::new([(x - margin, y), (x + margin, y)], BLUE.stroke_width(4))])?;
        chart.draw_series([Circle::new((x, y), 4 * FINE, BLUE.filled())])?;
        let at = chart.backend_coord(&(x, y));
        around(at, 5 * FINE as i32, &format!("{}, fragments: {}", row.technique, percent(x, 2)));
    }
    let entries: [(RGBColor, &str, i32); 2] = [
        (BLUE, "all fragments that light could reach, with twice the standard error", 200),
        (VERMILLION, "what the camera sees", 600),
    ];
    for (colour, text, x) in entries {
        let at = (x * FINE as i32, 12 * FINE as i32);
        key.draw(&Circle::new(at, 4 * FINE, colour.filled()))?;
        let style = anchored(12, HPos::Left, VPos::Center);
        key.draw(&Text::new(text, (at.0 + 10 * FINE as i32, at.1), style))?;
    }
    Ok(())
}
