//! What papers claim, beside what a run measured.

use crate::page::{Block, Table, Text, row};
use evaluation::{Role, with_role};

/// A published statement or number with its counterpart.
#[derive(Clone, Debug)]
pub(crate) struct Claim {
    /// Paper and section.
    pub(crate) source: &'static str,
    pub(crate) says: String,
    /// What the run says, or why it says nothing.
    measured: Result<Text, Text>,
    /// Where the page shows it, for statements that are no numbers.
    shown_by: Text,
}

/// Why nothing was measured.
#[derive(Clone, Debug)]
pub(crate) enum Missing {
    /// The experiment does not ask for it, in these words. The page says so: a slip must not hide a claim.
    Unasked(Text),
    /// The run has no such records: it was too small, or the machine has no graphics processor.
    Records,
}

/// What was measured for a claim.
pub(crate) type Measured<T> = Result<T, Missing>;

/// Who plays a role.
pub(crate) fn player<'a, T: Role>(all: &'a [T], role: &'static str) -> Measured<&'a T> {
    with_role(all, role).ok_or_else(|| Missing::Unasked(Text::from("nobody has the role ").code(role)))
}

/// What the records say, where they say something.
pub(crate) fn recorded<T>(value: Option<T>) -> Measured<T> {
    value.ok_or(Missing::Records)
}

impl Claim {
    /// A row; nothing where the run has no such records.
    pub(crate) fn new(
        source: &'static str,
        says: impl Into<String>,
        measured: Measured<impl Into<Text>>,
    ) -> Option<Self> {
        let measured = match measured {
            Ok(text) => Ok(text.into()),
            Err(Missing::Unasked(reason)) => Err(reason),
            Err(Missing::Records) => return None,
        };
        Some(Self { source, says: says.into(), measured, shown_by: Text::default() })
    }

    pub(crate) fn shown_by(self, shown_by: Text) -> Self {
        Self { shown_by, ..self }
    }

    pub(crate) fn is_measured(&self) -> bool {
        self.measured.is_ok()
    }

    /// What was measured, or why nothing was.
    pub(crate) fn here(&self) -> Text {
        let missing = |reason| Text::joined(["not measured by this run".into(), reason], ": ");
        self.measured.clone().unwrap_or_else(missing)
    }

    /// Claims as a part of a page; nothing without any.
    pub(crate) fn blocks(claims: &[Self]) -> Vec<Block> {
        let cells = |c: &Self| row![c.source, &c.says, c.here(), c.shown_by.clone()];
        let rows = claims.iter().map(cells);
        if claims.iter().any(|claim| claim.shown_by != Text::default()) {
            let table = Table::default().left(["source", "says", "measured", "shown by"]).rows(rows);
            return Block::section(3, "What the papers say", table, None);
        }
        let rows = rows.map(|cells| cells.into_iter().take(3).collect());
        let table = Table::default().left(["source", "published", "here"]).rows(rows);
        Block::section(3, "What the papers publish", table, None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use evaluation::FilterableTechnique;

    #[test]
    fn a_role_that_nobody_plays_leaves_a_row_that_says_so() {
        let claim =
            Claim::new("paper", "it holds", player::<FilterableTechnique>(&[], "hero").map(|t| &t.name))
                .unwrap();
        assert!(!claim.is_measured());
        let text = crate::page::markdown::inline(&claim.here());
        assert_eq!(text, "not measured by this run: nobody has the role `hero`");
        assert!(Claim::new("paper", "it holds", Err::<Text, _>(Missing::Records)).is_none());
    }
}
