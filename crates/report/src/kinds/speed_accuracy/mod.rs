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

pub(super) const PAGE: KindPage = KindPage { name: "speed-accuracy", content, script: explorer::script };

fn content(recorded: &Recorded<'_>) -> Result<Content, ReportError> {
    let tables = summary::SpeedTables::read(recorded.run, recorded.settings()?)?;
    let claims = claims::claims(&tables);
    let body = Block::body(&claims, figures::draw(&tables)?, tables::blocks(&tables));
    let explorers = explorer::explorers(&tables);
    Ok(Content { answer: tables.answer(), claims, explorers, body })
}
