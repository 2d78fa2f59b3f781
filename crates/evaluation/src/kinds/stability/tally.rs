//! Counting errors so that parts can be merged in any order of work with the same result.

use serde::{Deserialize, Serialize};

/// Steps in a power of ten.
const PER_DECADE: f64 = 20.0;

/// Powers of ten below 1 that are told apart; less counts as nothing.
const DECADES: f64 = 18.0;

/// Numbers of values by their size, for quantiles to half a step.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct LogHistogram {
    /// The first counts what is less than all steps.
    counts: Vec<u64>,
    total: u64,
}

impl Default for LogHistogram {
    fn default() -> Self {
        Self { counts: vec![0; (PER_DECADE * DECADES) as usize + 2], total: 0 }
    }
}

impl LogHistogram {
    /// Adds a value in \[0, 1\].
    pub(crate) fn add(&mut self, value: f64) {
        let step = (value.max(0.0).log10() + DECADES) * PER_DECADE;
        // A saturating cast: zero, whose logarithm is infinite, is in the first step.
        let place = if step < 0.0 { 0 } else { (step as usize + 1).min(self.counts.len() - 1) };
        self.counts[place] += 1;
        self.total += 1;
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        self.counts.iter_mut().zip(&other.counts).for_each(|(mine, theirs)| *mine += theirs);
        self.total += other.total;
    }

    /// The value that a share of all values does not exceed: the middle of its step; 0 without values.
    pub(crate) fn quantile(&self, share: f64) -> f64 {
        let wanted = (share * self.total as f64).ceil().max(1.0) as u64;
        let mut sum = 0;
        for (place, count) in self.counts.iter().enumerate() {
            sum += count;
            if sum >= wanted {
                let middle = (place as f64 - 0.5) / PER_DECADE - DECADES;
                return if place == 0 { 0.0 } else { 10f64.powf(middle).min(1.0) };
            }
        }
        0.0
    }

    /// Share of values below a power of ten.
    pub(crate) fn share_below(&self, exponent: i32) -> f64 {
        let places = ((f64::from(exponent) + DECADES) * PER_DECADE) as usize + 1;
        self.counts[..places].iter().sum::<u64>() as f64 / self.total.max(1) as f64
    }
}

/// A method on a family at one bias.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub(crate) struct Tally {
    pub(crate) inputs: u64,
    pub(crate) not_finite: u64,
    pub(crate) outside: u64,
    pub(crate) violated: u64,
    pub(crate) visible: u64,
    pub(crate) largest_excess: f64,
    pub(crate) errors: LogHistogram,
    pub(crate) error_max: f64,
    pub(crate) losses: LogHistogram,
    pub(crate) loss_sum: f64,
    /// Inputs whose loss is known.
    pub(crate) losses_known: u64,
}

/// G may exceed F + alpha by this much: sixteen roundings of single precision, and far below what is seen.
pub(crate) const BOUND_TOLERANCE: f64 = 1e-6;

/// Half a step of 8-bit pictures is not seen, a whole one may be.
pub(crate) const VISIBLE: f64 = 1.0 / 255.0;

impl Tally {
    /// Adds what a method returned (before clamping), F + alpha, the exact bound with the bias and that without.
    pub(crate) fn add(&mut self, value: Option<f64>, allowed: f64, exact_biased: f64, exact: Option<f64>) {
        self.inputs += 1;
        let Some(raw) = value else {
            self.not_finite += 1;
            self.errors.add(1.0);
            self.error_max = 1.0;
            return;
        };
        self.outside += u64::from(!(-BOUND_TOLERANCE..=1.0 + BOUND_TOLERANCE).contains(&raw));
        let g = raw.clamp(0.0, 1.0);
        let excess = g - allowed;
        self.violated += u64::from(excess > BOUND_TOLERANCE);
        self.visible += u64::from(excess > VISIBLE);
        self.largest_excess = self.largest_excess.max(excess);
        let error = (g - exact_biased).abs();
        self.errors.add(error);
        self.error_max = self.error_max.max(error);
        if let Some(exact) = exact {
            let loss = (exact - g).max(0.0);
            self.losses.add(loss);
            self.loss_sum += loss;
            self.losses_known += 1;
        }
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        self.inputs += other.inputs;
        self.not_finite += other.not_finite;
        self.outside += other.outside;
        self.violated += other.violated;
        self.visible += other.visible;
        self.largest_excess = self.largest_excess.max(other.largest_excess);
        self.errors.merge(&other.errors);
        self.error_max = self.error_max.max(other.error_max);
        self.losses.merge(&other.losses);
        self.loss_sum += other.loss_sum;
        self.losses_known += other.losses_known;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_values_to_half_a_step() {
        let mut histogram = LogHistogram::default();
        let values: Vec<f64> = (0..1000).map(|i| 10f64.powf(-f64::from(i) / 100.0)).collect();
        values.iter().for_each(|&value| histogram.add(value));
        for (share, exact) in [(0.5, values[500]), (0.999, values[1]), (0.1, values[900])] {
            let ratio = histogram.quantile(share) / exact;
            assert!((ratio.log10() * PER_DECADE).abs() < 1.0, "{share}: {ratio}");
        }
        assert!((histogram.share_below(-5) - 0.499).abs() < 0.002);
        let mut zeros = LogHistogram::default();
        zeros.add(0.0);
        assert_eq!(zeros.quantile(0.5), 0.0);
        let mut both = histogram.clone();
        both.merge(&zeros);
        assert_eq!(both.total, 1001);
    }

    #[test]
    fn every_failure_is_counted_once() {
        let mut tally = Tally::default();
        tally.add(None, 0.5, 0.4, Some(0.4));
        tally.add(Some(1.5), 1.0, 1.0, Some(1.0));
        tally.add(Some(0.6), 0.5, 0.5, None);
        tally.add(Some(0.3), 0.5, 0.4, Some(0.5));
        let counts = [tally.inputs, tally.not_finite, tally.outside, tally.violated, tally.visible];
        assert_eq!(counts, [4, 1, 1, 1, 1]);
        assert!((tally.largest_excess - 0.1).abs() < 1e-12 && tally.error_max == 1.0);
        assert!((tally.loss_sum - 0.2).abs() < 1e-12 && tally.losses_known == 2);
    }
}
