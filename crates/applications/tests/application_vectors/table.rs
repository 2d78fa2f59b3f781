//! A file of reference numbers.

use std::path::{Path, PathBuf};

use serde_json::Value;

/// All rows of a file.
pub struct Table {
    path: PathBuf,
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

/// One row of a table.
#[derive(Clone, Copy)]
pub struct Row<'a> {
    header: &'a [String],
    cells: &'a [String],
}

impl Table {
    pub fn read(path: &Path) -> Result<Self, String> {
        let context = |e: csv::Error| format!("{}: {e}", path.display());
        let mut reader = csv::Reader::from_path(path).map_err(context)?;
        let header = reader.headers().map_err(context)?.iter().map(str::to_owned).collect();
        let cells = |record: csv::StringRecord| record.iter().map(str::to_owned).collect();
        let rows: Vec<Vec<String>> =
            reader.records().map(|r| r.map(cells)).collect::<Result<_, _>>().map_err(context)?;
        if rows.is_empty() {
            return Err(format!("{} has no rows", path.display()));
        }
        Ok(Self { path: path.to_owned(), header, rows })
    }

    pub fn rows(&self) -> Vec<Row<'_>> {
        self.rows.iter().map(|cells| Row { header: &self.header, cells }).collect()
    }

    /// Another file of the same folder.
    pub fn sibling(&self, name: &str) -> PathBuf {
        self.path.with_file_name(name)
    }

    /// Checks each row; an error names the file and the row.
    pub fn each(&self, check: impl Fn(&Row) -> Result<(), String>) -> Result<(), String> {
        self.rows().iter().try_for_each(|row| check(row).map_err(|e| self.located(row, e)))
    }

    pub fn located(&self, row: &Row, error: String) -> String {
        format!("{}, row with id {}: {error}", self.path.display(), row.cells[0])
    }
}

impl<'a> Row<'a> {
    pub fn text(&self, column: &str) -> Result<&'a str, String> {
        let index = self.header.iter().position(|name| name == column);
        index.map(|i| self.cells[i].as_str()).ok_or_else(|| format!("no column `{column}`"))
    }

    /// The number of a cell; `None` where it is empty.
    pub fn optional(&self, column: &str) -> Result<Option<f64>, String> {
        let text = self.text(column)?;
        if text.is_empty() {
            return Ok(None);
        }
        text.parse().map(Some).map_err(|e| format!("{column}: `{text}`: {e}"))
    }

    pub fn number(&self, column: &str) -> Result<f64, String> {
        self.optional(column)?.ok_or_else(|| format!("{column} is empty"))
    }

    pub fn numbers<const N: usize>(&self, columns: [&str; N]) -> Result<[f64; N], String> {
        let mut values = [0.0; N];
        for (value, column) in values.iter_mut().zip(columns) {
            *value = self.number(column)?;
        }
        Ok(values)
    }

    pub fn integer(&self, column: &str) -> Result<u64, String> {
        let text = self.text(column)?;
        text.parse().map_err(|e| format!("{column}: `{text}`: {e}"))
    }

    pub fn flag(&self, column: &str) -> Result<bool, String> {
        Ok(self.integer(column)? != 0)
    }

    pub fn json(&self, column: &str) -> Result<Value, String> {
        let text = self.text(column)?;
        serde_json::from_str(text).map_err(|e| format!("{column}: `{text}`: {e}"))
    }

    /// A cell that lists numbers.
    pub fn list(&self, column: &str) -> Result<Vec<f64>, String> {
        serde_json::from_value(self.json(column)?).map_err(|e| format!("{column}: {e}"))
    }

    /// Compares a result with a column.
    pub fn close(&self, column: &str, got: f64, tolerance: f64) -> Result<(), String> {
        close(column, got, self.number(column)?, tolerance)
    }
}

pub fn close(what: &str, got: f64, expected: f64, tolerance: f64) -> Result<(), String> {
    // Not of NaN.
    let is_close = (got - expected).abs() <= tolerance;
    if is_close {
        return Ok(());
    }
    let distance = (got - expected).abs();
    Err(format!(
        "{what}: {got} instead of {expected}, {distance:.3e} apart where {tolerance:.3e} are allowed"
    ))
}

/// A comparison that nothing fails is none: wrong, missing and undefined numbers are seen.
pub fn finds_planted_faults() -> Result<(), String> {
    let header = ["id", "value", "empty"].map(str::to_owned).to_vec();
    let table = Table {
        path: "planted.csv".into(),
        header,
        rows: vec![["7", "0.25", ""].map(str::to_owned).to_vec()],
    };
    let check = |got: f64, column: &str| table.each(|row| row.close(column, got, 1e-9));
    check(0.25 + 1e-10, "value")?;
    for (got, column) in [(0.25 + 1e-8, "value"), (f64::NAN, "value"), (0.25, "empty"), (0.25, "values")] {
        match check(got, column) {
            Ok(()) => return Err(format!("{got} passed for `{column}`")),
            Err(error) if error.contains("planted.csv, row with id 7") => {}
            Err(error) => return Err(format!("`{error}` names no file and row")),
        }
    }
    Ok(())
}
