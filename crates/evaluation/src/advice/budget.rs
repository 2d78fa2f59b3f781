//! What may be spent on a frame.

use crate::error::EvaluationError;

/// Limits of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Milliseconds of modelled cost on a card of that bandwidth.
    pub milliseconds: Option<f64>,
    /// Bytes of what is stored.
    pub bytes: Option<u64>,
    /// Memory traffic of the card in 10^9 bytes a second.
    pub bandwidth: f64,
}

/// That of the card that MSM15 measured on, a GTX 780.
pub const BANDWIDTH: f64 = 288.0;

impl Default for Budget {
    fn default() -> Self {
        Self { milliseconds: None, bytes: None, bandwidth: BANDWIDTH }
    }
}

impl Budget {
    /// Rejects limits that make no sense.
    pub(super) fn check(&self) -> Result<(), EvaluationError> {
        let fail = |text: String| Err(EvaluationError::Value(text));
        match (self.milliseconds, self.bytes) {
            (Some(limit), _) if !(limit > 0.0 && limit.is_finite()) => {
                fail(format!("budget of {limit} ms is not positive"))
            }
            (_, Some(0)) => fail("budget of 0 bytes holds nothing".to_owned()),
            (_, _) if !(self.bandwidth > 0.0 && self.bandwidth.is_finite()) => {
                fail(format!("bandwidth {} GB/s is not positive", self.bandwidth))
            }
            (_, _) => Ok(()),
        }
    }

    pub(super) fn is_limited(&self) -> bool {
        self.milliseconds.is_some() || self.bytes.is_some()
    }

    /// What a modelled cost in bytes takes.
    pub(super) fn milliseconds(&self, cost: f64) -> f64 {
        cost / (self.bandwidth * 1e6)
    }
}

/// The least that was asked for, to be told where a budget leaves nothing.
#[derive(Default)]
pub(super) struct Costs {
    least: Option<(f64, u64)>,
}

impl Costs {
    /// Whether a candidate stays within the budget.
    pub(super) fn admits(&mut self, budget: &Budget, cost: f64, bytes: u64) -> bool {
        let milliseconds = budget.milliseconds(cost);
        let (least, fewest) = self.least.unwrap_or((milliseconds, bytes));
        self.least = Some((least.min(milliseconds), fewest.min(bytes)));
        budget.milliseconds.is_none_or(|limit| milliseconds <= limit)
            && budget.bytes.is_none_or(|limit| bytes <= limit)
    }

    /// Complains where nothing is left of something.
    pub(super) fn check(&self, budget: &Budget, what: &str, is_empty: bool) -> Result<(), EvaluationError> {
        let (Some((milliseconds, bytes)), true) = (self.least, is_empty) else { return Ok(()) };
        let limits = [
            budget.milliseconds.map(|limit| format!("{limit} ms")),
            budget.bytes.map(|limit| format!("{limit} bytes")),
        ];
        let limits: Vec<String> = limits.into_iter().flatten().collect();
        Err(EvaluationError::Value(format!(
            "budget of {}: nothing for {what} stays within it; the cheapest takes {milliseconds:.3} ms at {} GB/s, the \
             smallest {bytes} bytes",
            limits.join(" and "),
            budget.bandwidth
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_leave_what_fits() {
        let budget = Budget { milliseconds: Some(0.5), bytes: Some(1000), bandwidth: 100.0 };
        let mut costs = Costs::default();
        assert!(costs.admits(&budget, 5e7, 1000));
        assert!(!costs.admits(&budget, 5.1e7, 1000));
        assert!(!costs.admits(&budget, 5e7, 1001));
        assert!(costs.check(&budget, "shadows", false).is_ok());
        let told = costs.check(&budget, "shadows", true).unwrap_err().to_string();
        assert!(told.contains("0.5 ms and 1000 bytes") && told.contains("0.500 ms"), "{told}");
        assert!(Budget { bytes: Some(0), ..Budget::default() }.check().is_err());
        assert!(Budget { milliseconds: Some(f64::NAN), ..Budget::default() }.check().is_err());
        assert!(Budget { bandwidth: 0.0, ..Budget::default() }.check().is_err());
    }
}
