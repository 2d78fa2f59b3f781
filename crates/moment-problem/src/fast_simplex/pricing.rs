//! Searches over the whole support, and small sums.

use super::engine::Engine;
use super::lanes::Lanes;
use super::support::LANES;

/// Slack that a dual vertex may lack at a column: the ratio test takes the step at which no column lacks more, and so
/// may prefer large pivots (Harris). A bound is lowered by what its vertex lacks in the end.
pub(super) const SLACK_TOLERANCE: f64 = 1e-10;

/// Pivot elements below this share of the largest possible are rounding.
pub(super) const PIVOT_TOLERANCE: f64 = 1e-11;

impl<V: Lanes, const R: usize, const K: usize> Engine<'_, V, R, K> {
    /// Column at which the slack vanishes first as the dual vector moves along a row of the inverse, and its slack.
    #[inline(always)]
    pub(super) fn entering(&self, y: &[f64; R], rho: &[f64; R]) -> Option<(usize, f64)> {
        let floor = V::splat(PIVOT_TOLERANCE * dot_absolute(rho, &self.largest));
        let (y, rho) = (splat::<V, R>(y), splat::<V, R>(rho));
        let tolerance = V::splat(SLACK_TOLERANCE);
        let mut numerator = V::splat(1.0);
        let mut divisor = V::zero();
        let mut group = V::zero();
        for (number, costs) in self.costs.iter().enumerate() {
            let mut slack = V::load(costs);
            let mut size = V::zero();
            for i in 0..R {
                let row = V::load(&self.rows[i][number]);
                slack = y[i].neg_mul_add(row, slack);
                size = rho[i].neg_mul_add(row, size);
            }
            let slack = slack.add(tolerance);
            // slack / size < numerator / divisor without a division; too small a size never is.
            let left = floor.where_less(size, slack.mul(divisor), V::splat(f64::INFINITY));
            let right = numerator.mul(size);
            numerator = left.where_less(right, slack, numerator);
            group = left.where_less(right, V::splat(number as f64), group);
            divisor = left.where_less(right, size, divisor);
        }
        // Lanes without a candidate divide 1 by 0.
        let (ratio, lane) = numerator.div(divisor).least();
        let column = (group.lane(lane) as usize * LANES + lane).min(self.columns.depths() - 1);
        (ratio < f64::INFINITY).then(|| (column, numerator.lane(lane) - SLACK_TOLERANCE))
    }

    /// Least slack over the support.
    #[inline(always)]
    pub(super) fn least(&self, y: &[f64; R]) -> f64 {
        let y = splat::<V, R>(y);
        let mut least = V::splat(f64::INFINITY);
        for (number, costs) in self.costs.iter().enumerate() {
            let mut slack = V::load(costs);
            for i in 0..R {
                slack = y[i].neg_mul_add(V::load(&self.rows[i][number]), slack);
            }
            least = least.min(slack);
        }
        least.least().0
    }

    /// Least slack over the support and where it is.
    #[inline(always)]
    pub(super) fn least_slack(&self, y: &[f64; R]) -> (f64, usize) {
        let y = splat::<V, R>(y);
        let mut least = V::splat(f64::INFINITY);
        let mut group = V::zero();
        for (number, costs) in self.costs.iter().enumerate() {
            let mut slack = V::load(costs);
            for i in 0..R {
                slack = y[i].neg_mul_add(V::load(&self.rows[i][number]), slack);
            }
            group = slack.where_less(least, V::splat(number as f64), group);
            least = slack.where_less(least, slack, least);
        }
        let (least, lane) = least.least();
        (least, (group.lane(lane) as usize * LANES + lane).min(self.columns.depths() - 1))
    }

    /// The column with the largest |rho . a|.
    #[inline(always)]
    pub(super) fn largest_entry(&self, rho: &[f64; R]) -> usize {
        let rho = splat::<V, R>(rho);
        let mut least = V::zero();
        let mut group = V::zero();
        for number in 0..self.costs.len() {
            let mut alpha = V::zero();
            for i in 0..R {
                alpha = rho[i].mul_add(V::load(&self.rows[i][number]), alpha);
            }
            let size = alpha.abs().mul(V::splat(-1.0));
            group = size.where_less(least, V::splat(number as f64), group);
            least = size.where_less(least, size, least);
        }
        let (_, lane) = least.least();
        (group.lane(lane) as usize * LANES + lane).min(self.columns.depths() - 1)
    }
}

#[inline(always)]
fn splat<V: Lanes, const R: usize>(values: &[f64; R]) -> [V; R] {
    let mut vectors = [V::zero(); R];
    for i in 0..R {
        vectors[i] = V::splat(values[i]);
    }
    vectors
}

#[inline(always)]
pub(super) fn dot<const R: usize>(a: &[f64; R], b: &[f64; R]) -> f64 {
    let mut sum = 0.0;
    for i in 0..R {
        sum = a[i].mul_add(b[i], sum);
    }
    sum
}

#[inline(always)]
pub(super) fn dot_absolute<const R: usize>(a: &[f64; R], b: &[f64; R]) -> f64 {
    let mut sum = 0.0;
    for i in 0..R {
        sum = a[i].abs().mul_add(b[i].abs(), sum);
    }
    sum
}
