//! Rows of the recorded tables. Intensities and errors are fractions of the light, depths fractions of the depth range,
//! rounded to 1e-9; widths are full widths in texels.

use super::view::Population;
use serde::{Deserialize, Serialize};

/// One row of records.csv: one technique under one light and bias on one group of receivers.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SoftRecord {
    /// Light.
    pub light: String,
    /// Fragments of the stack, or what a camera sees.
    pub population: Population,
    /// Scene, or `all`.
    pub scene: String,
    /// View, or `all`.
    pub view: String,
    /// Technique.
    pub technique: String,
    /// Position in the experiment's list of depth biases.
    pub bias: usize,
    /// Whether it is the technique's best one under this light, fragments and pixels weighing alike.
    pub best: bool,
    /// `all`, `width` (of the filter of percentage-closer soft shadows) or `layers`.
    pub group: String,
    /// Of widths `lit` (no blocker in the search region), `0-1`, `1-4`, `4-16` or `16+`; of layers `0`, `1`, `2` or `3+`.
    pub class: String,
    /// Receivers evaluated.
    pub receivers: usize,
    /// Mean |method - truth|.
    pub mean_error: f64,
    /// Standard error of that mean; empty where all receivers were evaluated.
    pub standard_error: Option<f64>,
    /// Mean of method - truth: below 0 light leaks.
    pub signed_mean: f64,
    /// 95th percentile of |method - truth|.
    pub p95: f64,
    /// Largest |method - truth|.
    pub maximum: f64,
    /// Mean |method - first technique|, the latter under its own best bias.
    pub mean_to_first: f64,
    /// Memory of a texel of the table.
    pub bits_per_texel: usize,
    /// Receivers left out: the region exceeds what the table can sum, or the answer is no number in \[0, 1\].
    pub failed: usize,
    /// Why receivers failed, or empty.
    pub error: String,
}

/// One row of views.csv: a view under a light.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SoftViewRecord {
    /// Scene.
    pub scene: String,
    /// View.
    pub view: String,
    /// Light.
    pub light: String,
    /// Its shape as text.
    pub shape: String,
    /// Fragments of the stack, or what a camera sees.
    pub population: Population,
    /// All receivers.
    pub all: usize,
    /// Receivers evaluated.
    pub sampled: usize,
    /// Sampled receivers of which no triangle was found: left out.
    pub lost: usize,
    /// Least and greatest stream of the receivers' rays; with the experiment's seed they give every ray.
    pub first_stream: u64,
    /// Greatest.
    pub last_stream: u64,
    /// Most layers behind one texel.
    pub layers: u32,
    /// Texels per world unit, the geometric mean of both axes.
    pub texels_per_unit: f64,
    /// Depth by which a plane at 45 degrees to the light changes from texel to texel: the unit of biases.
    pub texel_depth: f64,
    /// Full width of the largest search region in texels.
    pub largest_width: f64,
    /// N, texels of the largest region.
    pub largest_region: u32,
    /// Mean of the truth.
    pub mean_truth: f64,
    /// Mean of its standard error.
    pub mean_standard_error: f64,
    /// Largest.
    pub largest_standard_error: f64,
    /// Shadow rays sent.
    pub rays: u64,
    /// Receivers whose truth is neither below 0.01 nor above 0.99.
    pub penumbra: usize,
    /// Mean |truth - truth of the light of the other outline and equal area|, what the shape itself does.
    pub outline_difference: f64,
    /// Largest.
    pub largest_outline_difference: f64,
}

/// One row of sweeps.csv: a technique with one parameter changed, over all views.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SweepRecord {
    /// Sweep.
    pub sweep: String,
    /// Technique.
    pub technique: String,
    /// The value as text.
    pub setting: String,
    /// The value; empty for tables.
    pub value: Option<f64>,
    /// `all`, or the width of the filter of percentage-closer soft shadows.
    pub class: String,
    /// Receivers.
    pub receivers: usize,
    /// Mean |method - truth|.
    pub mean_error: f64,
    /// Mean of method - truth.
    pub signed_mean: f64,
    /// 95th percentile of |method - truth|.
    pub p95: f64,
    /// Queries refused: the region exceeds what the table can sum.
    pub refused: usize,
    /// Answers that are no number, or lie outside \[0, 1\].
    pub not_finite: usize,
    /// Answers off by more than 1/255 from the same technique on exact moments in double precision.
    pub changed: usize,
    /// Mean of that distance.
    pub mean_change: f64,
    /// Largest distance.
    pub largest_change: f64,
}

/// One row of passes.csv: a compute pass on a graphics processor.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct PassSample {
    /// Technique.
    pub technique: String,
    /// Full width in texels of the largest search region.
    pub region: f64,
    /// Side of the shadow map in texels.
    pub map_size: u32,
    /// Output width in pixels.
    pub width: u32,
    /// Output height in pixels.
    pub height: u32,
    /// Pixels of surfaces that face the light: the others take no time to speak of.
    pub receivers: usize,
    /// `rows` (powers of depth and their sums along rows), `columns`, `shade`, or `frame` from the beginning of the first to
    /// the end of the last.
    pub pass: String,
    /// Counts from 0 over all rounds.
    pub frame: usize,
    /// Between the timestamps around the pass.
    pub time_ns: u64,
}

/// One row of receivers.csv: a technique at the receiver of a picture.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct ReceiverRecord {
    /// Picture.
    pub picture: String,
    /// Scene.
    pub scene: String,
    /// View.
    pub view: String,
    /// Technique.
    pub technique: String,
    /// Where the receiver lies on the map, in texels.
    pub x: f64,
    /// Row.
    pub y: f64,
    /// Its depth.
    pub depth: f64,
    /// Depth that is compared when filtering.
    pub compared: f64,
    /// Truth.
    pub truth: f64,
    /// What the technique makes of it.
    pub intensity: f64,
    /// Share of the search region that it takes for blockers.
    pub blockers: f64,
    /// Their average depth, with epsilon.
    pub average: f64,
    /// Full width of the filter.
    pub width: f64,
    /// Full height.
    pub height: f64,
}

/// One row of kernels.csv: a texel of the search region of a picture's receiver.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SearchTexel {
    /// Picture.
    pub picture: String,
    /// Column on the map.
    pub x_texel: usize,
    /// Row.
    pub y_texel: usize,
    /// Depth of the foremost surface.
    pub depth: f64,
}

/// One row of curves.csv: what moments of the search region say of one depth.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct ReconstructionPoint {
    /// Picture.
    pub picture: String,
    /// Technique.
    pub technique: String,
    /// Depth.
    pub z_f: f64,
    /// Share in front of it.
    pub intensity: f64,
}

/// One row of pictures.csv: a technique in a picture.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SoftPictureRecord {
    /// Picture.
    pub picture: String,
    /// Technique.
    pub technique: String,
    /// Position of its depth bias.
    pub bias: usize,
    /// Pixels of surfaces that face the light.
    pub pixels: usize,
    /// Mean |method - truth|.
    pub mean_error: f64,
    /// Mean difference of the errors of neighbours in a penumbra: stripes and noise.
    pub roughness: f64,
}
