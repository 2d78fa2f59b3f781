//! What the depth bias of percentage-closer filtering does to the level of all errors.

use crate::statistics::rounded;
use serde::{Deserialize, Serialize};
use shadow_filtering::DepthBias;

/// Constant biases at which F is computed beside the experiment's own, in texel depths: none, the usual one, and twice that.
const BESIDE_TEXELS: [f64; 3] = [0.0, 1.0, 2.0];

/// One row of reference.csv: the mean of F over the evaluated fragments of a view, under one bias.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct ReferenceRecord {
    /// Scene.
    pub scene: String,
    /// View.
    pub view: String,
    /// Constant bias in texel depths.
    pub bias_texels: f64,
    /// Bias in slopes of the receiver.
    pub bias_slopes: f64,
    /// Whether this is the bias of F that the errors of the run are against.
    pub own: bool,
    /// Fragments evaluated.
    pub fragments: usize,
    /// Mean of F.
    pub mean_reference: f64,
}

/// The rows of a view: F of its evaluated fragments under the experiment's own bias, and with 0, 1 and 2 texel depths in the
/// place of its constant one. `references` computes F of all these fragments.
pub(crate) fn reference_records(
    (scene, view): (&str, &str),
    own: DepthBias,
    references: impl Fn(DepthBias) -> Vec<f64>,
) -> Vec<ReferenceRecord> {
    let mut biases = BESIDE_TEXELS.map(|texels| DepthBias { texels, ..own }).to_vec();
    if !biases.contains(&own) {
        biases.insert(0, own);
    }
    let record = |bias: DepthBias| {
        let references = references(bias);
        ReferenceRecord {
            scene: scene.to_owned(),
            view: view.to_owned(),
            bias_texels: bias.texels,
            bias_slopes: bias.slopes,
            own: bias == own,
            fragments: references.len(),
            mean_reference: rounded(references.iter().sum::<f64>() / references.len().max(1) as f64),
        }
    };
    biases.into_iter().map(record).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_own_bias_stands_beside_the_others_once() {
        let of = |bias: DepthBias| vec![0.5 - 0.1 * bias.texels, 0.5];
        let rows = reference_records(("s", "v"), DepthBias { texels: 1.0, slopes: 2.0 }, of);
        let listed: Vec<_> = rows.iter().map(|r| (r.bias_texels, r.bias_slopes, r.own)).collect();
        assert_eq!(listed, [(0.0, 2.0, false), (1.0, 2.0, true), (2.0, 2.0, false)]);
        assert_eq!((rows[2].fragments, rows[2].mean_reference), (2, 0.4));
        let rows = reference_records(("s", "v"), DepthBias { texels: 0.25, slopes: 0.0 }, of);
        assert_eq!(rows.len(), 4);
        assert!(rows[0].own && rows[0].mean_reference == 0.4875);
    }
}
