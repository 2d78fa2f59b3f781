//! Error against cost with filters, and pictures to compare.

use super::figures::{FAMILIES, OTHERS, family};
use super::summary::SpeedTables;
use super::tables::recorded_picture;
use crate::drawing::{BLACK, css};
use crate::page::{Explorer, RecordedPicture, json};
use plotters::style::RGBColor;
use serde::Serialize;
use std::collections::BTreeMap;

/// Black would not be seen on a dark page.
const GREY_FOR_BLACK: RGBColor = RGBColor(136, 136, 136);

/// A point of the chart of error against cost.
#[derive(Serialize)]
struct ExplorerPoint<'a> {
    technique: &'a str,
    family: &'static str,
    format: &'a str,
    size: u32,
    bits: usize,
    cost: f64,
    error: f64,
    /// In units of doing nothing, where it was recorded.
    relative: Option<f64>,
    /// Whether it takes part in the front.
    competes: bool,
}

/// Colours of families.
pub(super) fn script() -> String {
    let colour = |colour: RGBColor| css(if colour == BLACK { GREY_FOR_BLACK } else { colour });
    let families = FAMILIES.iter().chain([&OTHERS]);
    let colours: BTreeMap<_, _> = families.map(|family| (family.name, colour(family.colour))).collect();
    format!("const FAMILIES = {};\n", json(&colours))
}

/// The best of each technique, format and size over all fragments; then the pictures of all views.
pub(super) fn explorers(tables: &SpeedTables<'_>) -> Vec<Explorer> {
    let points = tables.best().map(|r| ExplorerPoint {
        technique: &r.technique,
        family: family(&r.technique).name,
        format: &r.format,
        size: r.size,
        bits: r.bits_per_texel,
        cost: r.cost,
        error: r.l1_error,
        relative: r.relative_error,
        competes: r.format != "depth",
    });
    let chart = Explorer::Chart {
        class: "explorer",
        data: json(&points.collect::<Vec<_>>()),
        without_script: Some("The chart below is the same without filters."),
    };
    let pictures = tables.pictures();
    let compared = pictures.first().map(|first| first.columns.clone());
    let compared = compared.map(|columns| Explorer::Pictures(columns, pictures));
    [Some(chart), compared].into_iter().flatten().collect()
}

impl SpeedTables<'_> {
    /// The pictures of all views, where they were asked for.
    pub(super) fn pictures(&self) -> Vec<RecordedPicture> {
        let views = self.views.iter().map(|view| (view.scene.as_str(), view.view.as_str()));
        self.experiment.pictures_of_views(views).iter().map(recorded_picture).collect()
    }
}
