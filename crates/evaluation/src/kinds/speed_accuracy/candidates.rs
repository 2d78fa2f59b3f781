//! The techniques that `msm advise` chooses from, and their filters.

use super::settings::SpeedAccuracyExperiment;
use crate::error::EvaluationError;
use crate::experiment::{Experiment, Scale};
use shadow_filtering::{FilteringError, Kernel};
use std::path::Path;

/// The experiment whose candidates are raced unless a file is given.
pub(crate) const DEFAULT_CANDIDATES: &str = include_str!("../../../candidates/speed-accuracy.toml");

impl SpeedAccuracyExperiment {
    /// The experiment whose techniques `msm advise` races, or that of a file.
    ///
    /// # Errors
    /// [`EvaluationError`] for a file that cannot be read or is of another kind.
    pub fn of_candidates(file: Option<&Path>, seed: Option<u64>) -> Result<Self, EvaluationError> {
        let read = match file {
            Some(path) => Experiment::read(path, Scale::Quick, seed)?,
            None => {
                Experiment::parse(Path::new("speed-accuracy.toml"), DEFAULT_CANDIDATES, Scale::Quick, seed)?
            }
        };
        read.settings::<Self>().cloned().ok_or_else(|| {
            EvaluationError::Value(format!("experiment `{}` is not of kind \"speed-accuracy\"", read.name))
        })
    }

    /// The filter of maps whose side is divided by this.
    ///
    /// # Errors
    /// As `KernelSpec::build`.
    pub fn kernel(&self, divisor: u32) -> Result<Kernel, FilteringError> {
        Self::divided(self.scenery.kernel, divisor).build()
    }
}
