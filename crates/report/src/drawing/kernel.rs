//! A kernel's texels beside its charts.

use super::canvas::{Area, Drawn, FINE, LEGEND_ROW, Stroke, anchored, font, legend, svg};
use super::chart::Chart;
use super::palette::BLACK;
use super::texels::texels as picture;
use crate::error::ReportError;
use evaluation::KernelRecord;
use plotters::prelude::{RGBColor, Rectangle, Text};
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, VPos};
use std::collections::HashMap;

/// Width of figures of kernels, and height of their titles, in pixels.
pub(crate) const WIDTH: u32 = 800;
pub(crate) const TITLE: u32 = 30;

/// A rectangle over a kernel, in texels from its upper left corner.
pub(crate) struct Outlined {
    pub(crate) corner: [f64; 2],
    pub(crate) size: [f64; 2],
    pub(crate) colour: RGBColor,
}

/// A kernel with rectangles over it as an image beside charts of this height, which stand below each other above their legend.
pub(crate) fn beside_charts(
    (id, title): (&str, &str),
    kernel: (&str, &[&KernelRecord], &[Outlined]),
    (charts, height): (&[Chart<'_>], u32),
    entries: &[(Stroke, String)],
) -> Result<String, ReportError> {
    const KERNEL: u32 = 250;
    let legend_height = LEGEND_ROW * entries.len().div_ceil(2) as u32 + 12;
    let height = height * charts.len() as u32;
    svg(id, (WIDTH, TITLE + height + legend_height), |root| {
        let (top, rest) = root.split_vertically(TITLE * FINE);
        draw_title(&top, title)?;
        let (left, right) = rest.split_horizontally(KERNEL * FINE);
        draw_kernel(&left, kernel)?;
        let (upper, lower) = right.split_vertically(height * FINE);
        for (chart, area) in charts.iter().zip(upper.split_evenly((charts.len(), 1))) {
            chart.draw(&area)?;
        }
        legend(&lower, entries, 2)
    })
}

pub(crate) fn draw_title(area: &Area<'_>, title: &str) -> Drawn {
    let middle = (area.dim_in_pixel().0 / 2) as i32;
    let style = anchored(15, HPos::Center, VPos::Center);
    area.draw(&Text::new(title.to_owned(), (middle, 17 * FINE as i32), style))?;
    Ok(())
}

/// Texels as grey squares, white at the light and black at the far plane.
fn draw_kernel(area: &Area<'_>, (name, texels, outlined): (&str, &[&KernelRecord], &[Outlined])) -> Drawn {
    let fine = FINE as i32;
    let end =
        |of: &dyn Fn(&KernelRecord) -> usize| texels.iter().map(|t| of(t) + 1).max().unwrap_or(1) as i32;
    let (across, down) = (end(&|texel| texel.x_texel), end(&|texel| texel.y_texel));
    let (left, top) = (24 * fine, 24 * fine);
    let side = (area.dim_in_pixel().0 as i32 - left - 10 * fine) / across.max(down);
    let edges = [across * side, down * side];
    let border = [(left, top), (left + edges[0], top + edges[1])];
    let greys: HashMap<(u32, u32), u8> = texels
        .iter()
        .map(|t| ((t.x_texel as u32, t.y_texel as u32), (255.0 * (1.0 - t.depth)).round() as u8))
        .collect();
    picture(area, border, [across as u32, down as u32], |x, y| {
        greys.get(&(x, y)).map(|&grey| RGBColor(grey, grey, grey))
    })?;
    area.draw(&Rectangle::new(border, BLACK.stroke_width(3)))?;
    for Outlined { corner, size, colour } in outlined {
        let place = |k: usize, share: f64| {
            let at = f64::from(side) * (corner[k] + share * size[k]);
            (at.round() as i32).clamp(0, edges[k])
        };
        let corners = [0.0, 1.0].map(|share| (left + place(0, share), top + place(1, share)));
        area.draw(&Rectangle::new(corners, colour.stroke_width(9)))?;
    }
    let below = top + edges[1] + 12 * fine;
    let lines = [
        format!("{across} x {down} texels: {name}"),
        "grey: depth, white 0 (light)".to_owned(),
        "to black 1 (far plane)".to_owned(),
    ];
    for (i, line) in lines.into_iter().enumerate() {
        area.draw(&Text::new(line, (left, below + 16 * fine * i as i32), font(12)))?;
    }
    Ok(())
}
