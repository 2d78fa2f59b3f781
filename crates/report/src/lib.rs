//! Charts and pages as a pure function of recorded files.
//!
//! A [`Page`] is a run's question, answer, figures and tables as data; it writes itself as Markdown beside the records,
//! and [`html`] puts several into one document.

mod comparison;
mod drawing;
mod error;
mod html;
mod kinds;
mod page;

pub use comparison::comparison;
pub use drawing::{BoundChart, BoundCurve};
pub use error::ReportError;
pub use html::html;
pub use kinds::page;
pub use page::Page;
