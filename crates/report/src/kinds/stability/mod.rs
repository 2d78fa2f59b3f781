//! Errors and failures of closed forms on inputs that are hard in a known way.

mod claims;
mod figures;
mod steps;
mod summary;
mod tables;

use super::{KindPage, Reported};
use crate::error::ReportError;
use crate::page::{Block, Claim, Content, json};

pub(super) const PAGE: KindPage = KindPage { name: "stability", content, script };

/// What the letters of heat maps mean.
fn script() -> String {
    format!("const CELLS = {};\n", json(&steps::meanings()))
}

fn content(reported: &Reported<'_>) -> Result<Content, ReportError> {
    let tables = summary::StabilityTables::read(reported.run, reported.settings()?)?;
    let claims = claims::claims(&tables);
    // What the papers say is shown by the figures.
    let figures = figures::draw(&tables)?.into_iter().map(Block::Drawing);
    let body = figures.chain(Claim::blocks(&claims)).chain(tables::blocks(&tables)).collect();
    let breaks = tables.breaks();
    Ok(Content { answer: tables.answer(), claims, body, breaks, ..Content::default() })
}
