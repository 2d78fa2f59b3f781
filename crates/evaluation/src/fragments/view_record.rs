//! The row that every kind on scenes writes for a light view.

use serde::{Deserialize, Serialize};

/// One row of views.csv. A kind writes the columns that it has something for, the same for all its views.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct ViewRecord {
    /// Scene.
    pub scene: String,
    /// View.
    pub view: String,
    /// Entries of the layered shadow map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stack_entries: Option<usize>,
    /// Most layers behind one texel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layers: Option<u32>,
    /// Fragments: light-facing entries whose kernel lies inside the map.
    pub fragments: usize,
    /// Fragments evaluated.
    pub sampled: usize,
    /// Depth by which a plane at 45 degrees to the light changes from texel to texel: the unit of biases.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub texel_depth: Option<f64>,
    /// Median of the fragments' |g_x| + |g_y|.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub median_slope: Option<f64>,
    /// Depths outside \[0, 1\] that were clamped.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clamped_depths: Option<usize>,
    /// Fragments evaluated with F_Z > 0; the others have the same error for every basis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub active: Option<usize>,
    /// Mean of F, under the first bias where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_reference: Option<f64>,
}
