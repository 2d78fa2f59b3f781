//! Rows of the recorded tables. Bounds and errors are fractions of the kernel's weight.

use serde::{Deserialize, Serialize};

/// One row of records.csv: a method on a family at one moment bias.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct StabilityRecord {
    /// Method.
    pub method: String,
    /// Family.
    pub family: String,
    /// Moment bias.
    pub alpha: f64,
    /// Whether it is the recommended one.
    pub recommended: bool,
    /// Inputs.
    pub inputs: u64,
    /// Inputs for which the formulas gave no finite number.
    pub not_finite: u64,
    /// Inputs whose value was below 0 or above 1 before any clamping, by more than 1e-6.
    pub outside: u64,
    /// Inputs with G > F + alpha + 1e-6 after clamping: the bound does not hold.
    pub violated: u64,
    /// Inputs with G > F + alpha + 1/255: a false shadow that an image shows.
    pub visible: u64,
    /// Largest G - F - alpha.
    pub largest_excess: f64,
    /// Median distance of G from the exact bound of the exact moments with the same bias: what arithmetic and storage
    /// do. 1 where there is no number. To 12 %, as the next two.
    pub error_median: f64,
    /// 99.9 % of these distances are not larger.
    pub error_999: f64,
    /// The largest.
    pub error_max: f64,
    /// Mean of what the bound loses: the exact bound without a bias minus G, where positive.
    pub mean_loss: f64,
    /// 99 % of these losses are not larger, to 12 %.
    pub loss_99: f64,
    /// Why the numbers say nothing: no fragment of the scenes is one of the family's inputs; else empty.
    pub error: String,
}

/// One row of cells.csv: a method in a cell of a family, at the recommended bias.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct CellRecord {
    /// Index of the method.
    pub method: usize,
    /// Index of the family.
    pub family: usize,
    /// Cell along the first knob.
    pub x: usize,
    /// Cell along the second.
    pub y: usize,
    /// Inputs.
    pub inputs: u64,
    /// Largest distance from the exact bound, two digits.
    pub error_max: f64,
    /// Inputs without a finite number.
    pub not_finite: u64,
    /// Inputs with a visible false shadow.
    pub visible: u64,
}

/// One row of worst.csv: the worst input of a method on a family for one failure, at the recommended bias.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub(super) struct WorstRecord {
    /// Method.
    pub method: String,
    /// Family.
    pub family: String,
    /// `error`, `violated`, `outside` or `not finite`.
    pub failure: String,
    /// What the method returned, before clamping; empty if it was no number.
    pub value: Option<f64>,
    /// Exact bound of the exact moments with the same bias.
    pub exact_biased: f64,
    /// Exact bound without a bias; empty where even double-double cannot tell it.
    pub exact: Option<f64>,
    /// F.
    #[serde(rename = "F")]
    pub mass_before: f64,
    /// Prints the exact bound without a bias, where 32 digits of the moments suffice.
    pub command: String,
}

/// One row of checks.csv: a form on inputs whose exact bound was not computed, at the recommended bias.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct CheckRecord {
    /// Method.
    pub method: String,
    /// Family.
    pub family: String,
    /// Inputs.
    pub inputs: u64,
    /// Inputs with a bound that is NaN or infinite.
    pub not_finite: u64,
    /// Inputs with a bound outside \[0, 1\], or a lower bound above the upper.
    pub outside: u64,
    /// Inputs with G > F + alpha + 1e-6.
    pub violated: u64,
    /// Largest G - F - alpha.
    pub largest_excess: f64,
}

/// One row of pivots.csv: how nearly singular the moment matrices of a family are.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct PivotRecord {
    /// Family.
    pub family: String,
    /// Number of power moments.
    pub order: usize,
    /// Kernels.
    pub inputs: u64,
    /// Share whose smallest pivot of B = L D L^T (moments of 2 z - 1) is below 1e-3.
    pub below_1e3: f64,
    /// Below 1e-6: within reach of the rounding of 16 bits.
    pub below_1e6: f64,
    /// Below 1e-9: lost in single precision.
    pub below_1e9: f64,
    /// Median of the smallest pivot, to 12 %.
    pub median: f64,
}

/// One row of samples.csv: all timed inputs in a row, on one thread.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct StabilitySample {
    /// Method.
    pub method: String,
    /// Counts from 0.
    pub repetition: usize,
    /// Bounds computed: decoding of stored moments, bias and bound.
    pub bounds: usize,
    /// Wall-clock nanoseconds for all of them.
    pub time_ns: u64,
}
