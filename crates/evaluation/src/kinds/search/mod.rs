//! Experiments of kind `search`: all bases of a family, ranked by their error against percentage-closer filtering
//! (MSM15 section 3.2).
//!
//! Depths are moved to the ends of equal cells, so that one finite support serves all kernels; closed forms on the
//! same fragments with and without that say what it changes. Every candidate is judged on a first block of fragments
//! by its difference to the power moments there, which varies far less than the error itself; only candidates that
//! can still be among the best go on to later blocks.

mod agreement;
mod block;
mod candidates;
mod card;
mod judge;
mod pieces;
mod ranking;
mod records;
mod run;
mod settings;
mod supplies;
mod sweep;
mod timing;
mod workload;

pub(crate) use candidates::{Subsets, class};
#[cfg(test)]
pub(crate) use judge::Finding;
pub(crate) use judge::Verdict;
#[cfg(test)]
pub(crate) use pieces::SearchPieces;
pub(crate) use ranking::STEPS;
pub use records::{MarkRecord, SearchAgreementRecord, SearchRecord, SearchSample, StageRecord};
pub use settings::{SearchAgreement, SearchExperiment, SearchReference, SearchTiming};
pub(crate) use sweep::Sweep;
pub(crate) use workload::Workload;
