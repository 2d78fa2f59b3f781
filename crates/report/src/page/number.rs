//! How pages show numbers.

/// A fraction in percent, with its sign.
pub(crate) fn percent(fraction: f64, digits: usize) -> String {
    in_percent(fraction, digits) + " %"
}

/// A fraction in percent, under a heading that says so.
pub(crate) fn in_percent(fraction: f64, digits: usize) -> String {
    format!("{:.digits$}", 100.0 * fraction)
}

/// A tick of an axis in percent, with the digits that it needs.
pub(crate) fn percent_tick(fraction: f64) -> String {
    let value = 100.0 * fraction;
    let is_whole = |digits: &usize| {
        let scaled = value * 10f64.powi(*digits as i32);
        (scaled - scaled.round()).abs() < 1e-6
    };
    percent(fraction, (0..4).find(is_whole).unwrap_or(4))
}

/// A count in a unit that fits.
pub(crate) fn count_of(value: u64) -> String {
    match value as f64 {
        v if v < 1e4 => format!("{v}"),
        v if v < 1e6 => format!("{:.0} thousand", v / 1e3),
        v if v < 1e9 => format!("{:.1} million", v / 1e6),
        v => format!("{:.1} billion", v / 1e9),
    }
}

/// The middle value, the upper one of two; nothing of nothing.
pub(crate) fn median_of(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_have_the_digits_that_they_need() {
        let told = [0.0, 0.05, 0.055, 0.0025, 1.0].map(percent_tick);
        assert_eq!(told, ["0 %", "5 %", "5.5 %", "0.25 %", "100 %"]);
    }

    #[test]
    fn counts_are_told_in_units_that_fit() {
        let told = [0, 412, 9_999, 12_345, 2_345_678, 3_456_000_000].map(count_of);
        assert_eq!(told, ["0", "412", "9999", "12 thousand", "2.3 million", "3.5 billion"]);
    }
}
