//! Stacked bars: for each kind of need the scenes.

use super::summary::SpeedTables;
use crate::drawing::{Area, BLACK, Drawn, FINE, anchored, svg};
use crate::error::ReportError;
use crate::page::{Drawing, percent};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// From few to many.
const SHADES: [RGBColor; 5] = [
    RGBColor(222, 235, 247),
    RGBColor(158, 202, 225),
    RGBColor(66, 146, 198),
    RGBColor(8, 81, 156),
    RGBColor(213, 94, 0),
];

/// The figure.
pub(crate) fn needs(tables: &SpeedTables<'_>) -> Result<Drawing, ReportError> {
    let rows = tables.need_kinds().len() * (tables.scenes().len() + 1);
    let svg = svg("needs", (860, 90 + 34 * rows as u32), |root| bars(root, tables))?;
    Ok(Drawing::new("needs", "How many moments and surfaces the kernels of each scene need", svg))
}

fn bars(area: &Area<'_>, tables: &SpeedTables<'_>) -> Drawn {
    let fine = FINE as i32;
    let (left, right) = (230 * fine, area.dim_in_pixel().0 as i32 - 20 * fine);
    let mut y = 14 * fine;
    for (by, tolerance) in tables.need_kinds() {
        let title = match by {
            "rank" => format!("surfaces (rank at {tolerance:e})"),
            "gap" => format!("moments for bounds closer than {tolerance}"),
            _ => format!("moments that lose less than {tolerance} to PCF"),
        };
        area.draw(&Text::new(title, (left, y), anchored(12, HPos::Left, VPos::Center)))?;
        y += 12 * fine;
        for scene in tables.scenes().into_iter().chain(["all"]) {
            let (top, bottom) = (y, y + 22 * fine);
            let name = (left - 8 * fine, (top + bottom) / 2);
            area.draw(&Text::new(scene, name, anchored(12, HPos::Right, VPos::Center)))?;
            let mut from = 0.0;
            for (i, (needs, share)) in tables.needs(scene, by, tolerance).into_iter().enumerate() {
                let x = |share: f64| left + (f64::from(right - left) * share) as i32;
                let colour = SHADES[i.min(SHADES.len() - 1)];
                area.draw(&Rectangle::new([(x(from), top), (x(from + share), bottom)], colour.filled()))?;
                if share > 0.05 {
                    let ink = if i < 2 { &BLACK } else { &WHITE };
                    let style = anchored(11, HPos::Center, VPos::Center).color(ink);
                    let text = format!("{needs}: {}", percent(share, 0));
                    area.draw(&Text::new(text, (x(from + 0.5 * share), (top + bottom) / 2), style))?;
                }
                from += share;
            }
            y = bottom + 3 * fine;
        }
        y += 22 * fine;
    }
    Ok(())
}
