//! Charts and pages as a pure function of recorded files.

mod bound_chart;
mod canvas;
mod error;

pub use bound_chart::{BoundChart, BoundCurve};
pub use error::ReportError;
