//! One table over several runs: what the papers publish, what was measured, and by which command.

use crate::page::{Claim, Page, Table, Text, code, markdown, row};

/// The table in Markdown.
pub fn comparison(pages: &[Page]) -> String {
    markdown::table(&table(pages))
}

pub(crate) fn table(pages: &[Page]) -> Table {
    let claims = || pages.iter().flat_map(|page| page.content.claims.iter().map(move |claim| (page, claim)));
    let is_measured = |of: &Claim| {
        claims().any(|(_, other)| other.is_measured() && (other.source, &other.says) == (of.source, &of.says))
    };
    // What one run lacks another may have.
    let shown = claims().filter(|(_, claim)| claim.is_measured() || !is_measured(claim));
    let rows = shown.map(|(page, c)| row![c.source, &c.says, c.here(), code(page.arguments())]);
    Table::default()
        .left(["source", "published", "here"])
        .left([Text::from("by ").code("msm").and(" ...")])
        .rows(rows)
}
