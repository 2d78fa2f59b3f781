//! One table over several runs: what the papers publish, what was measured, and by which command.

use crate::page::{Claim, Page, Table, Text, code, markdown, row};

/// What the papers publish about applications that msm does not have yet.
const NOT_BUILT: [(&str, &str); 2] = [
    (
        "BHS16 2",
        "Single scattering with six moments takes 0.71 ms, 1.1 ms with filtering (1920x1080, 1024² map, GTX 980)",
    ),
    ("BHS16 3", "Moment soft shadows take 2.7 ms, 3.48 ms interpolated (same setting)"),
];

/// The table in Markdown.
pub fn comparison(pages: &[Page]) -> String {
    markdown::table(&table(pages))
}

pub(crate) fn table(pages: &[Page]) -> Table {
    let measured = pages.iter().flat_map(|page| {
        let row =
            |claim: &Claim| row![claim.source, &claim.says, claim.measured.clone(), code(page.arguments())];
        page.content.claims.iter().map(row)
    });
    let not_built = NOT_BUILT.iter().map(|&(source, says)| row![source, says, "not built yet", ""]);
    Table::default()
        .left(["source", "published", "here"])
        .left([Text::from("by ").code("msm").and(" ...")])
        .rows(measured.chain(not_built))
}
