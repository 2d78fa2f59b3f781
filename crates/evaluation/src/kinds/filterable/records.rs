//! Rows of the recorded tables. Intensities and errors are fractions of the kernel's weight, depths fractions of the
//! depth range; both rounded to 1e-9, far below every standard error.

use serde::{Deserialize, Serialize};

/// One row of records.csv: one technique under one bias on one group of fragments.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct FilterableRecord {
    /// Scene, or `all`.
    pub scene: String,
    /// View, or `all`.
    pub view: String,
    /// Technique.
    pub technique: String,
    /// Position in the experiment's list of biases.
    pub bias: usize,
    /// Surfaces in the kernel: `all`, `1`, `2`, `3` or `4+`.
    pub class: String,
    /// Fragments evaluated.
    pub fragments: usize,
    /// Mean of |G - F|.
    pub l1_error: f64,
    /// Mean of G - F: negative for leaking light, positive for shadows where none belong.
    pub signed_mean: f64,
    /// Root of the mean of (G - F)^2.
    pub rms: f64,
    /// 95th percentile of |G - F|.
    pub p95: f64,
    /// Maximum of |G - F|.
    pub maximum: f64,
    /// Share of fragments with G > F + 1e-6.
    pub share_above: f64,
    /// Standard error of `l1_error`; empty where all fragments were evaluated.
    pub standard_error: Option<f64>,
    /// Sum of |G - F| over the sum of F, which is what doing nothing errs by: ground in the light does not dilute it. Empty
    /// where nothing is in shadow, and in runs before it was recorded.
    #[serde(default)]
    pub relative_error: Option<f64>,
    /// Its standard error; empty where all fragments were evaluated.
    #[serde(default)]
    pub relative_standard_error: Option<f64>,
    /// Mean of F_Z(z) - G(z) at the depth z that the technique compares, without a receiver plane: what the
    /// technique itself loses, whatever the bias.
    pub leak: f64,
    /// Fragments with G(z_f) > F_Z(z_f) + 1e-6 where neither has a bias; empty for techniques that are no bounds.
    pub unbiased_violations: Option<usize>,
    /// Memory of a texel.
    pub bits_per_texel: usize,
    /// Why fragments failed, or empty. Failed fragments are left out.
    pub error: String,
}

/// One row of pairs.csv: two techniques under the first bias, on the fragments that both were evaluated on.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct PairRecord {
    /// Technique.
    pub technique: String,
    /// The one it is compared with.
    pub other: String,
    /// Fragments that both have.
    pub fragments: usize,
    /// Mean of |G - F| of the first minus that of the other.
    pub difference: f64,
    /// Its standard error; empty where both were evaluated on all fragments.
    pub standard_error: Option<f64>,
}

/// One row of agreement.csv: a closed form against the certified linear program, on the same moments.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct AgreementRecord {
    /// Scene.
    pub scene: String,
    /// View.
    pub view: String,
    /// Technique.
    pub technique: String,
    /// Fragments compared.
    pub fragments: usize,
    /// Largest |G - G_LP|.
    pub largest_disagreement: f64,
    /// Fragments whose linear program failed, with the first reason.
    pub failed: usize,
    /// First reason, or empty.
    pub error: String,
}

/// One row of kernels.csv: a tap of a picture's kernel.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct PictureRecord {
    /// Picture.
    pub picture: String,
    /// Column in the shadow map.
    pub x_texel: usize,
    /// Row in the shadow map.
    pub y_texel: usize,
    /// Column in the kernel.
    pub x_kernel: usize,
    /// Row in the kernel.
    pub y_kernel: usize,
    /// Depth of the foremost surface.
    pub depth: f64,
    /// Filter weight.
    pub weight: f64,
    /// Depth of the fragment that the picture is about; empty where only a texel was named.
    pub receiver: Option<f64>,
}

/// One row of curves.csv: a technique at one fragment depth of a picture.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct CurveRecord {
    /// Picture.
    pub picture: String,
    /// Technique.
    pub technique: String,
    /// Fragment depth.
    pub z_f: f64,
    /// G, or empty where it failed.
    pub intensity: Option<f64>,
}
