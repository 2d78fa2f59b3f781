//! The figures of a stability experiment: heat maps over the knobs, and failures by moment bias.

use super::steps::{Cross, LEAST, MARKS, STEP_COLOURS, letters, step};
use super::summary::{Inputs, StabilityTables};
use crate::drawing::{
    Area, Drawn, EMPTY, FINE, LEGEND_ROW, Stroke, anchored, around, font, grid, legend, line, mesh,
    power_of_ten, svg, texels,
};
use crate::error::ReportError;
use crate::kinds::rows::distinct;
use crate::page::Drawing;
use evaluation::{CellRecord, MomentBound, Span};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Bounds with the file stem and title of their heat maps.
const ATLASES: [(MomentBound, &str, &str); 6] = [
    (MomentBound::Hamburger2, "atlas-hamburger-2", "Two moments on the line: largest error in each cell"),
    (MomentBound::Hamburger4, "atlas-hamburger-4", "Four moments on the line: largest error in each cell"),
    (MomentBound::Hamburger6, "atlas-hamburger-6", "Six moments on the line: largest error in each cell"),
    (MomentBound::Hamburger8, "atlas-hamburger-8", "Eight moments on the line: largest error in each cell"),
    (MomentBound::Hausdorff4, "atlas-hausdorff-4", "Four moments on [0, 1]: largest error in each cell"),
    (
        MomentBound::Trigonometric4,
        "atlas-trigonometric-4",
        "Four trigonometric moments: largest error in each cell",
    ),
];

/// All figures of a run.
pub(crate) fn draw(tables: &StabilityTables<'_>) -> Result<Vec<Drawing>, ReportError> {
    let mut figures = Vec::new();
    for (bound, id, title) in ATLASES {
        let method = |m: &usize| tables.experiment.technique[*m].bound() == Some(bound);
        let mut methods = distinct(tables.cells.iter().map(|c| c.method).filter(method));
        methods.sort_unstable();
        if !methods.is_empty() {
            figures.push(Drawing::new(id, title, atlas(tables, id, title, &methods)?));
        }
    }
    let title = "Inputs whose bound is broken, by moment bias (lower and further left is better)";
    figures.push(Drawing::new("alpha", title, over_alpha(tables)?));
    Ok(figures)
}

/// Side of a heat map, room for its labels.
const MAP: u32 = 92;
const BELOW: u32 = 38;
const LEFT: u32 = 184;
const BETWEEN: u32 = 68;
const ABOVE: u32 = 62;

fn atlas(
    tables: &StabilityTables<'_>,
    id: &str,
    title: &str,
    methods: &[usize],
) -> Result<String, ReportError> {
    let families = &tables.experiment.family;
    let width = LEFT + families.len() as u32 * (MAP + BETWEEN);
    let height = ABOVE + methods.len() as u32 * (MAP + BELOW) + 20;
    let fine = FINE as i32;
    svg(id, (width, height), |root| {
        let text = |content: &str, x: i32, y: i32, pixels: u32, horizontal: HPos| {
            let style = anchored(pixels, horizontal, VPos::Center);
            root.draw(&Text::new(content.to_owned(), (x * fine, y * fine), style))
        };
        text(title, 10, 14, 14, HPos::Left)?;
        scale(root, width as i32)?;
        for (column, family) in families.iter().enumerate() {
            let x = (LEFT + column as u32 * (MAP + BETWEEN)) as i32;
            text(&family.name, x + MAP as i32 / 2, 48, 12, HPos::Center)?;
        }
        for (row, &method) in methods.iter().enumerate() {
            let y = (ABOVE + row as u32 * (MAP + BELOW)) as i32;
            let name = &tables.experiment.technique[method].name;
            let short = name.split_once(", ").map_or(name.as_str(), |(_, short)| short);
            text(short, 10, y + MAP as i32 / 2 - 8, 12, HPos::Left)?;
            let alpha = format!("alpha = {:e}", tables.experiment.technique[method].alpha());
            text(&alpha, 10, y + MAP as i32 / 2 + 8, 11, HPos::Left)?;
            for (column, family) in families.iter().enumerate() {
                let x = (LEFT + column as u32 * (MAP + BETWEEN)) as i32;
                let mine = |c: &&CellRecord| c.method == method && c.family == column;
                let cells: Vec<&CellRecord> = tables.cells.iter().filter(mine).collect();
                heat_map(root, (x, y), &cells, tables.experiment.cells)?;
                let corners = [(x * fine, y * fine), ((x + MAP as i32) * fine, (y + MAP as i32) * fine)];
                let [knob_x, knob_y] = family.shape.knobs();
                let spans = [(knob_x, family.x.from, family.x.to), (knob_y, family.y.from, family.y.to)];
                let title = format!("{name}: {}", family.name);
                grid(corners, &title, spans, &letters(&cells, tables.experiment.cells));
                axes(root, (x, y), (family.x, family.y), family.shape.knobs())?;
            }
        }
        Ok(())
    })
}

/// The colour scale and the marks, at the top right.
fn scale(root: &Area<'_>, width: i32) -> Drawn {
    let fine = FINE as i32;
    let first = width - 620;
    let style = || anchored(11, HPos::Center, VPos::Center);
    for (i, colour) in STEP_COLOURS.iter().enumerate() {
        let x = first + 34 * i as i32;
        root.draw(&Rectangle::new([(x * fine, 8 * fine), ((x + 34) * fine, 18 * fine)], colour.filled()))?;
        if i > 0 {
            let label = format!("1e{}", LEAST + i as i32 - 1);
            root.draw(&Text::new(label, (x * fine, 26 * fine), style()))?;
        }
    }
    let x = first + 34 * STEP_COLOURS.len() as i32 + 20;
    mark(root, (x, 13), 6, &MARKS[0])?;
    let left = || anchored(11, HPos::Left, VPos::Center);
    root.draw(&Text::new("visible false shadow", ((x + 12) * fine, 13 * fine), left()))?;
    mark(root, (x + 160, 13), 6, &MARKS[1])?;
    root.draw(&Text::new("no number", ((x + 172) * fine, 13 * fine), left()))?;
    Ok(())
}

fn mark(root: &Area<'_>, (x, y): (i32, i32), size: i32, mark: &Cross) -> Drawn {
    let fine = FINE as i32;
    for arm in mark.arms {
        let ends = arm.map(|(dx, dy)| (x * fine + dx * size * fine / 2, y * fine + dy * size * fine / 2));
        root.draw(&PathElement::new(ends, mark.colour.stroke_width(5)))?;
    }
    Ok(())
}

/// Colours of cells over the ground that cells without inputs show.
fn heat_map(root: &Area<'_>, (x, y): (i32, i32), cells: &[&CellRecord], count: usize) -> Drawn {
    let fine = FINE as i32;
    let edge = |i: usize| (MAP as usize * FINE as usize * i / count) as i32;
    let (left, bottom) = (x * fine, (y + MAP as i32) * fine);
    let whole = [(left, y * fine), (left + edge(count), bottom)];
    root.draw(&Rectangle::new(whole, EMPTY.filled()))?;
    let mut steps = vec![None; count * count];
    for cell in cells.iter().filter(|c| c.x < count && c.y < count) {
        steps[(count - 1 - cell.y) * count + cell.x] = Some(step(cell.error_max));
    }
    texels(root, whole, [count as u32; 2], |x, y| {
        steps[y as usize * count + x as usize].map(|step| STEP_COLOURS[step])
    })?;
    for cell in cells {
        let centre =
            ((left + edge(cell.x) + edge(1) / 2) / fine, (bottom - edge(cell.y) - edge(1) / 2) / fine);
        if cell.not_finite > 0 {
            mark(root, centre, 4, &MARKS[1])?;
        } else if cell.visible > 0 {
            mark(root, centre, 4, &MARKS[0])?;
        }
    }
    Ok(())
}

fn axes(root: &Area<'_>, (x, y): (i32, i32), spans: (Span, Span), knobs: [&str; 2]) -> Drawn {
    let fine = FINE as i32;
    let size = MAP as i32;
    let number = |value: f64| format!("{value:.0e}");
    let text = |content: String, x: i32, y: i32, horizontal: HPos, vertical: VPos, turned: bool| {
        let mut style = anchored(11, horizontal, vertical);
        if turned {
            style = style.transform(FontTransform::Rotate270);
        }
        root.draw(&Text::new(content, (x * fine, y * fine), style))
    };
    text(number(spans.0.from), x, y + size + 2, HPos::Left, VPos::Top, false)?;
    text(number(spans.0.to), x + size, y + size + 2, HPos::Right, VPos::Top, false)?;
    text(knobs[0].to_owned(), x + size / 2, y + size + 15, HPos::Center, VPos::Top, false)?;
    text(number(spans.1.from), x - 2, y + size - 4, HPos::Right, VPos::Center, false)?;
    text(number(spans.1.to), x - 2, y + 4, HPos::Right, VPos::Center, false)?;
    text(knobs[1].to_owned(), x - 38, y + size / 2, HPos::Center, VPos::Center, true)?;
    Ok(())
}

/// Shares below this are drawn at the bottom: they are zero, or nearly so.
const LEAST_SHARE: f64 = 1e-5;

/// A row of panels for each bound: hard inputs and scenes.
fn over_alpha(tables: &StabilityTables<'_>) -> Result<String, ReportError> {
    const PANEL: u32 = 230;
    let rows: Vec<(&str, Vec<&str>)> = ATLASES
        .iter()
        .filter_map(|(bound, ..)| {
            let methods: Vec<&str> = tables
                .experiment
                .technique
                .iter()
                .filter(|m| m.bound() == Some(*bound))
                .map(|m| m.name.as_str())
                .collect();
            (!methods.is_empty()).then_some((bound.name(), methods))
        })
        .collect();
    let legend_rows = |methods: &[&str]| methods.len().div_ceil(3) as u32 + 1;
    let height: u32 = rows.iter().map(|(_, methods)| PANEL + legend_rows(methods) * LEGEND_ROW).sum();
    svg("alpha", (900, height), |root| {
        let mut rest = root.clone();
        for (name, methods) in &rows {
            let (row, below) =
                rest.split_vertically(((PANEL + legend_rows(methods) * LEGEND_ROW) * FINE) as i32);
            rest = below;
            let (panels, names) = row.split_vertically((PANEL * FINE) as i32);
            for (area, inputs) in panels.split_evenly((1, 2)).iter().zip([Inputs::Hard, Inputs::Scenes]) {
                panel(area, tables, name, methods, inputs)?;
            }
            let entries: Vec<(Stroke, String)> = methods
                .iter()
                .enumerate()
                .map(|(i, method)| (Stroke::nth(i), (*method).to_owned()))
                .collect();
            legend(&names, &entries, 3)?;
        }
        Ok(())
    })
}

fn panel(
    area: &Area<'_>,
    tables: &StabilityTables<'_>,
    name: &str,
    methods: &[&str],
    inputs: Inputs,
) -> Drawn {
    let lines: Vec<Vec<(f64, f64)>> =
        methods.iter().map(|method| tables.shares(method, inputs, |r| r.violated)).collect();
    let alphas = || lines.iter().flatten().map(|p| p.0).filter(|&alpha| alpha > 0.0);
    let (from, to) = alphas().fold((1.0f64, 0.0f64), |(from, to), x| (from.min(x), to.max(x)));
    if from >= to {
        return Ok(());
    }
    let what = if inputs == Inputs::Hard { "hard inputs" } else { "scenes" };
    let mut builder = ChartBuilder::on(area);
    builder.margin_left(6 * FINE).margin_right(14 * FINE).margin_top(6 * FINE);
    builder.caption(format!("{name}, {what}"), font(13));
    builder.x_label_area_size(38 * FINE).y_label_area_size(58 * FINE);
    let bottom = LEAST_SHARE.log10();
    let mut chart = builder.build_cartesian_2d((from..to).log_scale(), bottom - 0.2..0.1)?;
    let share = |y: &f64| if *y < bottom + 0.1 { "none".to_owned() } else { format!("1e{y:.0}") };
    let mut mesh = mesh(&mut chart, 11);
    mesh.x_labels(8).y_labels(6).x_label_formatter(&power_of_ten).y_label_formatter(&share);
    mesh.x_desc("moment bias alpha").y_desc("share with a broken bound").draw()?;
    for (i, (shares, method)) in lines.iter().zip(methods).enumerate() {
        let stroke = Stroke::nth(i);
        let points: Vec<(f64, f64)> = shares
            .iter()
            .filter(|(alpha, _)| *alpha > 0.0)
            .map(|&(alpha, share)| (alpha, share.max(LEAST_SHARE).log10()))
            .collect();
        line(&mut chart, points.clone(), stroke)?;
        for &(alpha, height) in &points {
            let share =
                if height <= bottom { "none".to_owned() } else { format!("{:.1e}", 10f64.powf(height)) };
            let label = format!("{method}, alpha = {alpha:.1e}: {share} with a broken bound");
            around(chart.backend_coord(&(alpha, height)), 4 * FINE as i32, &label);
        }
        let own = tables.experiment.technique.iter().find(|m| m.name == **method).map_or(0.0, |m| m.alpha());
        let is_own = |p: &&(f64, f64)| (p.0 / own - 1.0).abs() < 1e-2;
        if let Some(&point) = points.iter().find(is_own) {
            chart.draw_series([Circle::new(point, 3 * FINE, stroke.colour.filled())])?;
        }
    }
    Ok(())
}
