//! Filterable shadow maps against percentage-closer filtering on scenes.

mod claims;
mod figures;
mod order;
mod summary;
mod tables;

use super::{KindPage, Reported};
use crate::error::ReportError;
use crate::page::{Block, Content};

pub(super) const PAGE: KindPage = KindPage { name: "filterable", content, script: String::new };

fn content(reported: &Reported<'_>) -> Result<Content, ReportError> {
    let tables = summary::FilterableTables::read(reported.run, reported.settings()?)?;
    let figures = figures::draw(reported.run, &tables)?;
    let claims = claims::claims(&tables);
    let body = Block::body(&claims, figures, tables::blocks(&tables));
    Ok(Content { answer: tables.answer(), claims, body, ..Content::default() })
}
