//! The order of techniques that the papers claim, checked in every view.

use super::summary::FilterableTables;
use crate::kinds::rows::distinct;
use crate::page::{Block, Table, Text, in_percent, row};
use evaluation::{FilterableExperiment, FilterableRecord, FilterableTechnique};

/// From the least error to the largest (MSM15 Figure 4).
const GROUPS: [&str; 4] = ["PCF", "four moments", "EVSM", "VSM and ESM"];

/// Place in the claimed order; nothing for techniques that the claim does not name, or with options that change them.
fn group(experiment: &FilterableExperiment, technique: &FilterableTechnique) -> Option<usize> {
    match (&technique.method, &technique.comparison) {
        (None, Some(kernel)) => (*kernel == experiment.scenery.kernel).then_some(0),
        (Some(method), _) => match method.bound?.as_str() {
            "hamburger4" | "hausdorff4" | "trigonometric4" => {
                (method.alpha.is_none() && method.beta == 0.0).then_some(1)
            }
            "evsm" => Some(2),
            "vsm" | "esm" => Some(3),
            _ => None,
        },
        (None, None) => None,
    }
}

/// A row for each view, scene and all: the exceptions from the order, by error and by leak.
pub(crate) fn blocks(tables: &FilterableTables<'_>) -> Vec<Block> {
    let experiment = tables.experiment;
    let members: Vec<(usize, &str)> = experiment
        .technique
        .iter()
        .filter_map(|technique| Some((group(experiment, technique)?, technique.name.as_str())))
        .collect();
    if !(0..GROUPS.len()).all(|wanted| members.iter().any(|(group, _)| *group == wanted)) {
        return Vec::new();
    }
    let mut places = distinct(tables.records.iter().map(|r| (r.scene.as_str(), r.view.as_str())));
    places.sort_by_key(|place| (place.0 == "all", place.1 == "all"));
    let exceptions = |place: (&str, &str), of: &dyn Fn(&FilterableRecord) -> f64| -> String {
        let value = |name: &str| tables.row(place, name, 0, "all").map(of);
        let mut found: Vec<String> = Vec::new();
        for &(better, a) in &members {
            for &(worse, b) in members.iter().filter(|(worse, _)| *worse == better + 1) {
                if let (Some(x), Some(y)) = (value(a), value(b))
                    && x >= y
                {
                    let [x, y] = [x, y].map(|value| in_percent(value, 2));
                    found.push(format!("{a} ({}) {x} >= {b} ({}) {y}", GROUPS[better], GROUPS[worse]));
                }
            }
        }
        if found.is_empty() { "none".to_owned() } else { found.join("; ") }
    };
    let rows = places.into_iter().map(|place| {
        let (by_error, by_leak) = (exceptions(place, &|r| r.l1_error), exceptions(place, &|r| r.leak));
        row![format!("{} {}", place.0, place.1), by_error, by_leak]
    });
    let table = Table::default().left(["view", "exceptions by L1 error", "exceptions by leak"]).rows(rows);
    let claim = format!(
        "Exceptions from {}, each technique against each of the next group, in percent.",
        GROUPS.join(" < ")
    );
    let note = Text::from(
        "The leak compares the same depth on both sides, so that it shows the bounds alone. In the error the bias and \
         the receiver plane of F take part, which the techniques lack: bounds that leak hide self-shadowing that PCF \
         shows.",
    );
    vec![
        Block::heading(2, "The order that the papers claim"),
        Block::paragraph(claim),
        Block::Table(table),
        Block::Paragraph(note),
    ]
}
