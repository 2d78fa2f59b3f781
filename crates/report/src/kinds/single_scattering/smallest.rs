//! The smallest model: for each scene how many moments, or how many samples a ray, keep the mean error below a tolerance, and
//! which of the two is cheaper.

use super::summary::ScatteringTables;
use crate::kinds::rows::distinct;
use crate::page::{Block, Table, Text, percent, row};
use evaluation::ScatteringCost;

/// A family of methods that is compared with others.
#[derive(Clone, Copy, PartialEq)]
enum Family {
    Moments,
    Samples,
}

impl Family {
    fn holds(self, cost: &ScatteringCost) -> bool {
        match self {
            Self::Moments => cost.moments > 0,
            Self::Samples => cost.steps > 0,
        }
    }
}

/// Least cost of a family on a scene within a tolerance, with its error.
fn cheapest<'a>(
    tables: &'a ScatteringTables<'_>,
    scene: &str,
    tolerance: f64,
    family: Family,
) -> Option<(&'a ScatteringCost, f64)> {
    let of = |cost: &'a ScatteringCost| {
        let error = match scene {
            "all" => tables.pooled(&cost.technique, ("all", "all"))?.l1_error,
            scene => tables.of_scene(&cost.technique, scene)?.l1_error,
        };
        (family.holds(cost) && error <= tolerance).then_some((cost, error))
    };
    let within = tables.costs.iter().filter_map(of);
    within.min_by(|a, b| a.0.total.total_cmp(&b.0.total))
}

fn scenes<'a>(tables: &'a ScatteringTables<'_>) -> Vec<&'a str> {
    let mut scenes = distinct(tables.views.iter().map(|view| view.scene.as_str()));
    if scenes.len() > 1 {
        scenes.push("all");
    }
    scenes
}

/// A sentence a tolerance.
pub(super) fn findings(tables: &ScatteringTables<'_>) -> Vec<String> {
    let of = |&tolerance: &f64| {
        let of_scene = |scene: &&str| {
            let [moments, samples] =
                [Family::Moments, Family::Samples].map(|family| cheapest(tables, scene, tolerance, family));
            let words = match (moments, samples) {
                (Some((moments, _)), Some((samples, _))) => format!(
                    "{} moments ({:.0} MB) or {} samples ({:.0} MB)",
                    moments.moments, moments.total, samples.steps, samples.total
                ),
                (Some((moments, _)), None) => {
                    format!("{} moments ({:.0} MB)", moments.moments, moments.total)
                }
                (None, Some((samples, _))) => format!("{} samples ({:.0} MB)", samples.steps, samples.total),
                (None, None) => "nothing here".to_owned(),
            };
            format!("{scene}: {words}")
        };
        let all: Vec<String> = scenes(tables).iter().map(of_scene).collect();
        let [width, height, side] = tables.experiment.frame;
        format!(
            "The cheapest within {} of error, in modelled cost of a {width}x{height} frame with {side}² maps: {}.",
            percent(tolerance, 0),
            all.join("; ")
        )
    };
    tables.experiment.tolerances.iter().map(of).collect()
}

pub(super) fn blocks(tables: &ScatteringTables<'_>) -> Vec<Block> {
    let mut rows = Vec::new();
    for scene in scenes(tables) {
        for &tolerance in &tables.experiment.tolerances {
            let cells = |family| {
                let found = cheapest(tables, scene, tolerance, family);
                let of = |text: &dyn Fn(&ScatteringCost, f64) -> String| -> Text {
                    found.map_or_else(|| "none".to_owned(), |(cost, error)| text(cost, error)).into()
                };
                [
                    of(&|cost, _| cost.technique.clone()),
                    of(&|_, error| percent(error, 2)),
                    of(&|cost, _| format!("{:.0}", cost.megabytes)),
                    of(&|cost, _| format!("{:.0}", cost.megaoperations)),
                    of(&|cost, _| format!("{:.0}", cost.total)),
                ]
            };
            let mut all = row![scene, percent(tolerance, 0)];
            all.extend(cells(Family::Moments));
            all.extend(cells(Family::Samples));
            rows.push(all);
        }
    }
    let of_family = ["error", "MB", "million operations", "cost, MB"];
    let table = Table::default()
        .left(["scene"])
        .right(["tolerance"])
        .left(["moments"])
        .right(of_family)
        .left(["samples"])
        .right(of_family)
        .rows(rows);
    let [width, height, side] = tables.experiment.frame;
    let note = Text::from(format!(
        "For each scene and tolerance of the mean error the cheapest technique with moments and the cheapest number of \
         samples; cost is bytes plus a sixteenth of the operations, in megabytes, for a frame of {width}x{height} pixels with \
         square maps of side {side}. It is a model without a clock: a sample moves the 2 bytes of its depth, a look-up the \
         texel once."
    ));
    [Block::section(2, "The smallest model", table, Some(note)), costs(tables)].concat()
}

fn costs(tables: &ScatteringTables<'_>) -> Vec<Block> {
    let error = |cost: &ScatteringCost| {
        tables.pooled(&cost.technique, ("all", "all")).map(|r| percent(r.l1_error, 2))
    };
    let table = Table::of(&tables.costs)
        .left("technique", |c| &c.technique)
        .right("error", error)
        .right("bytes a texel", |c| format!("{:.0}", c.bytes_per_texel))
        .right("a pixel", |c| format!("{:.0}", c.bytes_per_pixel))
        .right("operations a texel", |c| format!("{:.0}", c.operations_per_texel))
        .right("a pixel", |c| format!("{:.0}", c.operations_per_pixel))
        .right("MB", |c| format!("{:.0}", c.megabytes))
        .right("million operations", |c| format!("{:.0}", c.megaoperations))
        .right("cost, MB", |c| format!("{:.0}", c.total));
    Block::section(3, "Modelled cost", table, None)
}
