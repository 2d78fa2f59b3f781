//! How the ranking of all bases moves with the settings of the search.

mod claims;
mod figures;
mod summary;
mod tables;

use super::{KindPage, Reported};
use crate::error::ReportError;
use crate::page::{Block, Content};

pub(super) const PAGE: KindPage = KindPage { name: "ranking-map", content, script: String::new };

fn content(reported: &Reported<'_>) -> Result<Content, ReportError> {
    let tables = summary::RankingTables::read(reported.run, reported.settings()?)?;
    let claims = claims::claims(&tables);
    let body = Block::body(&claims, figures::draw(&tables)?, tables::blocks(&tables));
    Ok(Content { answer: tables.answer(), claims, body, ..Content::default() })
}
