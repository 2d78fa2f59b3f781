//! What the error of shadows gathered over time costs.

use super::summary::TemporalTables;
use crate::drawing::Family;
use crate::kinds::rows::least_time;
use crate::page::{Tradeoff, Tradeoffs};

/// Every technique in the last judged frame of a still camera.
pub(super) fn tradeoffs(tables: &TemporalTables<'_>) -> Option<Tradeoffs> {
    let (light, path) = (tables.middle()?, tables.still()?);
    let techniques = tables.experiment.technique.iter().filter_map(|technique| {
        let row = tables.last((light, path), &technique.name, "all").filter(|row| row.receivers > 0)?;
        Some(Tradeoff {
            name: technique.name.clone(),
            family: Family::of(&technique.name).name,
            size: None,
            bits: row.bits_per_texel,
            cost: least_time(&tables.samples, &technique.name, "frame")?,
            error: row.l1_error,
            margin: 2.0 * row.standard_error,
            // Shadow rays in place of maps are no method for a frame.
            competes: technique.role.as_deref() != Some("sampling by rays"),
            stored: None,
            breaks: None,
        })
    });
    Some(Tradeoffs {
        application: "light over time",
        cost: "nanoseconds a pixel and frame, one core",
        error: format!("mean distance from the {light} area light after the last frame of a still camera"),
        techniques: techniques.collect(),
    })
}
