//! Clocks run where nothing else does.

use crate::error::EvaluationError;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// One row of samples.csv: a timing on one thread.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct TimedSample {
    /// Technique.
    pub technique: String,
    /// What was timed: `filter`, `sum` (encoding, then filtering or summing a map), `shade`, `rays` and the like.
    pub stage: String,
    /// Texels, receivers or rays.
    pub items: usize,
    /// Counts from 0.
    pub repetition: usize,
    /// Wall-clock nanoseconds for all items.
    pub time_ns: u64,
}

impl TimedSample {
    /// What began at `begin` and ends now.
    pub(crate) fn since(
        begin: Instant,
        technique: &str,
        stage: &str,
        items: usize,
        repetition: usize,
    ) -> Self {
        Self {
            technique: technique.to_owned(),
            stage: stage.to_owned(),
            items,
            repetition,
            time_ns: u64::try_from(begin.elapsed().as_nanos()).unwrap_or(u64::MAX),
        }
    }
}

/// What `work` returns, on one thread of its own.
pub(crate) fn alone<T: Send>(
    work: impl FnOnce() -> Result<T, EvaluationError> + Send,
) -> Result<T, EvaluationError> {
    let fail = |error: rayon::ThreadPoolBuildError| EvaluationError::Threads {
        threads: 1,
        reason: error.to_string(),
    };
    rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(fail)?.install(work)
}
