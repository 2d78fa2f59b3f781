//! When shadow rays stop.

use crate::error::EvaluationError;
use applications::soft_shadow::{AreaTruth, TruthSettings};
use serde::{Deserialize, Serialize};

/// When shadow rays stop.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TruthSetting {
    /// Standard error of each receiver's truth, a fraction of the light.
    pub standard_error: f64,
    /// Most rays a receiver.
    pub most_rays: usize,
}

impl TruthSetting {
    /// The nets of all shadow rays.
    pub(crate) fn nets(self, seed: u64) -> Result<AreaTruth, EvaluationError> {
        let Self { standard_error, most_rays } = self;
        let nets = AreaTruth::new(TruthSettings { standard_error, most_rays, seed });
        nets.map_err(|error| EvaluationError::key("truth", format!("truth: {error}")))
    }
}
