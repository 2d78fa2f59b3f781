//! Error against cost of techniques, formats and map sizes.

mod claims;
mod explorer;
mod figures;
mod gpu;
mod needs;
mod summary;
mod tables;

use super::{KindPage, Recorded};
use crate::error::ReportError;
use crate::page::{Block, Content};
use evaluation::SpeedAccuracyExperiment;

pub(super) const PAGE: KindPage = KindPage { name: "speed-accuracy", content, script: explorer::script };

fn content(recorded: &Recorded<'_>) -> Result<Content, ReportError> {
    let experiment: &SpeedAccuracyExperiment = recorded.settings()?;
    let tables = summary::SpeedTables::read(recorded.run, experiment)?;
    let claims = claims::claims(&tables);
    let body = Block::body(&claims, figures::draw(&tables)?, tables::blocks(experiment, &tables));
    let explorers = explorer::explorers(experiment, &tables);
    Ok(Content { answer: tables.answer(), claims, explorers, body })
}
