//! Means, how sure they are, percentiles, and the precision of the tables.

use serde::{Deserialize, Serialize};

/// Running count, mean and sum of squared deviations (Welford).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Running {
    count: f64,
    mean: f64,
    squares: f64,
}

impl Running {
    pub(crate) fn add(&mut self, value: f64) {
        self.add_repeated(value, 1.0);
    }

    /// From a count, the sum of the values and that of their squares.
    pub(crate) fn of(count: f64, sum: f64, squares: f64) -> Self {
        let mean = if count > 0.0 { sum / count } else { 0.0 };
        Self { count, mean, squares: (squares - sum * mean).max(0.0) }
    }

    /// The same value several times.
    pub(crate) fn add_repeated(&mut self, value: f64, count: f64) {
        let before = self.count;
        self.count += count;
        let deviation = value - self.mean;
        self.mean += deviation * count / self.count;
        self.squares += deviation * deviation * before * count / self.count;
    }
}

/// A mean with its sampling variance.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub(crate) struct Mean {
    pub(crate) value: f64,
    pub(crate) variance: f64,
}

/// Mean over views of equal weight. `all` is how many fragments each view has: what is complete is certain.
///
/// The sample of a view is spread evenly over it, so that the variance of a random sample, which is computed here, is
/// too large rather than too small.
pub(crate) fn stratified(views: &[Running], all: &[usize]) -> Mean {
    let mut mean = Mean::default();
    let weight = 1.0 / views.len() as f64;
    for (view, &all) in views.iter().zip(all) {
        mean.value += weight * view.mean;
        // A single fragment says nothing about the spread: its own square is the best guess.
        let spread = if view.count > 1.0 { view.squares / (view.count - 1.0) } else { view.mean * view.mean };
        let missing = (1.0 - view.count / all as f64).max(0.0);
        mean.variance += weight * weight * spread * missing / view.count.max(1.0);
    }
    mean
}

/// Joins independent means of the same quantity, weighted by their sample sizes.
pub(crate) fn joined(parts: impl Iterator<Item = (Mean, usize)> + Clone) -> Mean {
    let total: f64 = parts.clone().map(|(_, size)| size as f64).sum();
    parts.fold(Mean::default(), |sum, (mean, size)| {
        let weight = size as f64 / total;
        Mean {
            value: sum.value + weight * mean.value,
            variance: sum.variance + weight * weight * mean.variance,
        }
    })
}

/// Name of doing nothing, G = 0, in all tables: what errs about as much should not be used.
pub const NOTHING: &str = "always lit";

/// What rows say of the errors of their members. The order of the errors is fixed, and so is the rounding of the sums.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ErrorSummary {
    /// Of |error|; 0 without members, whose count says so.
    pub(crate) mean: f64,
    /// Of that mean.
    pub(crate) standard_error: f64,
    pub(crate) signed_mean: f64,
    /// Of |error|.
    pub(crate) p95: f64,
    pub(crate) maximum: f64,
}

impl ErrorSummary {
    pub(crate) fn of(errors: &[f64]) -> Self {
        let mut magnitudes: Vec<f64> = errors.iter().map(|error| error.abs()).collect();
        let count = errors.len().max(1) as f64;
        let mean = magnitudes.iter().sum::<f64>() / count;
        let square = magnitudes.iter().map(|error| error * error).sum::<f64>() / count;
        magnitudes.sort_by(f64::total_cmp);
        Self {
            mean: rounded(mean),
            standard_error: rounded(((square - mean * mean).max(0.0) / count).sqrt()),
            signed_mean: rounded(errors.iter().sum::<f64>() / count),
            p95: rounded(percentile(&magnitudes, 0.95)),
            maximum: rounded(magnitudes.last().copied().unwrap_or_default()),
        }
    }
}

/// Sums of the errors of fragments, beside those of doing nothing.
///
/// Doing nothing is to call every fragment lit, G = 0; it errs by F. The relative error is the sum of |G - F| over that of F.
/// Fragments that F and G both leave in the light over their whole kernel add to neither sum, so that it is the ratio over
/// shadows, penumbras and leaks alone, however far the ground goes on. The denominator does not depend on the technique: 1 is
/// as bad as no shadows at all, and above 1 a technique does harm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sums {
    pub(crate) count: usize,
    /// Of |G - F|.
    pub(crate) magnitude: f64,
    /// Of (G - F)^2.
    pub(crate) square: f64,
    /// Of G - F.
    pub(crate) signed: f64,
    /// Of F.
    reference: f64,
    /// Of F^2.
    reference_square: f64,
    /// Of |G - F| F.
    product: f64,
}

impl Sums {
    /// One more fragment, with G - F and F.
    pub(crate) fn push(&mut self, error: f32, reference: f32) {
        let (error, reference) = (f64::from(error), f64::from(reference));
        self.count += 1;
        self.magnitude += error.abs();
        self.square += error * error;
        self.signed += error;
        self.reference += reference;
        self.reference_square += reference * reference;
        self.product += error.abs() * reference;
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.magnitude += other.magnitude;
        self.square += other.square;
        self.signed += other.signed;
        self.reference += other.reference;
        self.reference_square += other.reference_square;
        self.product += other.product;
    }

    /// Mean of |G - F|; 0 for no fragments.
    pub(crate) fn mean(&self) -> f64 {
        self.magnitude / self.count.max(1) as f64
    }

    /// Standard deviation of |G - F|.
    pub(crate) fn deviation(&self) -> f64 {
        (self.square / self.count.max(1) as f64 - self.mean().powi(2)).max(0.0).sqrt()
    }

    /// Standard error of the mean of |G - F| of a sample.
    pub(crate) fn standard_error(&self) -> f64 {
        self.deviation() / (self.count.max(1) as f64).sqrt()
    }

    /// Sum of |G - F| over the sum of F; `None` where nothing is in shadow, and doing nothing is right.
    pub(crate) fn relative_error(&self) -> Option<f64> {
        (self.reference > 0.0).then(|| self.magnitude / self.reference)
    }

    /// Standard error of the relative error R of a sample: to first order that of the mean of |G - F| - R F, over the mean
    /// of F.
    pub(crate) fn relative_standard_error(&self) -> Option<f64> {
        let ratio = self.relative_error()?;
        // The mean of |G - F| - R F is 0.
        let squares = self.square - 2.0 * ratio * self.product + ratio * ratio * self.reference_square;
        Some(squares.max(0.0).sqrt() / self.reference)
    }
}

/// Least value that at least `share` of the sorted values do not exceed.
pub(crate) fn percentile(sorted: &[f64], share: f64) -> f64 {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or_default()
}

/// Rounded to the precision of the tables.
pub(crate) fn rounded(value: f64) -> f64 {
    rounded_to(value, 1e9)
}

/// Rounded to so many steps in 1; no zero is negative.
pub(crate) fn rounded_to(value: f64, steps: f64) -> f64 {
    (value * steps).round() / steps + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: &[f64]) -> Running {
        let mut running = Running::default();
        values.iter().for_each(|&value| running.add(value));
        running
    }

    #[test]
    fn repeated_values_count_as_often_as_they_occur() {
        let mut merged = Running::default();
        merged.add_repeated(2.0, 3.0);
        merged.add_repeated(-1.0, 2.0);
        let plain = of(&[2.0, 2.0, 2.0, -1.0, -1.0]);
        assert!((merged.mean - plain.mean).abs() < 1e-15 && (merged.squares - plain.squares).abs() < 1e-14);
        assert!((plain.mean - 0.8).abs() < 1e-15 && (plain.squares - 10.8).abs() < 1e-13);
    }

    #[test]
    fn strata_count_alike_and_complete_ones_are_certain() {
        let views = [of(&[1.0, 3.0]), of(&[10.0])];
        let mean = stratified(&views, &[2, 1]);
        assert_eq!((mean.value, mean.variance), (6.0, 0.0));
        // Variance of the first view's mean: 2 / 2 (1 - 2/4), a quarter of which is left.
        let mean = stratified(&views, &[4, 1]);
        assert!((mean.variance - 0.125).abs() < 1e-15);
    }

    #[test]
    fn joining_weighs_by_size() {
        let part = |value, variance| Mean { value, variance };
        let mean = joined([(part(1.0, 0.4), 1), (part(2.0, 0.1), 3)].into_iter());
        assert!((mean.value - 1.75).abs() < 1e-15);
        assert!((mean.variance - (0.4 / 16.0 + 0.1 * 9.0 / 16.0)).abs() < 1e-15);
    }

    #[test]
    fn ground_in_the_light_changes_the_mean_and_not_the_relative_error() {
        let shadow = [(-0.25, 1.0), (0.125, 0.5), (0.0, 1.0), (-0.5, 0.5)];
        let on_ground = |lit: usize| {
            let mut sums = Sums::default();
            shadow.into_iter().chain(std::iter::repeat_n((0.0, 0.0), lit)).for_each(|(e, f)| sums.push(e, f));
            sums
        };
        let (small, large) = (on_ground(0), on_ground(1_000_000));
        assert_eq!(small.relative_error(), Some(0.875 / 3.0));
        assert_eq!(large.relative_error(), small.relative_error());
        assert!(large.mean() < 1e-5 * small.mean());
        // Its standard error does not shrink with the ground either.
        let error = small.relative_standard_error().unwrap();
        assert!((large.relative_standard_error().unwrap() - error).abs() < 1e-12 && error > 0.05);
        // False shadows in the light are counted.
        let mut leaking = small;
        leaking.push(0.5, 0.0);
        assert_eq!(leaking.relative_error(), Some(1.375 / 3.0));
        // Doing nothing is its own measure, and without shadows there is none.
        let mut nothing = Sums::default();
        shadow.into_iter().for_each(|(_, f)| nothing.push(-f, f));
        assert_eq!((nothing.relative_error(), nothing.relative_standard_error()), (Some(1.0), Some(0.0)));
        assert_eq!(Sums::default().relative_error(), None);
    }

    #[test]
    fn the_standard_error_of_a_ratio_is_what_samples_scatter_by() {
        let random = &mut random_stream::Random::substream(5, 0, 0);
        let mut fragment = || {
            let reference = if random.unit() < 0.5 { 0.0 } else { random.unit() };
            (0.3 * reference * random.unit() + 0.02 * random.unit(), reference)
        };
        let ratios: Vec<(f64, f64)> = (0..2000)
            .map(|_| {
                let mut sums = Sums::default();
                for _ in 0..400 {
                    let (error, reference) = fragment();
                    sums.push(error as f32, reference as f32);
                }
                (sums.relative_error().unwrap(), sums.relative_standard_error().unwrap())
            })
            .collect();
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| ratios.iter().map(of).sum::<f64>() / ratios.len() as f64;
        let centre = mean(&|r| r.0);
        let (scatter, predicted) = (mean(&|r| (r.0 - centre).powi(2)).sqrt(), mean(&|r| r.1));
        assert!((scatter / predicted - 1.0).abs() < 0.1, "{scatter} {predicted}");
    }

    #[test]
    fn sums_of_parts_are_the_sum() {
        let (mut whole, mut parts) = (Sums::default(), [Sums::default(); 2]);
        for i in 0..100u8 {
            let (error, reference) = (f32::from(i % 7) / 8.0 - 0.25, f32::from(i % 5) / 4.0);
            whole.push(error, reference);
            parts[usize::from(i % 2)].push(error, reference);
        }
        let mut sum = parts[0];
        sum.add(&parts[1]);
        assert_eq!(sum, whole);
    }

    #[test]
    fn percentiles() {
        let values: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!(
            (percentile(&values, 0.95), percentile(&values, 1.0), percentile(&[], 0.5)),
            (95.0, 100.0, 0.0)
        );
    }
}
