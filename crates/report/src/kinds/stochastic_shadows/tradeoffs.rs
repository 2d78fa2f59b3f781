//! What the error of shadows through a lens costs.

use super::summary::StochasticTables;
use crate::kinds::rows::least_time;
use crate::kinds::stored::{family, stored};
use crate::page::{Tradeoff, Tradeoffs};

/// Every technique under the largest light.
pub(super) fn tradeoffs(tables: &StochasticTables<'_>) -> Option<Tradeoffs> {
    let light = tables.largest()?;
    let techniques = tables.experiment.technique.iter().filter_map(|technique| {
        let row = tables.row(light, &technique.name, "all")?;
        let spec = technique.stochastic.as_ref().map(|setting| &setting.basis);
        Some(Tradeoff {
            name: technique.name.clone(),
            family: family(spec, &technique.name),
            size: None,
            bits: row.bits_per_texel,
            cost: least_time(&tables.samples, &technique.name, "shade")?,
            error: row.l1_error,
            margin: 2.0 * row.standard_error,
            competes: true,
            stored: stored(spec),
            breaks: None,
        })
    });
    Some(Tradeoffs {
        application: "light through a lens",
        cost: "nanoseconds a pixel, one core",
        error: format!("mean distance from the {light} area light"),
        techniques: techniques.collect(),
    })
}
