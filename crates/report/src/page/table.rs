//! A table of a page.

use crate::page::Text;

/// Columns, and rows with a cell for each.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    pub(crate) columns: Vec<Column>,
    pub(crate) rows: Vec<Vec<Text>>,
}

#[derive(Clone, Debug)]
pub(crate) struct Column {
    pub(crate) name: Text,
    /// Numbers stand at the right.
    pub(crate) right: bool,
}

impl Table {
    /// Further columns of words.
    pub(crate) fn left<N: Into<Text>>(mut self, names: impl IntoIterator<Item = N>) -> Self {
        self.columns.extend(names.into_iter().map(|name| Column { name: name.into(), right: false }));
        self
    }

    /// Further columns of numbers.
    pub(crate) fn right<N: Into<Text>>(mut self, names: impl IntoIterator<Item = N>) -> Self {
        self.columns.extend(names.into_iter().map(|name| Column { name: name.into(), right: true }));
        self
    }

    pub(crate) fn rows(mut self, rows: impl IntoIterator<Item = Vec<Text>>) -> Self {
        self.rows.extend(rows);
        self
    }
}

/// Cells of a row from whatever can be [`Text`].
macro_rules! row {
    ($($cell:expr),* $(,)?) => { vec![$($crate::page::Text::from($cell)),*] };
}
pub(crate) use row;
