//! Charts of a `speed-accuracy` run: error against cost, memory and time, and what kernels need.

use super::needs::needs;
use super::summary::SpeedTables;
use crate::drawing::{
    Area, BLACK, BLUE, Drawn, FINE, GREEN, GRID, ORANGE, PURPLE, SKY_BLUE, VERMILLION, anchored, around,
    mesh, svg,
};
use crate::error::ReportError;
use crate::page::{Drawing, percent};
use evaluation::SpeedAccuracyRecord;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

const GREY: RGBColor = RGBColor(110, 110, 110);

/// Techniques that have a colour together.
pub(super) struct Family {
    /// How their names begin, and what the page's filters call them.
    pub(super) name: &'static str,
    pub(super) colour: RGBColor,
    /// In the legend.
    label: &'static str,
}

pub(super) const FAMILIES: [Family; 8] = [
    Family { name: "VSM", colour: ORANGE, label: "VSM" },
    Family { name: "ESM", colour: PURPLE, label: "ESM" },
    Family { name: "EVSM", colour: VERMILLION, label: "EVSM" },
    Family { name: "LVSM", colour: RGBColor(150, 110, 70), label: "LVSM" },
    Family { name: "CSM", colour: GREEN, label: "CSM" },
    Family { name: "Hamburger", colour: BLUE, label: "Hamburger 4, 6, 8" },
    Family { name: "Hausdorff", colour: SKY_BLUE, label: "Hausdorff 4" },
    Family { name: "Trigonometric", colour: BLACK, label: "trigonometric 4" },
];

/// PCF and plain shadow maps.
pub(super) const OTHERS: Family = Family { name: "PCF", colour: GREY, label: "not filterable (PCF)" };

/// EVSM before VSM would match, too, but names begin with the family.
pub(super) fn family(technique: &str) -> &'static Family {
    FAMILIES.iter().find(|family| technique.starts_with(family.name)).unwrap_or(&OTHERS)
}

/// A technique in a chart.
struct Marker {
    x: f64,
    /// Interval of x, where it was measured.
    x_range: Option<(f64, f64)>,
    y: f64,
    y_margin: f64,
    colour: RGBColor,
    /// 0 for the largest map, 1 for a half, 2 for a quarter.
    shape: u32,
    name: String,
    on_front: bool,
    /// Percentage-closer filtering, which is shown but does not compete.
    compared: bool,
}

struct Scatter<'a> {
    x_label: &'a str,
    marks: Vec<Marker>,
    sizes: Vec<u32>,
}

/// All figures of a run.
pub(crate) fn draw(tables: &SpeedTables<'_>) -> Result<Vec<Drawing>, ReportError> {
    let sizes = tables.sizes();
    let mark = |r: &SpeedAccuracyRecord, x: f64, x_range: Option<(f64, f64)>| Marker {
        x,
        x_range,
        y: r.l1_error,
        y_margin: 2.0 * r.standard_error.unwrap_or_default(),
        colour: family(&r.technique).colour,
        shape: sizes.iter().position(|&size| size == r.size).unwrap_or_default() as u32,
        name: if r.format == "depth" {
            r.technique.clone()
        } else {
            format!("{}, {}", r.technique, r.format)
        },
        on_front: false,
        compared: r.format == "depth",
    };
    let cost = tables.best().map(|r| mark(r, r.cost, None)).collect();
    let full = tables.full();
    let filterable = || full.iter().filter(|r| r.format != "depth");
    let bits = filterable().map(|r| mark(r, r.bits_per_texel as f64, None)).collect();
    let time = filterable().filter_map(|r| {
        let time = tables.time(&r.technique, &r.format, "f32", "shade")?;
        Some(mark(r, time.median, Some((time.least, time.most))))
    });
    let time = time.collect();
    let chart = |id, title, x_label: &str, marks: Vec<Marker>, shown: &[u32]| {
        let scatter = Scatter { x_label, marks: with_front(marks), sizes: shown.to_vec() };
        Ok::<_, ReportError>(Drawing::new(id, title, svg(id, (860, 560), |root| scatter.draw(root))?))
    };
    let gpu: Vec<Marker> = full
        .iter()
        .filter_map(|r| {
            let (least, median, most) = tables.gpu_time(&r.technique, &r.format)?;
            Some(mark(r, median, Some((least, most))))
        })
        .collect();
    let first = &sizes[..sizes.len().min(1)];
    let mut figures = vec![
        chart(
            "cost",
            "Error against modelled frame cost (lower and further left is better)",
            "modelled cost of a frame; VSM in f32 on the largest map = 1",
            cost,
            &sizes,
        )?,
        chart(
            "memory",
            "Error against memory on the largest map (lower and further left is better)",
            "bits per texel",
            bits,
            first,
        )?,
        chart(
            "time",
            "Error against time to shade a fragment on one core (lower and further left is better)",
            "nanoseconds a fragment, one core, f32, a call at a time",
            time,
            first,
        )?,
        needs(tables)?,
    ];
    if !gpu.is_empty() {
        let adapter = tables.gpu.first().map(|gpu| gpu.adapter.as_str()).unwrap_or_default();
        let label = format!("milliseconds a frame on {adapter}");
        figures.push(chart(
            "gpu",
            "Error against frame time (lower and further left is better)",
            &label,
            gpu,
            first,
        )?);
    }
    Ok(figures)
}

/// Marks those that no other beats in both.
fn with_front(mut marks: Vec<Marker>) -> Vec<Marker> {
    let beaten = |a: &Marker, b: &Marker| !b.compared && b.x <= a.x && b.y <= a.y && (b.x < a.x || b.y < a.y);
    let on: Vec<bool> = marks.iter().map(|a| !a.compared && !marks.iter().any(|b| beaten(a, b))).collect();
    marks.iter_mut().zip(on).for_each(|(mark, on)| mark.on_front = on);
    marks.sort_by(|a, b| a.x.total_cmp(&b.x));
    marks
}

/// Round numbers within a logarithmic axis, few for many decades and many for few.
fn log_ticks(from: f64, to: f64) -> Vec<f64> {
    let decades = (to / from).log10();
    let leading: &[f64] = if decades > 2.5 {
        &[1.0]
    } else if decades > 0.9 {
        &[1.0, 2.0, 5.0]
    } else {
        &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]
    };
    let exponents = from.log10().floor() as i32..=to.log10().ceil() as i32;
    let ticks = exponents.flat_map(|e| leading.iter().map(move |leading| leading * 10f64.powi(e)));
    ticks.filter(|tick| (from..=to).contains(tick)).collect()
}

impl Scatter<'_> {
    fn draw(&self, area: &Area<'_>) -> Drawn {
        let (plot, key) = area.split_vertically(area.dim_in_pixel().1 as i32 - 74 * FINE as i32);
        let least = self.marks.iter().map(|m| m.x).fold(f64::INFINITY, f64::min);
        let most = self.marks.iter().map(|m| m.x).fold(0.0, f64::max);
        let top = self.marks.iter().map(|m| m.y + m.y_margin).fold(0.0, f64::max);
        if self.marks.is_empty() || least <= 0.0 {
            return Ok(());
        }
        let mut builder = ChartBuilder::on(&plot);
        builder.margin_left(6 * FINE).margin_right(20 * FINE).margin_top(10 * FINE);
        builder.x_label_area_size(44 * FINE).y_label_area_size(58 * FINE);
        let (from, to) = (0.85 * least, 1.3 * most);
        let axis = (from..to).log_scale().with_key_points(log_ticks(from, to));
        let mut chart = builder.build_cartesian_2d(axis, 0.0..1.06 * top)?;
        let plain = |value: &f64| {
            if *value >= 10.0 { format!("{value:.0}") } else { format!("{}", (value * 1e3).round() / 1e3) }
        };
        let mut mesh = mesh(&mut chart, 11);
        mesh.y_labels(8).x_labels(8).x_label_formatter(&plain).y_label_formatter(&|error| percent(*error, 0));
        mesh.x_desc(self.x_label).y_desc("mean |G - F| over all fragments");
        mesh.draw()?;
        let mut steps: Vec<(f64, f64)> = Vec::new();
        for mark in self.marks.iter().filter(|m| m.on_front) {
            if let Some(&(_, y)) = steps.last() {
                steps.push((mark.x, y));
            }
            steps.push((mark.x, mark.y));
        }
        if let Some(&(_, y)) = steps.last() {
            steps.push((1.3 * most, y));
        }
        chart.draw_series([PathElement::new(steps, GREY.stroke_width(5))])?;
        for mark in &self.marks {
            let colour = mark.colour.mix(if mark.on_front || mark.compared { 1.0 } else { 0.35 });
            let bar = |a: (f64, f64), b: (f64, f64)| PathElement::new([a, b], colour.stroke_width(4));
            if mark.y_margin > 0.0 {
                let (low, high) = ((mark.y - mark.y_margin).max(0.0), mark.y + mark.y_margin);
                chart.draw_series([bar((mark.x, low), (mark.x, high))])?;
            }
            if let Some((low, high)) = mark.x_range {
                chart.draw_series([bar((low, mark.y), (high, mark.y))])?;
            }
            let (x, y) = chart.backend_coord(&(mark.x, mark.y));
            let (left, above) = area.get_base_pixel();
            symbol(area, (x - left, y - above), mark.shape, colour)?;
            let map =
                self.sizes.get(mark.shape as usize).map_or(String::new(), |size| format!(", {size}² map"));
            let error = percent(mark.y, 2);
            let label = format!("{}{map}: error {error}, {}: {}", mark.name, self.x_label, plain(&mark.x));
            around((x, y), 6 * FINE as i32, &label);
        }
        self.names(area, |mark| chart.backend_coord(&(mark.x, mark.y)))?;
        self.key(&key)
    }

    /// Names of the front, each beside its mark and above the last name that it would cover.
    fn names(&self, area: &Area<'_>, place: impl Fn(&Marker) -> (i32, i32)) -> Drawn {
        let (left, above) = area.get_base_pixel();
        let fine = FINE as i32;
        let width = area.dim_in_pixel().0 as i32;
        let mut taken: Vec<[i32; 4]> = Vec::new();
        let named = |m: &&Marker| m.on_front || (m.compared && m.shape == 0);
        for mark in self.marks.iter().filter(named) {
            let (x, y) = place(mark);
            let (x, y) = (x - left, y - above);
            let length = 6 * fine * mark.name.chars().count() as i32;
            let from = if x + length + 12 * fine < width { x + 8 * fine } else { x - 8 * fine - length };
            let mut row = y - 9 * fine;
            let covers = |row: i32, taken: &[[i32; 4]]| {
                taken.iter().any(|[a, b, c, d]| {
                    from < *c && from + length > *a && row - 7 * fine < *d && row + 7 * fine > *b
                })
            };
            while covers(row, &taken) && row > 12 * fine {
                row -= 13 * fine;
            }
            taken.push([from, row - 7 * fine, from + length, row + 7 * fine]);
            if row < y - 20 * fine {
                area.draw(&PathElement::new(
                    [(x, y), (from + 2 * fine, row + 6 * fine)],
                    GRID.stroke_width(3),
                ))?;
            }
            let style = anchored(11, HPos::Left, VPos::Center).color(&mark.colour);
            area.draw(&Text::new(mark.name.clone(), (from, row), style))?;
        }
        Ok(())
    }

    fn key(&self, area: &Area<'_>) -> Drawn {
        let fine = FINE as i32;
        let families = FAMILIES.iter().chain([&OTHERS]);
        let shown = families.filter(|family| self.marks.iter().any(|mark| mark.colour == family.colour));
        let column = area.dim_in_pixel().0 as i32 / 5;
        for (i, family) in shown.enumerate() {
            let at = (column * (i as i32 % 5) + 16 * fine, (i as i32 / 5) * 18 * fine + 10 * fine);
            symbol(area, at, 0, family.colour.mix(1.0))?;
            let text = (at.0 + 10 * fine, at.1);
            area.draw(&Text::new(family.label, text, anchored(12, HPos::Left, VPos::Center)))?;
        }
        let mut notes: Vec<(Option<u32>, String)> = Vec::new();
        if self.sizes.len() > 1 {
            let shapes = self.sizes.iter().enumerate();
            notes.extend(shapes.map(|(i, size)| (Some(i as u32), format!("{size}x{size} map"))));
        }
        notes.push((None, "pale: something is better in both".to_owned()));
        for (i, (shape, note)) in notes.into_iter().enumerate() {
            let at = (column * i as i32 + 16 * fine, 56 * fine);
            let text = match shape {
                Some(shape) => {
                    symbol(area, at, shape, GREY.mix(1.0))?;
                    (at.0 + 10 * fine, at.1)
                }
                None => at,
            };
            area.draw(&Text::new(note, text, anchored(12, HPos::Left, VPos::Center)))?;
        }
        Ok(())
    }
}

/// A disc, a square or a triangle.
fn symbol(area: &Area<'_>, (x, y): (i32, i32), shape: u32, colour: RGBAColor) -> Drawn {
    let r = 4 * FINE as i32;
    match shape {
        0 => area.draw(&Circle::new((x, y), r, colour.filled()))?,
        1 => area.draw(&Rectangle::new([(x - r, y - r), (x + r, y + r)], colour.filled()))?,
        _ => area.draw(&Polygon::new(vec![(x, y - r), (x - r, y + r), (x + r, y + r)], colour.filled()))?,
    }
    Ok(())
}
