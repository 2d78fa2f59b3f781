//! Error against cost of techniques, formats and map sizes.

mod claims;
mod explorer;
mod figures;
mod gpu;
mod needs;
mod summary;
mod tables;
mod tradeoffs;

use super::{KindPage, Reported};
use crate::error::ReportError;
use crate::page::{Block, Content};

pub(super) const PAGE: KindPage = KindPage { name: "speed-accuracy", content, script: String::new };

fn content(reported: &Reported<'_>) -> Result<Content, ReportError> {
    let tables = summary::SpeedTables::read(reported.run, reported.settings()?)?;
    let claims = claims::claims(&tables);
    let body = Block::body(&claims, figures::draw(&tables)?, tables::blocks(&tables));
    let explorers = explorer::explorers(&tables);
    let tradeoffs = Some(tradeoffs::tradeoffs(&tables));
    Ok(Content { answer: tables.answer(), claims, explorers, body, tradeoffs, ..Content::default() })
}
