//! The figures of a `bounds` experiment: one chart per kernel and panel.

use super::summary::BoundsTables;
use crate::drawing::{
    Arrow, CURVE_COLOURS, Chart, Curve, DEPTH_LABEL, F_STROKE, FINE, GREEN, INTENSITY_LABEL, LEGEND_ROW,
    Stroke, TITLE, VERMILLION, WIDTH, beside_charts, draw_title, legend, svg,
};
use crate::error::ReportError;
use crate::kinds::rows::distinct;
use evaluation::{BoundsFigure, BoundsTechnique, KernelRecord, uniform_distribution};
use moment_problem::DepthDistribution;
use plotters::style::RGBColor;

/// One figure as an SVG document.
pub(crate) fn draw(
    figure: &BoundsFigure,
    tables: &BoundsTables,
    kernels: &[KernelRecord],
) -> Result<String, ReportError> {
    let empty = || ReportError::Empty { figure: figure.id.clone() };
    let panels = distinct(figure.technique.iter().map(|technique| technique.panel.as_str()));
    let mut distributions = Vec::new();
    for id in &figure.kernels {
        let depths: Vec<f64> = kernels.iter().filter(|r| r.kernel == *id).map(|r| r.depth).collect();
        distributions.push(uniform_distribution(&depths).map_err(|_| empty())?);
    }
    if panels.is_empty() || distributions.is_empty() {
        return Err(empty());
    }
    let sheet = Sheet { figure, tables, panels, distributions };
    match &figure.kernels[..] {
        [only] => sheet.with_kernel(&kernels.iter().filter(|r| r.kernel == *only).collect::<Vec<_>>()),
        _ => sheet.grid(),
    }
}

struct Sheet<'a> {
    figure: &'a BoundsFigure,
    tables: &'a BoundsTables,
    panels: Vec<&'a str>,
    distributions: Vec<DepthDistribution>,
}

impl Sheet<'_> {
    /// The kernel as an image beside its charts.
    fn with_kernel(&self, texels: &[&KernelRecord]) -> Result<String, ReportError> {
        const CHART: u32 = 380;
        let charts = self.panels.iter().map(|panel| Chart {
            x_label: DEPTH_LABEL,
            y_label: INTENSITY_LABEL,
            ..self.chart(0, panel)
        });
        let charts: Vec<Chart<'_>> = charts.collect();
        let figure = (self.figure.id.as_str(), self.figure.title.as_str());
        let kernel = (self.figure.kernels[0].as_str(), texels, &[][..]);
        beside_charts(figure, kernel, (&charts, CHART), &self.legend_entries(&self.panels))
    }

    /// Kernels side by side, panels below each other.
    fn grid(&self) -> Result<String, ReportError> {
        const CHART: u32 = 200;
        const LAST_ROW: u32 = 20;
        let rows = self.panels.len() as u32;
        let entries = self.row_entries();
        let columns = entries.len().clamp(1, 4);
        let legend_height = LEGEND_ROW * entries.len().div_ceil(columns) as u32 + 6;
        let height = TITLE + legend_height + CHART * rows + LAST_ROW;
        svg(&self.figure.id, (WIDTH, height), |root| {
            let (title, rest) = root.split_vertically(TITLE * FINE);
            draw_title(&title, &self.figure.title)?;
            let (top, mut rest) = rest.split_vertically(legend_height * FINE);
            legend(&top, &entries, columns)?;
            for (row, panel) in self.panels.iter().enumerate() {
                let last = row + 1 == self.panels.len();
                let (strip, below) = rest.split_vertically((CHART + if last { LAST_ROW } else { 0 }) * FINE);
                rest = below;
                let areas = strip.split_evenly((1, self.distributions.len()));
                for (column, area) in areas.iter().enumerate() {
                    let mut chart = self.chart(column, panel);
                    chart.title = format!("{panel}: {}", self.figure.kernels[column]);
                    if last {
                        chart.x_label = "fragment depth z_f (fraction of the range)";
                    }
                    if column == 0 {
                        chart.y_label = "intensity (fraction)";
                    }
                    chart.draw(area)?;
                }
            }
            Ok(())
        })
    }

    fn techniques<'a>(&'a self, panel: &'a str) -> impl Iterator<Item = (&'a BoundsTechnique, RGBColor)> {
        let of_panel = self.figure.technique.iter().filter(move |technique| technique.panel == panel);
        of_panel.zip(CURVE_COLOURS.iter().copied().cycle())
    }

    fn chart(&self, kernel: usize, panel: &str) -> Chart<'_> {
        let curves = self.techniques(panel).map(|(technique, colour)| {
            let records = self.tables.of(&self.figure.id, &self.figure.kernels[kernel], &technique.name);
            Curve {
                name: technique.name.clone(),
                points: records.map(|r| (r.z_f, r.lower.filter(|_| r.error.is_empty()))).collect(),
                stroke: lower_stroke(colour),
            }
        });
        let arrows = self.figure.mark.iter().map(|mark| Arrow {
            depth: mark.depth,
            tip: self.distributions[kernel].cdf_inclusive(mark.depth) + 0.04,
            colour: if mark.correct { GREEN } else { VERMILLION },
            text: mark.text.clone(),
        });
        Chart {
            title: String::new(),
            depths: (0.0, 1.0),
            x_label: "",
            y_label: "",
            distribution: Some(&self.distributions[kernel]),
            rug: false,
            curves: curves.collect(),
            arrows: arrows.collect(),
        }
    }

    fn legend_entries(&self, panels: &[&str]) -> Vec<(Stroke, String)> {
        let mut entries = vec![(F_STROKE, "F (PCF)".to_owned())];
        for panel in panels {
            let lines = self.techniques(panel);
            entries.extend(lines.map(|(technique, colour)| (lower_stroke(colour), technique.name.clone())));
        }
        entries
    }

    /// One legend for all panels where the n-th technique of each panel has the same number of moments.
    fn row_entries(&self) -> Vec<(Stroke, String)> {
        let sizes = |panel: &str| -> Vec<Option<usize>> {
            let techniques = self.techniques(panel);
            techniques.map(|(technique, _)| technique.basis().ok().map(|basis| basis.len())).collect()
        };
        let first = sizes(self.panels[0]);
        if self.panels.iter().any(|panel| sizes(panel) != first) {
            return self.legend_entries(&self.panels);
        }
        let entries = first.iter().zip(CURVE_COLOURS.iter().cycle());
        let entries = entries.map(|(m, &colour)| {
            (lower_stroke(colour), format!("lower bound, m = {}", m.unwrap_or_default()))
        });
        [(F_STROKE, "F (PCF)".to_owned())].into_iter().chain(entries).collect()
    }
}

fn lower_stroke(colour: RGBColor) -> Stroke {
    Stroke { colour, width: 8, dashed: false }
}
