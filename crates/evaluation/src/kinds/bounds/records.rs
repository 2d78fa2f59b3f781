//! Rows of a run of kind `bounds`.

use serde::{Deserialize, Serialize};

/// One row of records.csv: one technique at one fragment depth. Shadow intensities are fractions of the kernel's
/// weight, depths fractions of the depth range.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct BoundsRecord {
    /// Figure id.
    pub figure: String,
    /// Kernel id.
    pub kernel: String,
    /// Technique.
    pub technique: String,
    /// Number m of stored moments.
    pub moments: usize,
    /// Fragment depth.
    pub z_f: f64,
    /// Mass strictly before z_f: PCF.
    #[serde(rename = "F")]
    pub mass_before: f64,
    /// Sharp lower bound G.
    pub lower: Option<f64>,
    /// Sharp upper bound of the mass up to and including z_f.
    pub upper: Option<f64>,
    /// Proved lower bound.
    pub lower_proved: Option<f64>,
    /// Proved upper bound.
    pub upper_proved: Option<f64>,
    /// Why the trial failed, or empty.
    pub error: String,
}

/// One row of kernels.csv: a texel.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct KernelRecord {
    /// Kernel id.
    pub kernel: String,
    /// Column of the texel.
    pub x_texel: usize,
    /// Row of the texel.
    pub y_texel: usize,
    /// Depth of the nearest surface.
    pub depth: f64,
}

/// One row of samples.csv: one timed call that computed both bounds and their certificate.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct BoundsSample {
    /// Figure id.
    pub figure: String,
    /// Kernel id.
    pub kernel: String,
    /// Technique.
    pub technique: String,
    /// Fragment depth.
    pub z_f: f64,
    /// Counts from 0.
    pub repetition: usize,
    /// Wall-clock nanoseconds on one thread.
    pub time_ns: u64,
}
