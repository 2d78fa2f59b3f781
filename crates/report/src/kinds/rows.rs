//! What every kind asks of the rows of a table.

use crate::error::ReportError;
use evaluation::RunDirectory;
use serde::de::DeserializeOwned;

/// Each value once, in the order of their first appearance.
pub(crate) fn distinct<T: PartialEq>(values: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut distinct = Vec::new();
    for value in values {
        if !distinct.contains(&value) {
            distinct.push(value);
        }
    }
    distinct
}

/// The rows of a table that only some runs have.
pub(crate) fn rows_if_there<R: DeserializeOwned>(
    run: &RunDirectory,
    file: &str,
) -> Result<Vec<R>, ReportError> {
    Ok(if run.path().join(file).is_file() { run.rows(file)? } else { Vec::new() })
}
