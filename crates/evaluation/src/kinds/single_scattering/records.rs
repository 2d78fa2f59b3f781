//! Rows of the recorded tables. Lit shares and errors are fractions of the light that would be scattered without shadows,
//! rounded to 1e-9.

use serde::{Deserialize, Serialize};

/// One row of records.csv: one technique on one group of view rays.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct ScatteringRecord {
    /// `single scattering`.
    pub application: String,
    /// Scene, or `all`.
    pub scene: String,
    /// Light view, or `all`.
    pub view: String,
    /// Camera, or `all`.
    pub standpoint: String,
    /// Technique.
    pub technique: String,
    /// `all`, `standpoint`, `steps` (depth steps along the rectified row up to the ray's end) or `epipole` (degrees between ray
    /// and light axis).
    pub group: String,
    /// Class of the group.
    pub class: String,
    /// Rays evaluated.
    pub rays: usize,
    /// Mean |method - truth|, the truth being the shadow map's.
    pub l1_error: f64,
    /// Standard error of that mean; empty where all pixels were evaluated.
    pub standard_error: Option<f64>,
    /// Mean of method - truth: above 0 light leaks.
    pub signed_mean: f64,
    /// 95th percentile of |method - truth|.
    pub p95: f64,
    /// Largest |method - truth|.
    pub maximum: f64,
    /// Mean |method - truth|, the truth being that of shadow rays.
    pub geometry_error: f64,
    /// Memory of a texel that is looked up; that of a depth for ray marching.
    pub bits_per_texel: usize,
    /// Answers that are no number in \[0, 1\].
    pub failed: usize,
    /// Why a method could not be prepared, or empty.
    pub error: String,
}

/// One row of views.csv: a camera under a light.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct ScatteringViewRecord {
    /// Scene.
    pub scene: String,
    /// Light view.
    pub view: String,
    /// Camera.
    pub standpoint: String,
    /// Pixels.
    pub all: usize,
    /// Pixels evaluated.
    pub sampled: usize,
    /// Of these, rays that end at no surface.
    pub endless: usize,
    /// Whether the shadow map lights the camera.
    pub camera_lit: bool,
    /// Least distance of a pixel from the light's axis, in degrees.
    pub epipole: f64,
    /// Bounds of pi - theta with their guard band, in degrees.
    pub least_inclination: f64,
    /// Greatest.
    pub greatest_inclination: f64,
    /// Extent of azimuths in degrees.
    pub azimuths: f64,
    /// Distance between columns of the rectified map, world units.
    pub column_width: f64,
    /// sigma_t per world unit.
    pub extinction: f64,
    /// Mean lit share by the shadow map.
    pub mean_truth: f64,
    /// Mean lit share by shadow rays.
    pub mean_geometry: f64,
    /// Mean |map - geometry|: what no shadow map of this size can know.
    pub difference: f64,
    /// Mean of map - geometry.
    pub signed_difference: f64,
    /// Mean standard error of the geometry's share.
    pub standard_error: f64,
    /// Largest.
    pub largest_standard_error: f64,
    /// Shadow rays sent.
    pub shadow_rays: u64,
    /// Depth steps along a row up to the ray's end, mean.
    pub mean_steps: f64,
}

/// One row of costs.csv: what a technique costs a frame, modelled.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct ScatteringCost {
    /// Technique.
    pub technique: String,
    /// Moments, or 0.
    pub moments: usize,
    /// Samples a ray, or 0.
    pub steps: usize,
    /// Bytes moved for each texel of the rectified map.
    pub bytes_per_texel: f64,
    /// Bytes moved for each pixel.
    pub bytes_per_pixel: f64,
    /// Operations for each texel.
    pub operations_per_texel: f64,
    /// Operations for each pixel.
    pub operations_per_pixel: f64,
    /// All of a frame's megabytes.
    pub megabytes: f64,
    /// All of a frame's millions of operations.
    pub megaoperations: f64,
    /// One number, in megabytes.
    pub total: f64,
}

/// One row of aliasing.csv: what a technique's picture does while the camera moves by a part of a pixel.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct AliasingRecord {
    /// Scene.
    pub scene: String,
    /// Light view.
    pub view: String,
    /// Technique.
    pub technique: String,
    /// `moved` (to the side) or `turned`.
    pub motion: String,
    /// Part of a pixel.
    pub shift: f64,
    /// Pixels.
    pub rays: usize,
    /// Mean change of the truth.
    pub truth_change: f64,
    /// Mean change of the technique's answer.
    pub change: f64,
    /// Mean |change of the answer - change of the truth|: the flicker.
    pub flicker: f64,
    /// 95th percentile of the same.
    pub flicker_p95: f64,
}

/// One row of stability.csv: one bound in one format under one moment bias, over the rays of all views.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct StoredBiasRecord {
    /// Bound as in experiments.
    pub bound: String,
    /// Number format.
    pub format: String,
    /// Transform.
    pub transform: String,
    /// alpha.
    pub alpha: f64,
    /// Rays.
    pub rays: usize,
    /// Mean |method - truth|.
    pub l1_error: f64,
    /// 95th percentile.
    pub p95: f64,
    /// Mean distance from the same bound of unrounded moments under the bias that double precision needs.
    pub change: f64,
    /// Rays whose biased moments are those of no distribution: their matrix has a negative pivot.
    pub invalid: usize,
    /// Answers that are no number in \[0, 1\].
    pub failed: usize,
}

/// One row of edges.csv: one bound in single floats at the edge of what it is for.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct EdgeRecord {
    /// What is extreme.
    pub case: String,
    /// Bound as in experiments.
    pub bound: String,
    /// alpha.
    pub alpha: f64,
    /// Rays.
    pub rays: usize,
    /// Mean |method in double precision - exact distribution|.
    pub mean_error: f64,
    /// Largest.
    pub largest_error: f64,
    /// Mean |single - double precision|.
    pub mean_change: f64,
    /// Largest.
    pub largest_change: f64,
    /// Rays with an answer that is no number in \[0, 1\].
    pub failed: usize,
}

/// One row of pictures.csv: a technique in a picture.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct ScatteringPictureRecord {
    /// Picture.
    pub picture: String,
    /// Technique.
    pub technique: String,
    /// Pixels.
    pub pixels: usize,
    /// Mean |method - truth| of the lit share.
    pub l1_error: f64,
    /// Mean difference of the errors of neighbours where the truth is smooth: noise, stripes and boundaries.
    pub roughness: f64,
    /// Mean difference of the errors of neighbours beyond 0.05, a share of all neighbours: sharp boundaries that are none.
    pub boundaries: f64,
}
