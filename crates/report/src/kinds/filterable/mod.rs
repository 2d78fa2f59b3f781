//! Filterable shadow maps against percentage-closer filtering on scenes.

mod claims;
mod figures;
mod order;
mod summary;
mod tables;

use super::{KindPage, Recorded};
use crate::error::ReportError;
use crate::page::{Block, Content};
use evaluation::FilterableExperiment;

pub(super) const PAGE: KindPage = KindPage { name: "filterable", content, script: String::new };

fn content(recorded: &Recorded<'_>) -> Result<Content, ReportError> {
    let experiment: &FilterableExperiment = recorded.settings()?;
    let tables = summary::Tables::read(recorded.run, experiment)?;
    let figures = figures::draw(recorded.run, experiment, &tables)?;
    let claims = claims::claims(&tables, experiment);
    let body = Block::body(&claims, figures, tables::blocks(experiment, &tables));
    Ok(Content { answer: tables.answer(experiment), claims, body, ..Content::default() })
}
