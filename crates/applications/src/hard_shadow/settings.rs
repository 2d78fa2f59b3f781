//! How an experiment writes down what is varied.

use serde::{Deserialize, Serialize};
use shadow_filtering::DepthBias;

/// A bias for F and one for all techniques.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BiasSetting {
    /// Bias of F, on top of the receiver plane.
    pub reference: DepthBias,
    /// Bias of every technique; they know no receiver plane.
    pub technique: DepthBias,
}
