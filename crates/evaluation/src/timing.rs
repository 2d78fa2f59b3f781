//! Clocks run where nothing else does.

use crate::error::EvaluationError;

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
