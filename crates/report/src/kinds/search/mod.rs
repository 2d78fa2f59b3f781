//! All bases of a family, ranked by their error on scenes.

mod claims;
mod explorer;
mod figures;
mod summary;
mod tables;

use super::{KindPage, Recorded};
use crate::error::ReportError;
use crate::page::{Block, Content};
use evaluation::SearchExperiment;

pub(super) const PAGE: KindPage = KindPage { name: "search", content, script: explorer::script };

fn content(recorded: &Recorded<'_>) -> Result<Content, ReportError> {
    let experiment: &SearchExperiment = recorded.settings()?;
    let tables = summary::SearchTables::read(recorded.run)?;
    let claims = claims::claims(&tables, experiment, recorded.provenance);
    let body = Block::body(&claims, figures::draw(&tables)?, tables::blocks(experiment, &tables));
    let explorers = explorer::candidates(experiment, &tables)?.into_iter().collect();
    Ok(Content { answer: tables.answer(), claims, explorers, body })
}
