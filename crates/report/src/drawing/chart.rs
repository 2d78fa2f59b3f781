//! Charts of distribution functions over the fragment depth.

use super::canvas::{Area, Drawn, F_STROKE, FINE, Stroke, anchored, font, line, mesh};
use super::hover;
use super::palette::{BLACK, RUG};
use moment_problem::DepthDistribution;
use plotters::prelude::{ChartBuilder, Circle, EmptyElement, PathElement, Polygon, RGBColor, Text, WHITE};
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, VPos};

/// Fragment depths and what they are fractions of.
pub(crate) const DEPTH_LABEL: &str = "fragment depth z_f (fraction of the depth range)";
pub(crate) const INTENSITY_LABEL: &str = "shadow intensity (fraction)";

/// A polyline in a chart; it is interrupted where there is no value.
pub(crate) struct Curve {
    pub(crate) name: String,
    pub(crate) points: Vec<(f64, Option<f64>)>,
    pub(crate) stroke: Stroke,
}

/// Up to this many jumps of F are drawn with dots that show on which side F is continuous.
const FEW_JUMPS: usize = 12;

/// An arrow at a fragment depth.
pub(crate) struct Arrow {
    pub(crate) depth: f64,
    /// Height of its tip.
    pub(crate) tip: f64,
    pub(crate) colour: RGBColor,
    pub(crate) text: String,
}

/// A chart of distribution functions over the fragment depth.
pub(crate) struct Chart<'a> {
    pub(crate) title: String,
    pub(crate) depths: (f64, f64),
    pub(crate) x_label: &'static str,
    pub(crate) y_label: &'static str,
    /// F, drawn as steps.
    pub(crate) distribution: Option<&'a DepthDistribution>,
    /// Whether its depths are shown as ticks below zero.
    pub(crate) rug: bool,
    /// Later curves cover earlier ones.
    pub(crate) curves: Vec<Curve>,
    pub(crate) arrows: Vec<Arrow>,
}

/// Room above 1 for one row of arrow texts.
const ARROW_ROW: f64 = 0.1;

impl Chart<'_> {
    pub(crate) fn draw(&self, area: &Area<'_>) -> Drawn {
        let shafts = if self.arrows.is_empty() { 0.0 } else { 0.06 };
        let top = 1.04 + shafts + ARROW_ROW * self.arrows.len() as f64;
        let mut builder = ChartBuilder::on(area);
        builder.margin_left(6 * FINE).margin_top(6 * FINE).margin_right(12 * FINE);
        builder.x_label_area_size(if self.x_label.is_empty() { 22 * FINE } else { 42 * FINE });
        builder.y_label_area_size(if self.y_label.is_empty() { 34 * FINE } else { 54 * FINE });
        if !self.title.is_empty() {
            builder.caption(&self.title, font(13));
        }
        let mut chart = builder.build_cartesian_2d(self.depths.0..self.depths.1, -0.06..top)?;
        let number = |value: &f64| format!("{:.1}", value + 0.0);
        // Above 1 there is room for arrows only.
        let intensity = |value: &f64| if *value < 1.01 { number(value) } else { String::new() };
        let mut mesh = mesh(&mut chart, 11);
        mesh.axis_style(RUG.stroke_width(3));
        mesh.x_labels(6)
            .y_labels(if self.arrows.is_empty() { 6 } else { 9 })
            .x_label_formatter(&number)
            .y_label_formatter(&intensity);
        if !self.x_label.is_empty() {
            mesh.x_desc(self.x_label);
        }
        if !self.y_label.is_empty() {
            mesh.y_desc(self.y_label);
        }
        mesh.draw()?;
        if let Some(z) = self.distribution {
            for &depth in z.depths().iter().filter(|_| self.rug) {
                let tick = PathElement::new([(depth, -0.055), (depth, -0.02)], RUG.stroke_width(3));
                chart.draw_series([tick])?;
            }
            chart.draw_series([PathElement::new(steps(z, self.depths), F_STROKE.style())])?;
            if z.depths().len() <= FEW_JUMPS {
                for &depth in z.depths() {
                    // F(depth) does not contain the mass at this depth: F is continuous from the left.
                    let radius = 3 * FINE;
                    let (below, above) = ((depth, z.cdf(depth)), (depth, z.cdf_inclusive(depth)));
                    chart.draw_series([
                        Circle::new(below, radius, BLACK.filled()),
                        Circle::new(above, radius, WHITE.filled()),
                    ])?;
                    chart.draw_series([Circle::new(above, radius, F_STROKE.style())])?;
                }
            }
        }
        for curve in &self.curves {
            for piece in curve.points.split(|(_, value)| value.is_none()) {
                let points = thinned(piece.iter().filter_map(|&(z, value)| Some((z, value?))));
                line(&mut chart, points, curve.stroke)?;
            }
        }
        for strip in 0..STRIPS {
            let depth = |share: f64| self.depths.0 + share * (self.depths.1 - self.depths.0);
            let at = |strip: usize| depth(strip as f64 / STRIPS as f64);
            let middle = depth((strip as f64 + 0.5) / STRIPS as f64);
            let corner = |depth: f64, height: f64| chart.backend_coord(&(depth, height));
            hover::spot([corner(at(strip), 1.02), corner(at(strip + 1), -0.04)], &self.values(middle));
        }
        for (i, arrow) in self.arrows.iter().enumerate() {
            let height = top - ARROW_ROW * (i as f64 + 0.8);
            let shaft = PathElement::new(
                [(arrow.depth, height), (arrow.depth, arrow.tip)],
                arrow.colour.stroke_width(4),
            );
            chart.draw_series([shaft])?;
            let head = |dx: i32, dy: i32| (dx * FINE as i32, dy * FINE as i32);
            let triangle = EmptyElement::at((arrow.depth, arrow.tip))
                + Polygon::new(vec![head(0, 2), head(-4, -7), head(4, -7)], arrow.colour.filled());
            chart.draw_series([triangle])?;
            let style = anchored(11, HPos::Center, VPos::Bottom).color(&arrow.colour);
            chart.draw_series([Text::new(arrow.text.clone(), (arrow.depth, height), style)])?;
        }
        Ok(())
    }
}

/// Strips of a chart that have one value for the reader who points at it.
const STRIPS: usize = 60;

impl Chart<'_> {
    /// F and every curve at a depth, between the nearest points.
    fn values(&self, depth: f64) -> String {
        let mut values = vec![];
        values.extend(self.distribution.map(|z| format!("F {:.3}", z.cdf(depth))));
        for curve in &self.curves {
            let after = curve.points.partition_point(|(x, _)| *x < depth);
            let between =
                after.checked_sub(1).and_then(|i| Some((curve.points.get(i)?, curve.points.get(after)?)));
            if let Some((&(x0, Some(y0)), &(x1, Some(y1)))) = between {
                let share = if x1 > x0 { (depth - x0) / (x1 - x0) } else { 0.0 };
                values.push(format!("{} {:.3}", curve.name, y0 + share * (y1 - y0)));
            }
        }
        format!("z_f = {depth:.3}: {}", values.join(", "))
    }
}

/// F as a polyline over an interval of depths: flat between its depths, upright at each.
fn steps(z: &DepthDistribution, (first, last): (f64, f64)) -> Vec<(f64, f64)> {
    let mut points = vec![(first, z.cdf(first))];
    for &depth in z.depths().iter().filter(|&&depth| first <= depth && depth <= last) {
        points.extend([(depth, z.cdf(depth)), (depth, z.cdf_inclusive(depth))]);
    }
    points.push((last, z.cdf_inclusive(last)));
    points
}

/// The polyline without points that a line between kept points meets to a tenth of a pixel.
fn thinned(points: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    const TOLERANCE: f64 = 2e-4;
    let mut kept: Vec<(f64, f64)> = Vec::new();
    // The last point seen, and the slopes from the last kept point that pass all points since.
    let mut last = None;
    let mut slopes = (f64::NEG_INFINITY, f64::INFINITY);
    for (x, y) in points {
        if let (Some(&(x0, y0)), Some((x1, y1))) = (kept.last(), last) {
            let slope = (y - y0) / (x - x0);
            let (x0, y0) = if (slopes.0..=slopes.1).contains(&slope) {
                (x0, y0)
            } else {
                kept.push((x1, y1));
                slopes = (f64::NEG_INFINITY, f64::INFINITY);
                (x1, y1)
            };
            slopes.0 = slopes.0.max((y - TOLERANCE - y0) / (x - x0));
            slopes.1 = slopes.1.min((y + TOLERANCE - y0) / (x - x0));
            last = Some((x, y));
        } else if let Some(&(x0, y0)) = kept.last() {
            slopes = ((y - TOLERANCE - y0) / (x - x0), (y + TOLERANCE - y0) / (x - x0));
            last = Some((x, y));
        } else {
            kept.push((x, y));
        }
    }
    kept.extend(last);
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn f_rises_at_its_depths_and_nowhere_else() {
        let z = DepthDistribution::new(&[0.25, 0.5], &[0.5, 0.5]).unwrap();
        let expected = [(0.0, 0.0), (0.25, 0.0), (0.25, 0.5), (0.5, 0.5), (0.5, 1.0), (1.0, 1.0)];
        assert_eq!(steps(&z, (0.0, 1.0)), expected);
    }

    #[test]
    fn thinning_keeps_corners() {
        let arc: Vec<(f64, f64)> = (0..=100).map(|i| f64::from(i) / 100.0).map(|x| (x, x * x)).collect();
        let kept = thinned(arc.iter().copied());
        assert!(kept.len() < 60, "{}", kept.len());
        for (x, y) in arc {
            let after = kept.iter().position(|&(kept, _)| kept >= x).unwrap().max(1);
            let ((x0, y0), (x1, y1)) = (kept[after - 1], kept[after]);
            assert!((y0 + (y1 - y0) * (x - x0) / (x1 - x0) - y).abs() < 1e-3);
        }
        let points = [(0.0, 0.0), (0.1, 0.0), (0.2, 0.0), (0.3, 0.5), (0.4, 1.0), (0.5, 1.0)];
        assert_eq!(thinned(points.into_iter()), [(0.0, 0.0), (0.2, 0.0), (0.4, 1.0), (0.5, 1.0)]);
    }
}
