//! A scale of moment biases.

use crate::error::EvaluationError;
use serde::{Deserialize, Serialize};

/// Moment biases, the same number in every power of ten.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Alphas {
    /// Least.
    pub from: f64,
    /// Largest, below 1.
    pub to: f64,
    /// Steps in a power of ten.
    pub per_decade: usize,
}

impl Alphas {
    /// Rejects what is no scale between 0 and 1.
    pub(crate) fn check(&self) -> Result<(), EvaluationError> {
        let Self { from, to, per_decade } = *self;
        if from > 0.0 && from <= to && to < 1.0 && per_decade > 0 {
            return Ok(());
        }
        let reason = format!(
            "alphas: from = {from}, to = {to}, per_decade = {per_decade} are no steps between 0 and 1"
        );
        Err(EvaluationError::key("alphas", reason))
    }

    /// All of them, ascending; the last is `to`.
    pub fn values(&self) -> Vec<f64> {
        let decades = (self.to / self.from).log10();
        let steps = (decades * self.per_decade as f64).round() as usize;
        let at = |i: usize| self.from * 10f64.powf(decades * i as f64 / steps.max(1) as f64);
        (0..=steps).map(at).collect()
    }
}
