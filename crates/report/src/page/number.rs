//! How pages show numbers.

/// A fraction in percent, with its sign.
pub(crate) fn percent(fraction: f64, digits: usize) -> String {
    in_percent(fraction, digits) + " %"
}

/// A fraction in percent, under a heading that says so.
pub(crate) fn in_percent(fraction: f64, digits: usize) -> String {
    format!("{:.digits$}", 100.0 * fraction)
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
    fn counts_are_told_in_units_that_fit() {
        let told = [0, 412, 9_999, 12_345, 2_345_678, 3_456_000_000].map(count_of);
        assert_eq!(told, ["0", "412", "9999", "12 thousand", "2.3 million", "3.5 billion"]);
    }
}
