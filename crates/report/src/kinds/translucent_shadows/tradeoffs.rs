//! What the error of shadows of smoke and glass costs.

use super::summary::TranslucentTables;
use crate::kinds::rows::least_time;
use crate::kinds::stored::{family, stored};
use crate::page::{Tradeoff, Tradeoffs};

/// Every technique on opaque surfaces.
pub(super) fn tradeoffs(tables: &TranslucentTables<'_>) -> Tradeoffs {
    let techniques = tables.experiment.technique.iter().filter_map(|technique| {
        let row = tables.row(&technique.name, "surfaces")?;
        let spec = technique.blended.as_ref().or(technique.absorbance.as_ref());
        Some(Tradeoff {
            name: technique.name.clone(),
            family: family(spec, &technique.name),
            size: None,
            bits: row.bits_per_texel.round() as usize,
            cost: least_time(&tables.samples, &technique.name, "shade")?,
            error: row.l1_error,
            margin: 2.0 * row.standard_error,
            competes: true,
            stored: stored(technique.blended.as_ref()),
            breaks: None,
        })
    });
    Tradeoffs {
        application: "smoke and glass",
        cost: "nanoseconds a pixel, one core",
        error: "mean distance from the truth on surfaces behind translucent casters".to_owned(),
        techniques: techniques.collect(),
    }
}
