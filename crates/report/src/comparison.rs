//! One table over several runs: what the papers publish, what was measured, and by which command.

use crate::page::{Claim, Page, Table, Text, code, markdown, row};

/// What the papers publish about applications that msm does not have yet.
const NOT_BUILT: [(&str, &str); 1] = [(
    "BHS16 2",
    "Single scattering with six moments takes 0.71 ms, 1.1 ms with filtering (1920x1080, 1024² map, GTX 980)",
)];

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
    let not_built =
        NOT_BUILT.iter().map(|&(source, says)| row![source, says, "not built yet", Text::default()]);
    Table::default()
        .left(["source", "published", "here"])
        .left([Text::from("by ").code("msm").and(" ...")])
        .rows(rows.chain(not_built))
}
