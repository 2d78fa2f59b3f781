//! Rows of the recorded tables. Errors are fractions of the kernel's weight, rounded to 1e-7, far below their
//! intervals.

use serde::{Deserialize, Serialize};

/// One row of records.csv: one candidate.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SearchRecord {
    /// Number of functions.
    pub m: usize,
    /// Place among the candidates of this size, the least error first.
    pub rank: usize,
    /// Best and worst place that the intervals allow.
    pub rank_low: usize,
    /// See `rank_low`.
    pub rank_high: usize,
    /// The functions.
    pub basis: String,
    /// Kind of all its functions, or `mixed`.
    pub class: String,
    /// Mean of |G - F| over all fragments of all views, views weighing the same.
    pub l1_error: f64,
    /// Half the width of the interval around `l1_error`, for given error of the power moments: 99 % of all samples
    /// would put the difference within it.
    pub interval: f64,
    /// Fragments of the sample.
    pub fragments: usize,
    /// Functions that depend on those before them and were left out.
    pub reduced: String,
    /// Why there is no error, or empty.
    pub error: String,
}

/// One row of stages.csv: what a block was used for.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct StageRecord {
    /// Number of functions.
    pub m: usize,
    /// Block, from 0.
    pub block: usize,
    /// Fragments of the sample in this block.
    pub fragments: usize,
    /// Candidates judged on it.
    pub candidates: usize,
    /// Certified linear programs: distinct fragments with F_Z > 0.
    pub programs: u64,
    /// Of these, programs that double precision could not certify and the double-double route decided.
    pub exact: u64,
    /// Programs that remained without a certificate.
    pub uncertified: u64,
}

/// One row of marks.csv: a closed form or the control on the same fragments.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct MarkRecord {
    /// Technique.
    pub technique: String,
    /// Mean of |G - F| with depths where they are; empty for the control, which is a program over the support.
    pub l1_error: Option<f64>,
    /// Standard error of `l1_error`.
    pub standard_error: Option<f64>,
    /// The same with depths moved to the support, as for all candidates.
    pub moved_l1_error: f64,
    /// Standard error of `moved_l1_error`.
    pub moved_standard_error: f64,
    /// Standard error of the difference, moved minus exact.
    pub difference_standard_error: Option<f64>,
}

/// One row of agreement.csv: a basis against independent solutions of the same programs.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SearchAgreementRecord {
    /// The functions.
    pub basis: String,
    /// Programs.
    pub fragments: usize,
    /// Largest |difference| of G.
    pub largest_disagreement: f64,
    /// Largest distance between G and what is proved.
    pub largest_gap: f64,
    /// Programs that the reference could not solve.
    pub failed: usize,
}

/// One row of samples.csv: a solver on the same programs, one thread.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SearchSample {
    /// Solver.
    pub solver: String,
    /// The functions.
    pub basis: String,
    /// Repetition.
    pub repetition: usize,
    /// Linear programs solved.
    pub programs: usize,
    /// Of these, programs it got wrong by more than the tolerance, or refused.
    pub wrong: usize,
    /// Nanoseconds for all.
    pub time_ns: u64,
}
