//! Figures as SVG documents.

mod bound_chart;
mod canvas;
mod chart;
mod curves;
mod dots;
mod error_sheet;
mod family;
mod hover;
mod kernel;
mod palette;
mod scatter;
mod series;
mod texels;

pub use bound_chart::{BoundChart, BoundCurve};
pub(crate) use canvas::{
    Area, Drawn, F_STROKE, FINE, LEGEND_ROW, Stroke, anchored, font, legend, line, mesh, power_of_ten, svg,
};
pub(crate) use chart::{Arrow, Chart, Curve, DEPTH_LABEL, INTENSITY_LABEL};
pub(crate) use curves::{error_curves, error_point};
pub(crate) use dots::{DotChart, DotRow};
pub(crate) use error_sheet::{ErrorColours, error_sheet};
pub(crate) use family::Family;
pub(crate) use hover::{around, escaped, grid, spot};
pub(crate) use kernel::{Outlined, TITLE, WIDTH, beside_charts, draw_title};
pub(crate) use palette::{BLACK, CURVE_COLOURS, EMPTY, GREEN, GREY, GRID, VERMILLION, css, dark, dark_rules};
pub(crate) use scatter::{Mark, Scatter};
pub(crate) use series::{Series, SeriesChart, SeriesPoint};
pub(crate) use texels::texels;
