//! Error against cost: a mark a technique, and the line of those that nothing cheaper beats.

use super::canvas::{Area, Drawn, FINE, anchored, font, mesh, svg};
use super::family::Family;
use super::hover::around;
use super::palette::{BLACK, GREY, GRID};
use crate::error::ReportError;
use crate::page::percent_tick;
use plotters::prelude::{
    BindKeyPoints, ChartBuilder, Circle, IntoLogRange, LineSeries, PathElement, Polygon, RGBAColor, RGBColor,
    Rectangle, Text,
};
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, VPos};

/// A technique in a chart.
pub(crate) struct Mark {
    pub(crate) name: String,
    pub(crate) colour: RGBColor,
    pub(crate) x: f64,
    /// Interval of x, where it was measured.
    pub(crate) x_range: Option<(f64, f64)>,
    pub(crate) y: f64,
    pub(crate) y_margin: f64,
    /// 0 a disc, 1 a square, 2 a triangle.
    pub(crate) shape: u32,
    /// Whether it takes part in the front; what is the truth itself is shown beside it.
    pub(crate) competes: bool,
    /// Hatched.
    pub(crate) fails: bool,
    /// What a pointer sees.
    pub(crate) label: String,
}

/// Words around the marks.
pub(crate) struct Scatter<'a> {
    pub(crate) size: (u32, u32),
    /// Above the axes, where one figure has several charts.
    pub(crate) title: &'a str,
    pub(crate) x_label: &'a str,
    pub(crate) y_label: &'a str,
    /// The unit of a second axis on the right, and its words.
    pub(crate) unit: Option<(f64, &'a str)>,
    /// Whether the front is named.
    pub(crate) names: bool,
    /// Words for shapes, from the disc on.
    pub(crate) shapes: Vec<String>,
    /// Whether there is a legend.
    pub(crate) legend: bool,
}

/// Height of a legend in pixels.
const LEGEND: u32 = 92;

/// Whether nothing is as cheap and as accurate, for each mark.
pub(crate) fn front(marks: &[Mark]) -> Vec<bool> {
    let beats = |a: &Mark, b: &Mark| b.competes && b.x <= a.x && b.y <= a.y && (b.x < a.x || b.y < a.y);
    marks.iter().map(|a| a.competes && !marks.iter().any(|b| beats(a, b))).collect()
}

/// Round numbers within a logarithmic axis, few for many decades and many for few.
pub(crate) fn log_ticks(from: f64, to: f64) -> Vec<f64> {
    let decades = (to / from).log10();
    let leading: &[f64] = if decades > 2.5 {
        &[1.0]
    } else if decades > 0.9 {
        &[1.0, 2.0, 5.0]
    } else {
        &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0]
    };
    let exponents = from.log10().floor() as i32..=to.log10().ceil() as i32;
    let ticks = exponents.flat_map(|e| leading.iter().map(move |leading| leading * 10f64.powi(e)));
    ticks.filter(|tick| (from..=to).contains(tick)).collect()
}

impl Scatter<'_> {
    /// The chart as an SVG document.
    pub(crate) fn svg(&self, figure: &str, marks: &[Mark]) -> Result<String, ReportError> {
        svg(figure, self.size, |root| self.draw(root, marks))
    }

    fn draw(&self, area: &Area<'_>, marks: &[Mark]) -> Drawn {
        let key_height = if self.legend { LEGEND } else { 0 };
        let (plot, key) = area.split_vertically(area.dim_in_pixel().1 as i32 - (key_height * FINE) as i32);
        let least = marks.iter().map(|m| m.x).fold(f64::INFINITY, f64::min);
        let most = marks.iter().map(|m| m.x).fold(0.0, f64::max);
        let top = marks.iter().map(|m| m.y + m.y_margin).fold(0.0, f64::max);
        if marks.is_empty() || least <= 0.0 || top <= 0.0 {
            return Ok(());
        }
        let mut builder = ChartBuilder::on(&plot);
        let right = if self.unit.is_some() { 6 } else { 20 };
        builder.margin_left(6 * FINE).margin_right(right * FINE).margin_top(10 * FINE);
        if !self.title.is_empty() {
            builder.caption(self.title, font(14));
        }
        if self.unit.is_some() {
            builder.right_y_label_area_size(58 * FINE);
        }
        builder.x_label_area_size(44 * FINE).y_label_area_size(58 * FINE);
        let (from, to) = (0.85 * least, 1.3 * most);
        let axis = (from..to).log_scale().with_key_points(log_ticks(from, to));
        // Without a unit of its own the second axis is not drawn.
        let unit = self.unit.map_or(1.0, |unit| unit.0);
        let mut chart = builder
            .build_cartesian_2d(axis, 0.0..1.06 * top)?
            .set_secondary_coord(0.0..1.0, 0.0..1.06 * top / unit);
        let mut mesh = mesh(&mut chart, 12);
        mesh.y_labels(8).x_labels(8).x_label_formatter(&plain);
        mesh.y_label_formatter(&|error| percent_tick(*error));
        mesh.x_desc(self.x_label).y_desc(self.y_label);
        mesh.draw()?;
        if let Some((_, words)) = self.unit {
            let mut secondary = chart.configure_secondary_axes();
            secondary.label_style(font(12)).axis_desc_style(font(13)).set_all_tick_mark_size(4 * FINE);
            secondary.y_labels(8).y_desc(words);
            secondary.y_label_formatter(&|share| format!("{share:.2}")).draw()?;
        }
        let on_front = front(marks);
        let mut steps: Vec<(f64, f64)> = Vec::new();
        let mut joined: Vec<&Mark> =
            marks.iter().zip(&on_front).filter(|(_, on)| **on).map(|(m, _)| m).collect();
        joined.sort_by(|a, b| a.x.total_cmp(&b.x));
        for mark in &joined {
            steps.extend(steps.last().map(|&(_, y)| (mark.x, y)));
            steps.push((mark.x, mark.y));
        }
        steps.extend(steps.last().map(|&(_, y)| (to, y)));
        chart.draw_series(LineSeries::new(steps, GREY.stroke_width(5)))?;
        for (mark, &on) in marks.iter().zip(&on_front) {
            let colour = mark.colour.mix(if on || !mark.competes { 1.0 } else { 0.35 });
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
            symbol(area, (x - left, y - above), mark.shape, colour, mark.fails)?;
            around((x, y), 6 * FINE as i32, &mark.label);
        }
        if self.names {
            self.names(area, marks, &on_front, |mark| chart.backend_coord(&(mark.x, mark.y)))?;
        }
        if self.legend { self.key(&key, marks) } else { Ok(()) }
    }

    /// Names of the front and of what it is compared with, each where it covers neither a mark nor another name, as near
    /// to its mark as that allows.
    fn names(
        &self,
        area: &Area<'_>,
        marks: &[Mark],
        on_front: &[bool],
        place: impl Fn(&Mark) -> (i32, i32),
    ) -> Drawn {
        let (left, above) = area.get_base_pixel();
        let fine = FINE as i32;
        let width = area.dim_in_pixel().0 as i32 - 64 * fine;
        let at = |mark: &Mark| {
            let (x, y) = place(mark);
            (x - left, y - above)
        };
        let boxed = |(x, y): (i32, i32), w: i32, h: i32| [x - w, y - h, x + w, y + h];
        let mut taken: Vec<[i32; 4]> = marks.iter().map(|m| boxed(at(m), 5 * fine, 5 * fine)).collect();
        let mut named: Vec<&Mark> = marks
            .iter()
            .zip(on_front)
            .filter(|(m, on)| **on || (!m.competes && m.shape == 0))
            .map(|(m, _)| m)
            .collect();
        named.sort_by(|a, b| a.x.total_cmp(&b.x));
        for mark in named {
            let (x, y) = at(mark);
            let length = 6 * fine * mark.name.chars().count() as i32;
            let rows = (0..14).flat_map(|i| [y - (11 + 13 * i) * fine, y + (11 + 13 * i) * fine]);
            let places = rows.flat_map(|row| {
                [x + 7 * fine, x - 7 * fine - length, x - length / 2].map(|from| (from, row))
            });
            let covered = |(from, row): (i32, i32), taken: &[[i32; 4]]| {
                taken.iter().any(|[a, b, c, d]| {
                    from < *c && from + length > *a && row - 7 * fine < *d && row + 7 * fine > *b
                })
            };
            let bottom =
                area.dim_in_pixel().1 as i32 - (60 + if self.legend { LEGEND as i32 } else { 0 }) * fine;
            let fits = |&(from, row): &(i32, i32)| {
                from > 66 * fine && from + length < width && row > 14 * fine && row < bottom
            };
            // A name without a place is under the pointer, and in the table.
            let Some((from, row)) = places.filter(fits).find(|&place| !covered(place, &taken)) else {
                continue;
            };
            taken.push([from, row - 7 * fine, from + length, row + 7 * fine]);
            if (row - y).abs() > 14 * fine {
                let near = (from + length / 2).clamp(x.min(from + length), x.max(from));
                let side = if row < y { 7 * fine } else { -7 * fine };
                area.draw(&PathElement::new([(x, y), (near, row + side)], GRID.stroke_width(4)))?;
            }
            area.draw(&Text::new(mark.name.clone(), (from, row), anchored(11, HPos::Left, VPos::Center)))?;
        }
        Ok(())
    }

    fn key(&self, area: &Area<'_>, marks: &[Mark]) -> Drawn {
        let fine = FINE as i32;
        let shown = Family::all().filter(|family| marks.iter().any(|mark| mark.colour == family.colour));
        let column = area.dim_in_pixel().0 as i32 / 4;
        let place = |i: i32, row: i32| (column * (i % 4) + 16 * fine, (i / 4 + row) * 18 * fine + 10 * fine);
        let text = |(x, y): (i32, i32), words: String| {
            area.draw(&Text::new(words, (x + 10 * fine, y), anchored(12, HPos::Left, VPos::Center)))
        };
        let mut families = 0;
        for family in shown {
            symbol(area, place(families, 0), 0, family.colour.mix(1.0), false)?;
            text(place(families, 0), family.name.to_owned())?;
            families += 1;
        }
        let row = (families + 3) / 4;
        let mut notes: Vec<(Option<(u32, bool)>, String)> = Vec::new();
        if self.shapes.len() > 1 {
            let shapes = self.shapes.iter().enumerate();
            notes.extend(shapes.map(|(i, words)| (Some((i as u32, false)), words.clone())));
        }
        if marks.iter().any(|mark| mark.fails) {
            notes.push((Some((0, true)), "hatched: unstable".to_owned()));
        }
        notes.push((None, "pale: something is better in both".to_owned()));
        for (i, (shape, note)) in notes.into_iter().enumerate() {
            let at = place(i as i32, row);
            if let Some((shape, hatched)) = shape {
                symbol(area, at, shape, GREY.mix(1.0), hatched)?;
            }
            text(at, note)?;
        }
        Ok(())
    }
}

/// A number of a logarithmic axis.
fn plain(value: &f64) -> String {
    if *value >= 10.0 { format!("{value:.0}") } else { format!("{}", (value * 1e3).round() / 1e3) }
}

/// A disc, a square or a triangle; hatched ones are outlines with two strokes through them.
fn symbol(area: &Area<'_>, (x, y): (i32, i32), shape: u32, colour: RGBAColor, hatched: bool) -> Drawn {
    let r = 4 * FINE as i32 + if hatched { FINE as i32 } else { 0 };
    let style = if hatched { colour.stroke_width(5) } else { colour.filled() };
    match shape {
        0 => area.draw(&Circle::new((x, y), r, style))?,
        1 => area.draw(&Rectangle::new([(x - r, y - r), (x + r, y + r)], style))?,
        _ => {
            let corners = vec![(x, y - r), (x - r, y + r), (x + r, y + r)];
            if hatched {
                let closed = [corners.clone(), vec![corners[0]]].concat();
                area.draw(&PathElement::new(closed, style))?;
            } else {
                area.draw(&Polygon::new(corners, style))?;
            }
        }
    }
    if hatched {
        let h = r / 2;
        for [from, to] in [[(x - r, y + h), (x + h, y - r)], [(x - h, y + r), (x + r, y - h)]] {
            area.draw(&PathElement::new([from, to], BLACK.stroke_width(4)))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mark(name: &str, x: f64, y: f64, competes: bool) -> Mark {
        Mark {
            name: name.to_owned(),
            colour: BLACK,
            x,
            x_range: None,
            y,
            y_margin: 0.0,
            shape: 0,
            competes,
            fails: name == "unstable",
            label: String::new(),
        }
    }

    #[test]
    fn the_front_is_what_nothing_beats_and_what_does_not_compete_beats_nobody() {
        let marks = [
            mark("a", 1.0, 3.0, true),
            mark("b", 2.0, 3.0, true),
            mark("c", 2.0, 1.0, true),
            mark("d", 0.5, 0.5, false),
        ];
        assert_eq!(front(&marks), [true, false, true, false]);
    }

    #[test]
    fn names_do_not_cover_each_other_and_unstable_marks_are_hatched() {
        let marks: Vec<Mark> = (0..6)
            .map(|i| mark("unstable", 1.0 + 0.01 * f64::from(i), 0.2 - 0.01 * f64::from(i), true))
            .collect();
        let scatter = Scatter {
            size: (600, 400),
            title: "",
            x_label: "cost",
            y_label: "error",
            unit: None,
            names: true,
            shapes: Vec::new(),
            legend: true,
        };
        let drawn = scatter.svg("test", &marks).unwrap();
        assert!(drawn.contains("hatched"), "{drawn}");
        let lines: Vec<&str> = drawn.lines().collect();
        let named = lines.windows(2).filter(|pair| pair[1] == "unstable").map(|pair| {
            let of = |key: &str| {
                pair[0].split(key).nth(1).unwrap().split('"').next().unwrap().parse::<i32>().unwrap()
            };
            (of(" x=\""), of(" y=\""))
        });
        let named: Vec<(i32, i32)> = named.collect();
        assert!(named.len() > 3, "{drawn}");
        for (i, a) in named.iter().enumerate() {
            for b in &named[..i] {
                let apart = (a.1 - b.1).abs() >= 13 * FINE as i32 || (a.0 - b.0).abs() >= 48 * FINE as i32;
                assert!(apart, "{named:?}");
            }
        }
    }
}
