//! Charts and pages as a pure function of recorded files.

mod bound_chart;
mod bounds_figures;
mod bounds_summary;
mod canvas;
mod error;
mod error_sheet;
mod filterable_figures;
mod filterable_order;
mod filterable_summary;
mod filterable_tables;
mod hover;
mod html;
mod published;
mod quantization_figures;
mod quantization_summary;
mod quantization_tables;
mod run_report;
mod search_figures;
mod search_summary;
mod search_tables;
mod speed_figures;
mod speed_gpu;
mod speed_summary;
mod speed_tables;
mod stability_claims;
mod stability_figures;
mod stability_summary;
mod stability_tables;

pub use bound_chart::{BoundChart, BoundCurve};
pub use error::ReportError;
pub use html::{first_sentence, html};
pub use published::comparison;
pub use run_report::{files, write};
