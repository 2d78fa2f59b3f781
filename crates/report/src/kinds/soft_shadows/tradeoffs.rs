//! What the error of soft shadows costs.

use super::summary::SoftTables;
use crate::drawing::Family;
use crate::kinds::rows::least_time;
use crate::page::{Tradeoff, Tradeoffs};
use evaluation::Population;

/// Every technique under the light of the widest penumbrae.
pub(super) fn tradeoffs(tables: &SoftTables<'_>) -> Option<Tradeoffs> {
    let light = tables.widest()?;
    let techniques = tables.experiment.technique.iter().filter_map(|technique| {
        let row = tables.whole(light, Population::Fragments, &technique.name)?;
        let bound = technique.method.bound.map(|bound| bound.name());
        Some(Tradeoff {
            name: technique.name.clone(),
            family: Family::of(if technique.method.exponent.is_some() {
                &technique.name
            } else {
                bound.unwrap_or("comparison")
            })
            .name,
            size: None,
            bits: row.bits_per_texel,
            cost: least_time(&tables.samples, &technique.name, "shade")?,
            error: row.mean_error,
            margin: row.standard_error.map_or(0.0, |e| 2.0 * e),
            competes: true,
            // Sums over rectangles are rounded otherwise than the maps whose stability was measured.
            stored: None,
            breaks: None,
        })
    });
    Some(Tradeoffs {
        application: "soft shadows",
        cost: "nanoseconds a pixel, one core",
        error: format!("mean distance from the area light \"{light}\", by shadow rays"),
        techniques: techniques.collect(),
    })
}
