//! Means, how sure they are, percentiles, and the precision of the tables.

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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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

/// Sums of the errors of fragments.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    pub(crate) count: usize,
    /// Of |G - F|.
    pub(crate) magnitude: f64,
    /// Of (G - F)^2.
    pub(crate) square: f64,
    /// Of G - F.
    pub(crate) signed: f64,
}

impl Sums {
    pub(crate) fn push(&mut self, error: f32) {
        let error = f64::from(error);
        self.count += 1;
        self.magnitude += error.abs();
        self.square += error * error;
        self.signed += error;
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.magnitude += other.magnitude;
        self.square += other.square;
        self.signed += other.signed;
    }

    /// Mean of |G - F|; 0 for no fragments.
    pub(crate) fn mean(&self) -> f64 {
        self.magnitude / self.count.max(1) as f64
    }

    /// Standard deviation of |G - F|.
    pub(crate) fn deviation(&self) -> f64 {
        (self.square / self.count.max(1) as f64 - self.mean().powi(2)).max(0.0).sqrt()
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
    fn percentiles() {
        let values: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!(
            (percentile(&values, 0.95), percentile(&values, 1.0), percentile(&[], 0.5)),
            (95.0, 100.0, 0.0)
        );
    }
}
