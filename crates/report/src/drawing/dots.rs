//! A row a technique with one or two dots, the worst below.

use super::canvas::{Area, Drawn, FINE, anchored, mesh, svg};
use super::palette::{BLUE, GRID, VERMILLION};
use super::{TITLE, WIDTH, around, draw_title};
use crate::error::ReportError;
use crate::page::{Drawing, percent, percent_tick};
use plotters::prelude::{ChartBuilder, Circle, PathElement, RGBColor, Text};
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, VPos};

/// A technique with its errors, as fractions.
pub(crate) struct DotRow {
    pub(crate) name: String,
    pub(crate) first: f64,
    /// Half the length of the line about the first.
    pub(crate) margin: f64,
    pub(crate) second: Option<f64>,
}

/// Rows with what their dots mean.
pub(crate) struct DotChart {
    pub(crate) title: String,
    pub(crate) x: &'static str,
    /// Of the first and the second dot, under the pointer.
    pub(crate) words: [&'static str; 2],
    /// Of both dots, with the pixel where each begins.
    pub(crate) legend: [(&'static str, i32); 2],
    pub(crate) rows: Vec<DotRow>,
}

impl DotChart {
    /// The figure; none without rows.
    pub(crate) fn drawing(mut self, id: String) -> Result<Option<Drawing>, ReportError> {
        const ROW: u32 = 19;
        if self.rows.is_empty() {
            return Ok(None);
        }
        self.rows.sort_by(|a, b| b.first.total_cmp(&a.first));
        let height = TITLE + ROW * self.rows.len() as u32 + 84;
        let picture = svg(&id, (WIDTH, height), |root| {
            let (top, rest) = root.split_vertically(TITLE * FINE);
            draw_title(&top, &self.title)?;
            self.dots(&rest)
        })?;
        Ok(Some(Drawing::new(id, self.title, picture)))
    }

    fn dots(&self, area: &Area<'_>) -> Drawn {
        let (plot, key) = area.split_vertically(area.dim_in_pixel().1 as i32 - 26 * FINE as i32);
        let all = self.rows.iter().flat_map(|row| [Some(row.first), row.second]).flatten();
        let most = all.fold(0.0, f64::max).max(1e-6);
        let mut builder = ChartBuilder::on(&plot);
        builder.margin_left(6 * FINE).margin_top(4 * FINE).margin_right(20 * FINE);
        builder.x_label_area_size(42 * FINE).y_label_area_size(190 * FINE);
        let rows = self.rows.len() as f64;
        let mut chart = builder.build_cartesian_2d(0.0..1.08 * most, -0.5..rows - 0.5)?;
        let mut grid = mesh(&mut chart, 11);
        grid.x_label_formatter(&|error| percent_tick(*error)).x_desc(self.x);
        grid.disable_y_axis().disable_y_mesh().draw()?;
        for (place, row) in self.rows.iter().enumerate() {
            let y = place as f64;
            let (x, at) = (row.first, chart.backend_coord(&(0.0, y)));
            let (left, above) = area.get_base_pixel();
            let label = anchored(12, HPos::Right, VPos::Center);
            area.draw(&Text::new(row.name.clone(), (at.0 - left - 8 * FINE as i32, at.1 - above), label))?;
            if let Some(second) = row.second {
                chart.draw_series([PathElement::new([(x, y), (second, y)], GRID.stroke_width(4))])?;
                chart.draw_series([Circle::new((second, y), 4 * FINE, VERMILLION.filled())])?;
                let at = chart.backend_coord(&(second, y));
                let words = format!("{}, {}: {}", row.name, self.words[1], percent(second, 2));
                around(at, 5 * FINE as i32, &words);
            }
            let margin = row.margin;
            chart
                .draw_series([PathElement::new([(x - margin, y), (x + margin, y)], BLUE.stroke_width(4))])?;
            chart.draw_series([Circle::new((x, y), 4 * FINE, BLUE.filled())])?;
            let at = chart.backend_coord(&(x, y));
            around(at, 5 * FINE as i32, &format!("{}, {}: {}", row.name, self.words[0], percent(x, 2)));
        }
        let colours: [RGBColor; 2] = [BLUE, VERMILLION];
        for (colour, (text, x)) in colours.into_iter().zip(self.legend) {
            let at = (x * FINE as i32, 12 * FINE as i32);
            key.draw(&Circle::new(at, 4 * FINE, colour.filled()))?;
            let style = anchored(12, HPos::Left, VPos::Center);
            key.draw(&Text::new(text, (at.0 + 10 * FINE as i32, at.1), style))?;
        }
        Ok(())
    }
}
