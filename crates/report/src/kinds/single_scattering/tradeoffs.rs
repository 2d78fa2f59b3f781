//! What the error of single scattering costs.

use super::summary::{ALL, ScatteringTables};
use crate::kinds::stored::{family, stored};
use crate::page::{Tradeoff, Tradeoffs};

/// Every technique whose cost is modelled.
pub(super) fn tradeoffs(tables: &ScatteringTables<'_>) -> Tradeoffs {
    let techniques = tables.costs.iter().filter_map(|cost| {
        let row = tables.pooled(&cost.technique, ALL)?;
        let technique = tables.experiment.technique.iter().find(|t| t.name == cost.technique)?;
        let spec = technique.method.stored.as_ref();
        Some(Tradeoff {
            name: cost.technique.clone(),
            family: family(spec, &cost.technique),
            size: None,
            bits: row.bits_per_texel,
            cost: cost.total,
            error: row.l1_error,
            margin: row.standard_error.map_or(0.0, |e| 2.0 * e),
            competes: true,
            stored: stored(spec),
            breaks: None,
        })
    });
    Tradeoffs {
        application: "single scattering",
        cost: "modelled cost of a frame, MB",
        error: "mean distance from the shadow map's exact integral, of the unshadowed light".to_owned(),
        techniques: techniques.collect(),
    }
}
