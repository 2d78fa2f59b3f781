//! Rows of the recorded tables. Errors are fractions of the kernel's weight, rounded as in `filterable`.

use serde::{Deserialize, Serialize};

/// One row of records.csv: one bias of one way to store moments.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct QuantizationRecord {
    /// What is computed from the moments.
    pub bound: String,
    /// Transform.
    pub transform: String,
    /// Depth range of the moments: `unit` or `signed`.
    pub range: String,
    /// Number format.
    pub format: String,
    /// Filter: `gaussian 9` or `box 9`.
    pub kernel: String,
    /// Memory of a texel, wasted bits included.
    pub bits_per_texel: usize,
    /// Where b* comes from; `exact` for unquantised moments with the least bias that double precision needs.
    pub target: String,
    /// `step` of the scale of biases, `best` (least `l1_error`), `valid` (least alpha for which 99.9 % of the vectors are
    /// valid) or `circulated`.
    pub role: String,
    /// The moment bias.
    pub alpha: f64,
    /// Fragments evaluated.
    pub fragments: usize,
    /// Mean of |G - F|.
    pub l1_error: f64,
    /// Standard error of `l1_error`.
    pub standard_error: f64,
    /// Mean of G - F.
    pub signed_mean: f64,
    /// Mean distance of G from the same bound without quantisation: the noise that storage adds, and what the bias
    /// takes away.
    pub change: f64,
    /// Share of fragments with G > F_Z + 1/255, PCF at the same depth: false shadows that an image shows.
    pub excess_share: f64,
    /// Share of fragments whose biased moment vector is not valid; empty for `exact`.
    pub failure_share: Option<f64>,
    /// Why there is no error, or empty.
    pub error: String,
}

/// One row of biases.csv: one b* of one way to store moments.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct BiasRecord {
    /// What is computed from the moments.
    pub bound: String,
    /// Transform.
    pub transform: String,
    /// Number format.
    pub format: String,
    /// Filter.
    pub kernel: String,
    /// Where b* comes from.
    pub target: String,
    /// Depth range of the moments: `unit` or `signed`.
    pub range: String,
    /// b*, separated by spaces.
    pub moments: String,
    /// Depths and weights `z:w` of a distribution with these moments, separated by spaces; empty if none is known.
    pub distribution: String,
    /// Share of invalid vectors without a bias.
    pub invalid_unbiased: f64,
    /// The smallest alpha that is enough for 99 % of the fragments.
    pub alpha_99: f64,
    /// For 99.9 %.
    pub alpha_999: f64,
    /// For all of them; 1 if none is.
    pub alpha_all: f64,
    /// Mean of |G - F| at `alpha_999`.
    pub valid_l1_error: f64,
    /// Mean distance from the bound without quantisation at `alpha_999`.
    pub valid_change: f64,
    /// The alpha of least error.
    pub best_alpha: f64,
    /// Its error.
    pub best_l1_error: f64,
    /// Its distance from the bound without quantisation.
    pub best_change: f64,
    /// Share of visible false shadows there.
    pub best_excess_share: f64,
    /// Share of invalid vectors there.
    pub best_failure_share: f64,
    /// The alpha in circulation.
    pub circulated_alpha: Option<f64>,
    /// Its error.
    pub circulated_l1_error: Option<f64>,
    /// Share of invalid vectors there.
    pub circulated_failure_share: Option<f64>,
    /// Where the circulated values stand.
    pub source: String,
}

/// One row of comparison.csv: two transforms, each with its own best b* and alpha, on the same fragments.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct ComparisonRecord {
    /// What is computed from the moments.
    pub bound: String,
    /// Number format.
    pub format: String,
    /// The one.
    pub transform: String,
    /// The other.
    pub baseline: String,
    /// Best b* and alpha of the one.
    pub target: String,
    /// See `target`.
    pub alpha: f64,
    /// Best b* and alpha of the other.
    pub baseline_target: String,
    /// See `baseline_target`.
    pub baseline_alpha: f64,
    /// Mean of |G - F| of the one.
    pub l1_error: f64,
    /// Of the other.
    pub baseline_l1_error: f64,
    /// The one's minus the other's: negative if it is better.
    pub difference: f64,
    /// Standard error of the difference on the same fragments.
    pub standard_error: f64,
    /// Views in which the one is better.
    pub better_views: usize,
    /// Views.
    pub views: usize,
}

/// One row of gains.csv: an optimised or published transform.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct GainRecord {
    /// Basis.
    pub basis: String,
    /// Number m of functions.
    pub m: usize,
    /// `dense` or `parity` for optimised ones, the name for published ones.
    pub transform: String,
    /// Depth range.
    pub range: String,
    /// log2 |det theta| in units of depths in \[0, 1\].
    pub gain_bits: Option<f64>,
    /// No transform gains more; empty for published ones.
    pub bound_bits: Option<f64>,
    /// Least stored value, proved.
    pub range_min: Option<f64>,
    /// Largest stored value, proved.
    pub range_max: Option<f64>,
    /// Random starts.
    pub starts: Option<usize>,
    /// Starts that came as far.
    pub starts_at_best: Option<usize>,
    /// The matrix, row-major, separated by spaces.
    pub matrix: String,
    /// The offset, separated by spaces.
    pub offset: String,
    /// Why there is no transform, or empty.
    pub error: String,
}

/// One row of samples.csv: the time of one optimisation.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct GainSample {
    /// Basis.
    pub basis: String,
    /// Structure.
    pub structure: String,
    /// Worker threads.
    pub threads: usize,
    /// Counts from 0.
    pub repetition: usize,
    /// Wall-clock nanoseconds, proof of the bound included.
    pub time_ns: u64,
}

/// One row of hull.csv: a point of the curve of three power moments (MSM15 Figure 5).
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct HullRecord {
    /// `original` or `transformed`.
    pub curve: String,
    /// Depth.
    pub depth: f64,
    /// First coordinate.
    pub x: f64,
    /// Second coordinate.
    pub y: f64,
    /// Third coordinate.
    pub z: f64,
    /// Volume of the convex hull of the whole curve.
    pub hull_volume: f64,
}

/// One row of codes.csv: how often the codes of a part of a channel's range are stored.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct CodeRecord {
    /// What is computed from the moments.
    pub bound: String,
    /// Transform.
    pub transform: String,
    /// Number format.
    pub format: String,
    /// Channel, from 0.
    pub channel: usize,
    /// First stored value of the bin.
    pub from: f64,
    /// Share of the filtered texels behind the fragments.
    pub share: f64,
    /// Entropy of the channel's bins in bits: log2 of their number if all are used equally.
    pub entropy_bits: f64,
}
