//! All bases of a family, ranked by their error on scenes.

mod claims;
mod explorer;
mod figures;
mod summary;
mod tables;

use super::{KindPage, Recorded};
use crate::error::ReportError;
use crate::page::{Block, Content};

pub(super) const PAGE: KindPage = KindPage { name: "search", content, script: explorer::script };

fn content(recorded: &Recorded<'_>) -> Result<Content, ReportError> {
    let tables = summary::SearchTables::read(recorded.run, recorded.settings()?)?;
    let claims = claims::claims(&tables, recorded.provenance);
    let body = Block::body(&claims, figures::draw(&tables)?, tables::blocks(&tables));
    let explorers = explorer::candidates(&tables)?.into_iter().collect();
    Ok(Content { answer: tables.answer(), claims, explorers, body })
}
