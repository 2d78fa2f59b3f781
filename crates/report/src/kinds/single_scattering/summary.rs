//! What the records of a `single-scattering` experiment say, in numbers.

use super::smallest;
use crate::kinds::rows::tables;
use crate::page::{Measured, Text, count_of, percent, player, recorded};
use evaluation::{
    AliasingRecord, EdgeRecord, FrameSample, GpuRecord, ScatteringCost, ScatteringPictureRecord,
    ScatteringRecord, ScatteringTechnique, ScatteringViewRecord, SingleScatteringExperiment,
    StoredBiasRecord, TimedSample, with_role,
};

tables! {
    /// The recorded tables of a run, with its experiment.
    ScatteringTables<'a> of SingleScatteringExperiment {
        records: ScatteringRecord,
        views: ScatteringViewRecord,
        costs: ScatteringCost,
        samples: TimedSample,
    }
    some_runs {
        pictures: ScatteringPictureRecord,
        aliasing: AliasingRecord,
        stability: StoredBiasRecord,
        edges: EdgeRecord,
        frames: FrameSample,
        gpu: GpuRecord,
    }
}

/// Over all rays.
pub(super) const ALL: (&str, &str) = ("all", "all");

impl ScatteringTables<'_> {
    /// The row of a technique over all views.
    pub(super) fn pooled(&self, technique: &str, (group, class): (&str, &str)) -> Option<&ScatteringRecord> {
        self.records.iter().find(|r| {
            r.scene == "all" && r.technique == technique && r.group == group && r.class == class && r.rays > 0
        })
    }

    /// The row of a technique over a scene.
    pub(super) fn of_scene(&self, technique: &str, scene: &str) -> Option<&ScatteringRecord> {
        self.records.iter().find(|r| r.scene == scene && r.view == "all" && r.technique == technique)
    }

    /// Who plays a role.
    pub(super) fn name(&self, role: &'static str) -> Measured<&str> {
        player::<ScatteringTechnique>(&self.experiment.technique, role)
            .map(|technique| technique.name.as_str())
    }

    /// The row of whoever has a role.
    pub(super) fn playing(&self, role: &'static str, class: (&str, &str)) -> Measured<&ScatteringRecord> {
        let name = self.name(role)?;
        recorded(self.pooled(name, class))
    }

    /// Mean flicker of a technique over all views, motions and shifts.
    pub(super) fn flicker(&self, technique: &str) -> Option<f64> {
        let rows: Vec<f64> =
            self.aliasing.iter().filter(|r| r.technique == technique).map(|r| r.flicker).collect();
        (!rows.is_empty()).then(|| rows.iter().sum::<f64>() / rows.len() as f64)
    }

    /// The answer to the experiment's question.
    pub(super) fn answer(&self) -> Vec<Text> {
        let sentences = [self.ranking(), self.complexity(), self.spacing(), self.aliased(), self.truth()];
        let mut all: Vec<Text> = sentences.into_iter().flatten().map(Text::from).collect();
        all.extend(smallest::findings(self).into_iter().map(Text::from));
        all
    }

    /// Errors of those who play roles, in this order.
    fn listed(&self, roles: &[&'static str], class: (&str, &str)) -> Vec<String> {
        let of = |role: &&'static str| {
            let technique = with_role(&self.experiment.technique, role)?;
            let row = self.pooled(&technique.name, class)?;
            Some(format!("{} {}", technique.name, percent(row.l1_error, 2)))
        };
        roles.iter().filter_map(of).collect()
    }

    fn ranking(&self) -> Option<String> {
        const ASKED: [&str; 8] = [
            "two moments",
            "four moments",
            "six moments",
            "eight moments",
            "trigonometric",
            "convolution",
            "32 samples",
            "128 samples",
        ];
        let listed = self.listed(&ASKED, ALL);
        let text = listed.join(", ");
        (!listed.is_empty()).then(|| {
            format!(
                "Mean distance from the shadow map's exact integral, of the unshadowed scattering: {text}."
            )
        })
    }

    fn complexity(&self) -> Option<String> {
        let class = |role: &'static str, class: &str| {
            let row = self.playing(role, ("steps", class)).ok()?;
            Some(percent(row.l1_error, 2))
        };
        let of = |role: &'static str| {
            let name = self.name(role).ok()?;
            Some(format!(
                "{name} {}, {} and {}",
                class(role, "0-1")?,
                class(role, "4-7")?,
                class(role, "16+")?
            ))
        };
        let all: Vec<String> =
            ["four moments", "six moments", "eight moments"].into_iter().filter_map(of).collect();
        let text = all.join("; ");
        (!all.is_empty())
            .then(|| format!("With 0 or 1, 4 to 7, and 16 or more depth steps along the row: {text}."))
    }

    fn spacing(&self) -> Option<String> {
        const SPACINGS: [&str; 6] =
            ["exact, mean", "exact, bounds", "exact", "exact, rays", "exact, two", "exact, own"];
        let listed = self.listed(&SPACINGS, ALL);
        let text = listed.join(", ");
        (!listed.is_empty())
            .then(|| format!("What rectification and the spacing of samples cost alone: {text}."))
    }

    fn aliased(&self) -> Option<String> {
        let of = |role: &'static str| {
            let name = self.name(role).ok()?;
            Some((name, self.flicker(name)?))
        };
        let ((plain, without), (filtered, with)) = (of("six moments")?, of("six moments, filtered")?);
        Some(format!(
            "While the camera moves by parts of a pixel {plain} flickers by {}, {filtered} by {}.",
            percent(without, 3),
            percent(with, 3)
        ))
    }

    fn truth(&self) -> Option<String> {
        let count = self.views.len();
        let mean = |of: &dyn Fn(&ScatteringViewRecord) -> f64| {
            self.views.iter().map(of).sum::<f64>() / count.max(1) as f64
        };
        let rays: u64 = self.views.iter().map(|view| view.shadow_rays).sum();
        (count > 0).then(|| {
            format!(
                "Shadow map and geometry differ by {} on average (signed {:+.2}), known to {} by {} shadow rays.",
                percent(mean(&|view| view.difference), 2),
                100.0 * mean(&|view| view.signed_difference),
                percent(mean(&|view| view.standard_error), 2),
                count_of(rays)
            )
        })
    }
}
