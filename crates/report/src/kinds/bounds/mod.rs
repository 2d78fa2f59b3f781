//! Bounds over all fragment depths for given kernels and bases.

mod figures;
mod summary;
mod tables;

use super::{KindPage, Reported};
use crate::error::ReportError;
use crate::page::{Block, Content, Drawing};
use evaluation::{BoundsExperiment, KernelRecord};

pub(super) const PAGE: KindPage = KindPage { name: "bounds", content, script: String::new };

fn content(reported: &Reported<'_>) -> Result<Content, ReportError> {
    let bounds: &BoundsExperiment = reported.settings()?;
    let tables = summary::BoundsTables::read(reported.run)?;
    let kernels: Vec<KernelRecord> = reported.run.rows("kernels.csv")?;
    let draw = |figure| figures::draw(figure, &tables, &kernels);
    let rows = tables.summary(bounds);
    let mut body = Vec::new();
    for figure in &bounds.figure {
        body.push(Block::Drawing(Drawing::new(&figure.id, &figure.title, draw(figure)?)));
    }
    body.extend(tables::table(&rows));
    Ok(Content { answer: summary::answer(bounds, &tables, &rows), body, ..Content::default() })
}
