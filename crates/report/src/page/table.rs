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

/// A table whose columns say what they show of each row.
pub(crate) struct Columns<R> {
    rows: Vec<R>,
    table: Table,
}

impl Table {
    /// Of these rows, without columns yet.
    pub(crate) fn of<R: Copy>(rows: impl IntoIterator<Item = R>) -> Columns<R> {
        let rows: Vec<R> = rows.into_iter().collect();
        let table = Self { rows: vec![Vec::new(); rows.len()], ..Self::default() };
        Columns { rows, table }
    }
}

impl<R: Copy> Columns<R> {
    fn column<T: Into<Text>>(mut self, right: bool, name: impl Into<Text>, cell: impl Fn(R) -> T) -> Self {
        self.table.columns.push(Column { name: name.into(), right });
        for (cells, &row) in self.table.rows.iter_mut().zip(&self.rows) {
            cells.push(cell(row).into());
        }
        self
    }

    /// A column of words.
    pub(crate) fn left<T: Into<Text>>(self, name: impl Into<Text>, cell: impl Fn(R) -> T) -> Self {
        self.column(false, name, cell)
    }

    /// A column of numbers that only some tables have: none where no row has one.
    pub(crate) fn right_if_any<T: Into<Text>>(
        self,
        name: impl Into<Text>,
        cell: impl Fn(R) -> Option<T>,
    ) -> Self {
        if self.rows.iter().any(|&row| cell(row).is_some()) { self.right(name, cell) } else { self }
    }

    /// A column of numbers.
    pub(crate) fn right<T: Into<Text>>(self, name: impl Into<Text>, cell: impl Fn(R) -> T) -> Self {
        self.column(true, name, cell)
    }
}

impl<R> From<Columns<R>> for Table {
    fn from(columns: Columns<R>) -> Self {
        columns.table
    }
}

/// Cells of a row from whatever can be [`Text`].
macro_rules! row {
    ($($cell:expr),* $(,)?) => { vec![$($crate::page::Text::from($cell)),*] };
}
pub(crate) use row;
