//! What the error of hard shadows costs.

use super::figures::COST;
use super::summary::SpeedTables;
use crate::drawing::Family;
use crate::page::{Tradeoff, Tradeoffs};

/// The best of each technique, format and size over all fragments.
pub(super) fn tradeoffs(tables: &SpeedTables<'_>) -> Tradeoffs {
    let of = |r: &evaluation::SpeedAccuracyRecord| {
        let competes = r.format != "depth";
        Tradeoff {
            name: if competes { format!("{}, {}", r.technique, r.format) } else { r.technique.clone() },
            family: Family::of(&r.technique).name,
            size: Some(r.size),
            bits: r.bits_per_texel,
            cost: r.cost,
            error: r.l1_error,
            margin: 2.0 * r.standard_error.unwrap_or_default(),
            competes,
            stored: Some((format!("{}, {}", r.technique, r.format), r.alpha)),
            breaks: None,
        }
    };
    Tradeoffs {
        application: "hard shadows",
        cost: COST,
        error: "mean |G - F|; F is percentage-closer filtering, grey, which no other can beat".to_owned(),
        techniques: tables.best().map(of).collect(),
    }
}
