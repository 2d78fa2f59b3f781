//! Rows of the recorded tables. Errors are fractions of the kernel's weight, rounded to 1e-7.

use serde::{Deserialize, Serialize};

/// One row of records.csv: the ranking under one of the settings.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct VariationRecord {
    /// What is varied.
    pub axis: String,
    /// Name of the settings; the first row has those that the others are compared with.
    pub variation: String,
    /// Fragments of the sample, over all views.
    pub fragments: usize,
    /// Candidates with an error.
    pub candidates: usize,
    /// Certified linear programs.
    pub programs: u64,
    /// Of these, programs that the double-double route decided.
    pub exact: u64,
    /// Programs that remained without a certificate.
    pub uncertified: u64,
    /// Error of power moments.
    pub power_error: f64,
    /// The candidate of least error.
    pub best: String,
    /// Its error.
    pub best_error: f64,
    /// Error that half of the candidates do not exceed.
    pub median_error: f64,
    /// Spearman's correlation of the ranks of all candidates with those of the first row.
    pub correlation: f64,
    /// The same among those that are the best of the first row.
    pub best_correlation: f64,
    /// Share of the best of the first row that are among as many best here.
    pub kept: f64,
    /// By how much the best of the first row errs more than the best here, as a share of the latter's error.
    pub regret: f64,
    /// Why there is no ranking, or empty.
    pub error: String,
}

/// One row of followed.csv: a basis under one of the settings.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct FollowedRecord {
    /// Name of the settings.
    pub variation: String,
    /// The functions.
    pub basis: String,
    /// Place among all candidates, the least error first.
    pub rank: usize,
    /// Mean of |G - F| over all fragments of all views, views weighing the same.
    pub l1_error: f64,
}

/// One row of classes.csv: the best candidate of a class under one of the settings.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct ClassRecord {
    /// Name of the settings.
    pub variation: String,
    /// Kind of all its functions, or `mixed`.
    pub class: String,
    /// The functions.
    pub basis: String,
    /// Place among all candidates.
    pub rank: usize,
    /// Its error.
    pub l1_error: f64,
}
