//! Soft shadows gathered over frames against the area light itself.

mod claims;
mod figures;
mod summary;
mod tables;
mod tradeoffs;

use super::{KindPage, Reported};
use crate::error::ReportError;
use crate::page::{Block, Content};

pub(super) const PAGE: KindPage = KindPage { name: "temporal-shadows", content, script: String::new };

fn content(reported: &Reported<'_>) -> Result<Content, ReportError> {
    let tables = summary::TemporalTables::read(reported.run, reported.settings()?)?;
    let claims = claims::claims(&tables);
    let body = Block::body(&claims, figures::draw(reported.run, &tables)?, tables::blocks(&tables));
    let tradeoffs = tradeoffs::tradeoffs(&tables);
    let explorers = figures::films(&tables);
    Ok(Content { answer: tables.answer(), claims, body, explorers, tradeoffs, ..Content::default() })
}
