//! The figures of a `soft-shadows` run: errors of all techniques, sweeps, single receivers, sheets of error maps.

use super::receiver;
use super::summary::SoftTables;
use super::sweeps;
use crate::drawing::{DotChart, DotRow, ErrorColours, error_sheet};
use crate::error::ReportError;
use crate::page::Drawing;
use evaluation::{Population, RunDirectory, SoftRecord, map_name};

/// What a pixel of an error map shows.
const PIXEL: [&str; 2] =
    ["method minus truth at each pixel; pixels", "that do not face the light count as right"];

pub(super) fn draw(run: &RunDirectory, tables: &SoftTables<'_>) -> Result<Vec<Drawing>, ReportError> {
    let mut figures = Vec::new();
    for light in tables.lights() {
        figures.extend(errors(tables, light)?);
    }
    figures.extend(sweeps::charts(tables)?);
    figures.extend(tables.gpu_charts()?);
    figures.extend(receiver::draw(tables)?);
    for picture in &tables.experiment.picture {
        let tiles: Vec<_> = picture
            .techniques
            .iter()
            .map(|name| (name.clone(), run.path().join(map_name(&picture.id, &picture.light, name))))
            .collect();
        let title = format!("method - truth, {}, light \"{}\"", picture.scene, picture.light);
        let sheet = error_sheet(&tiles, &title, ErrorColours::Signed, PIXEL)?;
        figures.push(Drawing::new(format!("leak-{}", picture.id), title, sheet));
    }
    Ok(figures)
}

/// A row a technique, with a dot for fragments and one for the camera.
fn errors(tables: &SoftTables<'_>, light: &str) -> Result<Option<Drawing>, ReportError> {
    let of = |population| {
        let techniques = tables.experiment.technique.iter();
        techniques.filter_map(|t| tables.whole(light, population, &t.name)).collect::<Vec<&SoftRecord>>()
    };
    let (fragments, camera) = (of(Population::Fragments), of(Population::Camera));
    let row = |r: &&SoftRecord| DotRow {
        name: r.technique.clone(),
        first: r.mean_error,
        margin: r.standard_error.map_or(0.0, |e| 2.0 * e),
        second: camera.iter().find(|seen| seen.technique == r.technique).map(|seen| seen.mean_error),
    };
    let id = format!("errors-{}", tables.experiment.scenery.words(light));
    let chart = DotChart {
        title: format!("Mean distance from the area light, light \"{light}\" (less is better)"),
        x: "mean |method - truth|, of the light",
        words: ["fragments", "camera"],
        legend: [
            ("all fragments that light could reach, with twice the standard error", 200),
            ("what the camera sees", 600),
        ],
        rows: fragments.iter().map(row).collect(),
    };
    chart.drawing(id)
}
