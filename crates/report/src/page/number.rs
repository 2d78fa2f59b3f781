//! How pages show numbers.

/// A fraction in percent, with its sign.
pub(crate) fn percent(fraction: f64, digits: usize) -> String {
    in_percent(fraction, digits) + " %"
}

/// A fraction in percent, under a heading that says so.
pub(crate) fn in_percent(fraction: f64, digits: usize) -> String {
    format!("{:.digits$}", 100.0 * fraction)
}

/// The middle value, the upper one of two; nothing of nothing.
pub(crate) fn median_of(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
