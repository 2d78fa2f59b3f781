//! Shadows of surfaces that let light through, from transmittance and from absorption.

mod claims;
mod figures;
mod summary;
mod tables;
mod tradeoffs;

use super::{KindPage, Reported};
use crate::error::ReportError;
use crate::page::{Block, Content};

pub(super) const PAGE: KindPage = KindPage { name: "translucent-shadows", content, script: String::new };

fn content(reported: &Reported<'_>) -> Result<Content, ReportError> {
    let tables = summary::TranslucentTables::read(reported.run, reported.settings()?)?;
    let claims = claims::claims(&tables);
    let body = Block::body(&claims, figures::draw(reported.run, &tables)?, tables::blocks(&tables));
    let tradeoffs = Some(tradeoffs::tradeoffs(&tables));
    Ok(Content { answer: tables.answer(), claims, body, tradeoffs, ..Content::default() })
}
