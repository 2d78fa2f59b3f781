//! What can go wrong between records and a page.

use evaluation::EvaluationError;
use thiserror::Error;

/// Why a figure or page could not be made.
#[derive(Debug, Error)]
pub enum ReportError {
    /// The recorded files are at fault, or the result cannot be written.
    #[error(transparent)]
    Records(#[from] EvaluationError),
    /// The drawing library failed.
    #[error("cannot draw {figure}: {reason}")]
    Drawing {
        /// The figure.
        figure: String,
        /// The reason.
        reason: String,
    },
    /// No page is known for it.
    #[error("experiments of kind `{kind}` have no page")]
    Kind {
        /// The kind.
        kind: &'static str,
    },
    /// Nothing to draw.
    #[error("{figure} has no records to draw")]
    Empty {
        /// The figure.
        figure: String,
    },
}
