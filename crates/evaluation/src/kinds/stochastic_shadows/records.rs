//! Rows of the recorded tables. Intensities and errors are fractions of the light, rounded to 1e-9.

use serde::{Deserialize, Serialize};

/// One row of records.csv: one technique under one light on one class of pixels.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct StochasticRecord {
    /// `stochastic`.
    pub application: String,
    /// Scene, or `all`.
    pub scene: String,
    /// View of the light.
    pub view: String,
    /// Light.
    pub light: String,
    /// Technique.
    pub technique: String,
    /// `all`; `penumbra`, truths from 0.01 to 0.99; `contact`, whose first blocker towards the light's middle is near.
    pub class: String,
    /// Pixels judged.
    pub receivers: usize,
    /// Mean |shadow - truth|.
    pub l1_error: f64,
    /// Standard error of that mean.
    pub standard_error: f64,
    /// Mean of shadow - truth: below 0 light leaks.
    pub signed_mean: f64,
    /// 95th percentile of |shadow - truth|.
    pub p95: f64,
    /// Mean |shadow - that of a map with other points of the light|, of stochastic maps: what flickers from frame to frame.
    pub noise: Option<f64>,
    /// Share of pixels that no sample reaches: taken as lit.
    pub unreached: f64,
    /// Filter planes; 0 for other methods.
    pub planes: usize,
    /// Side of the map in texels.
    pub size: u32,
    /// Bits of a texel of the map, or of one plane.
    pub bits_per_texel: usize,
    /// Memory of all planes, or of the table, in MiB.
    pub mebibytes: f64,
    /// Lookups of a pixel.
    pub lookups: usize,
    /// Pixels without an answer.
    pub failed: usize,
    /// Why, or empty.
    pub error: String,
}

/// One row of views.csv: a scene under a light.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct StochasticViewRecord {
    /// Scene.
    pub scene: String,
    /// View of the light.
    pub view: String,
    /// Light.
    pub light: String,
    /// Its shape as text.
    pub shape: String,
    /// Triangles.
    pub triangles: usize,
    /// Pixels that show a surface which faces the light.
    pub pixels: usize,
    /// Of which were judged.
    pub judged: usize,
    /// In penumbra, with a truth from 0.01 to 0.99.
    pub penumbra: usize,
    /// In contact with their blocker.
    pub contact: usize,
    /// Mean of the truth.
    pub mean_truth: f64,
    /// Mean of its standard error.
    pub mean_standard_error: f64,
    /// Largest.
    pub largest_standard_error: f64,
    /// Shadow rays sent.
    pub rays: u64,
    /// Seed of all of it.
    pub seed: u64,
}

/// One row of planes.csv: a filter plane of a technique.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct PlaneRecord {
    /// Scene.
    pub scene: String,
    /// View of the light.
    pub view: String,
    /// Light.
    pub light: String,
    /// The first technique that uses the plane.
    pub technique: String,
    /// Its depth.
    pub depth: f64,
    /// Whether the map was in focus on it.
    pub in_focus: bool,
    /// Share of its tiles that visible surfaces need.
    pub active_tiles: f64,
    /// Share of samples whose radius the coarsest level cannot follow.
    pub cut_off: f64,
    /// Samples of a texel that has any, on average.
    pub merged: f64,
}

/// One row of modulation.csv: what turning a part changes.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct ModulationRecord {
    /// Scene.
    pub scene: String,
    /// View.
    pub view: String,
    /// Light.
    pub light: String,
    /// Technique.
    pub technique: String,
    /// Pixels judged: what stands still and faces the light.
    pub receivers: usize,
    /// Mean |truth - truth after turning|.
    pub truth_change: f64,
    /// Mean |shadow - shadow after turning|.
    pub change: f64,
    /// Mean |change of the shadow - change of the truth|.
    pub change_error: f64,
    /// Correlation of both changes.
    pub correlation: f64,
    /// Mean |shadow - truth| in both frames.
    pub l1_error: f64,
}

/// One row of pictures.csv: a column of a picture.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct StochasticPictureRecord {
    /// Picture.
    pub picture: String,
    /// Technique.
    pub technique: String,
    /// Pixels that face the light.
    pub pixels: usize,
    /// Mean |shadow - truth|.
    pub l1_error: f64,
}
