//! The chart of `msm bound --plot`: one kernel's F with the bounds of several bases.

use super::canvas::{F_STROKE, FINE, LEGEND_ROW, Stroke, legend, svg};
use super::chart::{Arrow, Chart, Curve, DEPTH_LABEL};
use super::palette::{BLUE, GREEN, ORANGE, PURPLE, RUG, SKY_BLUE, VERMILLION};
use crate::error::ReportError;
use moment_problem::DepthDistribution;
use plotters::style::RGBColor;

/// Colours and widths; the bounds of related bases coincide for long stretches, and a wide line shows beneath a
/// narrow one.
const REFERENCE_STROKES: [(RGBColor, u32); 5] =
    [(SKY_BLUE, 6), (GREEN, 14), (PURPLE, 5), (ORANGE, 6), (BLUE, 4)];

/// Bounds of one basis over fragment depths.
pub struct BoundCurve {
    /// Name in the legend.
    pub name: String,
    /// Fragment depth, lower and upper bound; without bounds the curve is interrupted.
    pub points: Vec<(f64, Option<(f64, f64)>)>,
}

/// What the chart shows.
pub struct BoundChart<'a> {
    /// F and its depths, if known.
    pub distribution: Option<&'a DepthDistribution>,
    /// The fragment depth that was asked for.
    pub z_f: f64,
    /// Range of fragment depths.
    pub depths: (f64, f64),
    /// The basis that was asked for.
    pub given: BoundCurve,
    /// Other bases for comparison, at most five.
    pub references: Vec<BoundCurve>,
}

impl BoundChart<'_> {
    /// The chart as an SVG document, 800 pixels wide.
    pub fn svg(&self) -> Result<String, ReportError> {
        let mut entries = Vec::new();
        if self.distribution.is_some() {
            entries.push((F_STROKE, "F, percentage-closer filtering".to_owned()));
        }
        let mut curves = Vec::new();
        let references = self.references.iter().zip(REFERENCE_STROKES);
        for (curve, (colour, width)) in references.chain([(&self.given, (VERMILLION, 10))]) {
            let lower = Stroke { colour, width, dashed: false };
            let upper = Stroke { dashed: true, ..lower };
            let part = |stroke: Stroke, choose: fn((f64, f64)) -> f64| Curve {
                name: format!("{} {}", if stroke.dashed { "upper" } else { "lower" }, curve.name),
                points: curve.points.iter().map(|&(z, bounds)| (z, bounds.map(choose))).collect(),
                stroke,
            };
            curves.extend([part(upper, |(_, upper)| upper), part(lower, |(lower, _)| lower)]);
            entries.push((lower, curve.name.clone()));
        }
        // The basis that was asked for is drawn last and named first.
        if let Some(given) = entries.pop() {
            entries.insert(usize::from(self.distribution.is_some()), given);
        }
        let dashed = Stroke { colour: RUG, width: 5, dashed: true };
        entries.push((dashed, "dashed, same colour: upper bound".to_owned()));
        let chart = Chart {
            title: String::new(),
            depths: self.depths,
            x_label: DEPTH_LABEL,
            y_label: "shadow intensity (fraction of the weight)",
            distribution: self.distribution,
            rug: true,
            curves,
            arrows: vec![Arrow {
                depth: self.z_f,
                tip: -0.02,
                colour: F_STROKE.colour,
                text: format!("z_f = {}", self.z_f),
            }],
        };
        const COLUMNS: usize = 2;
        let legend_height = LEGEND_ROW * entries.len().div_ceil(COLUMNS) as u32 + 12;
        let height = 460;
        svg("the bounds", (800, height + legend_height), |root| {
            let (upper, lower) = root.split_vertically(height * FINE);
            chart.draw(&upper)?;
            legend(&lower, &entries, COLUMNS)
        })
    }
}
