//! What every application answers, and what is computed alike for all of them.

use rayon::prelude::*;
use shadow_filtering::FilteringError;

/// An application on one lit view: who receives, and what they should see.
pub trait Application: Sync {
    /// A shaded point, or whatever else an answer is wanted for.
    type Receiver: Sync;

    /// The truth at a receiver, in \[0, 1\]; for shadows 0 is lit and 1 dark.
    fn truth(&self, receiver: &Self::Receiver) -> f64;
}

/// A method prepared for one lit view: what it takes for the truth.
pub trait Estimate<A: Application + ?Sized>: Sync {
    /// The estimate at a receiver, in \[0, 1\].
    ///
    /// # Errors
    /// [`FilteringError`] where the method has no answer; closed forms always have one.
    fn estimate(&self, application: &A, receiver: &A::Receiver) -> Result<f64, FilteringError>;
}

/// The truth at all receivers, in parallel.
pub fn truths<A: Application>(application: &A, receivers: &[A::Receiver]) -> Vec<f64> {
    receivers.par_iter().map(|receiver| application.truth(receiver)).collect()
}

/// Estimate minus truth at all receivers, in parallel.
///
/// # Errors
/// That of the first receiver without an answer.
pub fn errors<A: Application>(
    application: &A,
    estimate: &impl Estimate<A>,
    receivers: &[A::Receiver],
) -> Result<Vec<f64>, FilteringError> {
    let error = |receiver| Ok(estimate.estimate(application, receiver)? - application.truth(receiver));
    receivers.par_iter().map(error).collect()
}
