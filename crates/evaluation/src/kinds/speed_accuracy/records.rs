//! Rows of the recorded tables. Errors are fractions of the kernel's weight, rounded to 1e-9.

use serde::{Deserialize, Serialize};
use shadow_renderer::Route;

/// One row of records.csv: a technique in one format, at one size and with one pair of biases, on a group of fragments.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SpeedAccuracyRecord {
    /// Scene, or `all`.
    pub scene: String,
    /// View, or `all`.
    pub view: String,
    /// Technique.
    pub technique: String,
    /// Number format; `depth` for percentage-closer filtering, `none` for doing nothing.
    pub format: String,
    /// Side of the shadow map in texels.
    pub size: u32,
    /// Moment bias; empty for techniques without.
    pub alpha: Option<f64>,
    /// Depth bias in texel depths of the map.
    pub bias_texels: f64,
    /// Depth bias in slopes of the receiver.
    pub bias_slopes: f64,
    /// Blend of lower and upper bound.
    pub beta: f64,
    /// What shadows are divided by, subtracted from 1.
    pub leak_reduction: f64,
    /// Whether these are the biases and the blend with the least error over all fragments.
    pub best: bool,
    /// Fragments evaluated.
    pub fragments: usize,
    /// Mean of |G - F|.
    pub l1_error: f64,
    /// Its standard error; empty where all fragments were evaluated.
    pub standard_error: Option<f64>,
    /// Sum of |G - F| over the sum of F: 1 is as bad as no shadows at all. Empty where nothing is in shadow, and in runs
    /// before it was recorded.
    #[serde(default)]
    pub relative_error: Option<f64>,
    /// Its standard error; empty where all fragments were evaluated.
    #[serde(default)]
    pub relative_standard_error: Option<f64>,
    /// Mean of G - F: negative for leaking light.
    pub signed_mean: f64,
    /// Memory of a texel.
    pub bits_per_texel: usize,
    /// Operations of decoding and shading a fragment.
    pub operations: f64,
    /// Modelled cost of a frame, 1 for the first candidate at full size.
    pub cost: f64,
    /// Whether no other filterable technique, format or size costs less and errs less over all fragments; empty for parts.
    pub on_front: Option<bool>,
    /// Why it failed, or empty; a failed one has no fragments.
    pub error: String,
}

/// One row of samples.csv: a timing on one thread.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SpeedSample {
    /// Technique.
    pub technique: String,
    /// Number format.
    pub format: String,
    /// `f32` or `f64`.
    pub precision: String,
    /// `filter` (encoding and filtering a map) or `shade` (decoding and the bound).
    pub stage: String,
    /// Counts from 0; all techniques are timed in each round.
    pub repetition: usize,
    /// Texels or fragments.
    pub items: usize,
    /// Wall-clock nanoseconds for all items.
    pub time_ns: u64,
}

/// Which shaders the passes after rasterisation are.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FrameRoute {
    /// Fragment shaders.
    Fragment,
    /// Compute shaders.
    Compute,
    /// Compute shaders without run-time checks of indices.
    Unchecked,
}

/// What runs were recorded with before it was varied.
fn four() -> u32 {
    4
}

/// Runs from before there was a choice.
fn fragment() -> FrameRoute {
    FrameRoute::Fragment
}

impl FrameRoute {
    pub(crate) fn route(self) -> Route {
        match self {
            Self::Fragment => Route::Fragment,
            Self::Compute => Route::Compute,
            Self::Unchecked => Route::Unchecked,
        }
    }
}

/// One row of frames.csv: a pass of a frame on a graphics processor.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct FrameSample {
    /// Technique.
    pub technique: String,
    /// Number format; `depth` for percentage-closer filtering.
    pub format: String,
    /// Side of the shadow map in texels.
    pub map_size: u32,
    /// Output width in pixels.
    pub width: u32,
    /// Output height in pixels.
    pub height: u32,
    /// Size of the filter kernel in texels.
    pub kernel: usize,
    /// Depth samples a texel of the shadow map.
    #[serde(default = "four")]
    pub depth_samples: u32,
    /// `fragment`, `compute`, or `unchecked` for compute passes without run-time checks.
    #[serde(default = "fragment")]
    pub route: FrameRoute,
    /// Pass, or `frame` from the beginning of the first to the end of the last.
    pub pass: String,
    /// Bytes that the pass must move at least: every input read once, every output written once; empty for passes of the
    /// raster pipeline and whole frames.
    #[serde(default)]
    pub least_bytes: Option<u64>,
    /// Counts from 0 over all rounds.
    pub frame: usize,
    /// Between the timestamps around the pass.
    pub time_ns: u64,
}

/// What the kernels of a view need; orders.csv has a row for each share.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OrderRecord {
    pub(crate) scene: String,
    pub(crate) view: String,
    pub(crate) fragments: usize,
    /// Shares by rank of the moment matrix, from 1.
    pub(crate) ranks: Vec<f64>,
    /// By tolerance: shares by least order, the last for none.
    pub(crate) by_gap: Vec<Vec<f64>>,
    /// The same for what the lower bound loses to PCF.
    pub(crate) by_loss: Vec<Vec<f64>>,
}

/// One row of orders.csv: how many kernels need so many moments or surfaces.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct OrderShare {
    /// Scene.
    pub scene: String,
    /// View.
    pub view: String,
    /// `rank` of the moment matrix, `gap` between the sharp bounds, or `loss` of the lower bound to PCF.
    pub by: String,
    /// Tolerance of the rank (share of the largest eigenvalue), the gap or the loss.
    pub tolerance: f64,
    /// The rank, or the order; `more` where eight moments do not suffice.
    pub needs: String,
    /// Fragments looked at.
    pub fragments: usize,
    /// Share of these.
    pub share: f64,
}
