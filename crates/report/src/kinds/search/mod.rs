//! All bases of a family, ranked by their error on scenes.

mod claims;
mod explorer;
mod figures;
mod summary;
mod tables;

use super::{KindPage, Reported};
use crate::error::ReportError;
use crate::page::{Block, Content};

pub(super) const PAGE: KindPage = KindPage { name: "search", content, script: explorer::script };

fn content(reported: &Reported<'_>) -> Result<Content, ReportError> {
    let tables = summary::SearchTables::read(reported.run, reported.settings()?)?;
    let claims = claims::claims(&tables, reported.provenance);
    let body = Block::body(&claims, figures::draw(&tables)?, tables::blocks(&tables));
    let explorers = explorer::candidates(&tables)?.into_iter().collect();
    Ok(Content { answer: tables.answer(), claims, explorers, body, ..Content::default() })
}
