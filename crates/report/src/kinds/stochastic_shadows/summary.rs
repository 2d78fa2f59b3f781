//! What the records of a `stochastic-shadows` experiment say, in numbers.

use crate::kinds::rows::tables;
use crate::page::{Measured, Text, percent, player, recorded};
use evaluation::{
    ModulationRecord, PlaneRecord, StochasticPictureRecord, StochasticRecord, StochasticShadowsExperiment,
    StochasticViewRecord, TimedSample, with_role,
};

tables! {
    /// The recorded tables of a run, with its experiment.
    StochasticTables<'a> of StochasticShadowsExperiment {
        records: StochasticRecord,
        views: StochasticViewRecord,
        planes: PlaneRecord,
        samples: TimedSample,
    }
    some_runs {
        pictures: StochasticPictureRecord,
        modulation: ModulationRecord,
    }
}

/// Roles of the representations on the same planes.
pub(super) const BASES: [&str; 9] = [
    "published",
    "smaller exponent",
    "variance",
    "four moments",
    "four moments, 16 bits",
    "Hausdorff",
    "trigonometric",
    "six moments",
    "eight moments",
];

/// Roles of changes to four moments on four planes.
pub(super) const CHANGES: [&str; 15] = [
    "one plane",
    "two planes",
    "eight planes",
    "planes at receivers",
    "projected",
    "rectangle",
    "every sample",
    "no edges",
    "least radius 0.5",
    "least radius 2",
    "six levels",
    "blended shadows",
    "quarter",
    "double",
    "mended",
];

/// Roles of methods with one map from the middle of the light.
pub(super) const OTHERS: [&str; 4] = ["PCSS 16/16", "PCSS", "variance soft shadows", "moment soft shadows"];

impl StochasticTables<'_> {
    /// The row of a technique over all scenes.
    pub(super) fn row(&self, light: &str, technique: &str, class: &str) -> Option<&StochasticRecord> {
        let of = |r: &&StochasticRecord| {
            r.scene == "all" && r.light == light && r.technique == technique && r.class == class
        };
        self.records.iter().find(of).filter(|row| row.receivers > 0)
    }

    pub(super) fn lights(&self) -> impl Iterator<Item = &str> {
        self.experiment.light.iter().map(|light| light.name.as_str())
    }

    /// The largest light, in which everything shows most.
    pub(super) fn largest(&self) -> Option<&str> {
        let largest = self.experiment.light.iter().max_by(|a, b| a.scale.total_cmp(&b.scale));
        largest.map(|light| light.name.as_str())
    }

    pub(super) fn named(&self, role: &str) -> Option<&str> {
        with_role(&self.experiment.technique, role).map(|technique| technique.name.as_str())
    }

    /// The row of whoever has a role under a light.
    pub(super) fn playing(
        &self,
        role: &'static str,
        light: &str,
        class: &str,
    ) -> Measured<&StochasticRecord> {
        let name = &player(&self.experiment.technique, role)?.name;
        recorded(self.row(light, name, class))
    }

    /// The answer to the experiment's question.
    pub(super) fn answer(&self) -> Vec<Text> {
        let sentences =
            [self.closest(), self.bases(), self.contacts(), self.mends(), self.modulated(), self.truth()];
        sentences.into_iter().flatten().map(Text::from).collect()
    }

    fn closest(&self) -> Option<String> {
        let asked = [
            "published",
            "four moments",
            "mended",
            "PCSS 16/16",
            "PCSS",
            "variance soft shadows",
            "moment soft shadows",
        ];
        let of_light = |light: &str| {
            let errors: Vec<String> = asked
                .iter()
                .filter_map(|role| self.row(light, self.named(role)?, "all"))
                .map(|row| format!("{} {}", row.technique, percent(row.l1_error, 2)))
                .collect();
            (!errors.is_empty()).then(|| format!("under the {light} light {}", errors.join(", ")))
        };
        let all: Vec<String> = self.lights().filter_map(of_light).collect();
        let text = all.join("; ");
        (!all.is_empty()).then(|| format!("Mean distance from the area light: {text}."))
    }

    fn bases(&self) -> Option<String> {
        let light = self.largest()?;
        let rows = BASES.iter().filter_map(|role| self.row(light, self.named(role)?, "all"));
        let all: Vec<String> = rows
            .map(|row| {
                let (error, sign) = (percent(row.l1_error, 2), 100.0 * row.signed_mean);
                format!("{} {error} ({sign:+.1})", row.technique)
            })
            .collect();
        (!all.is_empty()).then(|| {
            format!("Representations on the same planes, {light} light, error (signed): {}.", all.join(", "))
        })
    }

    fn contacts(&self) -> Option<String> {
        let of_light = |light: &str| {
            let of = |role: &str| {
                self.row(light, self.named(role)?, "contact").map(|row| percent(row.l1_error, 1))
            };
            let (own, mended, other) = (of("four moments")?, of("mended")?, of("PCSS")?);
            Some(format!("{own}, {mended} and {other} ({light} light)"))
        };
        let all: Vec<String> = self.lights().filter_map(of_light).collect();
        (!all.is_empty()).then(|| {
            format!(
                "At contacts four moments, all mends and percentage-closer soft shadows err by {}.",
                all.join("; ")
            )
        })
    }

    fn mends(&self) -> Option<String> {
        let light = self.largest()?;
        let before = self.row(light, self.named("four moments")?, "all")?.l1_error;
        let change = |role: &&str| {
            let row = self.row(light, self.named(role)?, "all")?;
            Some(format!("{} {:+.2}", row.technique, 100.0 * (row.l1_error - before)))
        };
        let all: Vec<String> = CHANGES.iter().filter_map(change).collect();
        (!all.is_empty()).then(|| {
            format!(
                "Changes to four moments on four planes, in points of error under the {light} light: {}.",
                all.join(", ")
            )
        })
    }

    fn modulated(&self) -> Option<String> {
        let light = self.largest()?;
        let rows = self.modulation.iter().filter(|r| r.light == light);
        let all: Vec<String> = rows.map(|r| format!("{} {:.2}", r.technique, r.correlation)).collect();
        (!all.is_empty()).then(|| {
            format!(
                "Correlation with what turning the upper grid changes ({light} light): {}.",
                all.join(", ")
            )
        })
    }

    fn truth(&self) -> Option<String> {
        let largest = self.views.iter().map(|view| view.largest_standard_error).max_by(f64::total_cmp)?;
        Some(format!("The truth of every pixel has a standard error of at most {}.", percent(largest, 2)))
    }
}
