//! What the records of a `translucent-shadows` experiment say, in numbers.

use crate::kinds::rows::tables;
use crate::page::{Measured, Text, percent, player, recorded};
use evaluation::{
    BlendingRecord, ColourRecord, TimedSample, TranslucentCost, TranslucentGroup, TranslucentPictureRecord,
    TranslucentRecord, TranslucentShadowsExperiment, TranslucentViewRecord, with_role,
};

tables! {
    /// The recorded tables of a run, with its experiment.
    TranslucentTables<'a> of TranslucentShadowsExperiment {
        records: TranslucentRecord,
        groups: TranslucentGroup,
        views: TranslucentViewRecord,
        cost: TranslucentCost,
        samples: TimedSample,
    }
    some_runs {
        colour: ColourRecord,
        stability: BlendingRecord,
        pictures: TranslucentPictureRecord,
    }
}

/// Roles whose curves are compared.
pub(super) const COMPARED: [&str; 8] = [
    "four moments",
    "four moments, middle",
    "six moments, middle",
    "absorbance 4",
    "Fourier 16",
    "variance",
    "stochastic 8",
    "opaque",
];

impl TranslucentTables<'_> {
    /// The row of a technique over all scenes.
    pub(super) fn row(&self, technique: &str, class: &str) -> Option<&TranslucentRecord> {
        self.of_scene("all", technique, class)
    }

    /// The row over a scene's first view, or over all of `all`.
    pub(super) fn of_scene(&self, scene: &str, technique: &str, class: &str) -> Option<&TranslucentRecord> {
        let of = |r: &&TranslucentRecord| r.scene == scene && r.technique == technique && r.class == class;
        self.records.iter().find(of).filter(|row| row.receivers > row.failed)
    }

    pub(super) fn named(&self, role: &str) -> Option<&str> {
        with_role(&self.experiment.technique, role).map(|technique| technique.name.as_str())
    }

    /// The row of whoever has a role.
    pub(super) fn playing(&self, role: &'static str, class: &str) -> Measured<&TranslucentRecord> {
        let name = &player(&self.experiment.technique, role)?.name;
        recorded(self.row(name, class))
    }

    /// What the technique of a role costs.
    pub(super) fn costs(&self, role: &'static str) -> Measured<&TranslucentCost> {
        let name = &player(&self.experiment.technique, role)?.name;
        recorded(self.cost.iter().find(|cost| cost.technique == *name))
    }

    /// The answer to the experiment's question.
    pub(super) fn answer(&self) -> Vec<Text> {
        let sentences = [
            self.closest("surfaces", "On opaque surfaces"),
            self.closest("inside", "Inside smoke and glass"),
            self.engines(),
            self.bounds(),
            self.order(),
            self.biases(),
        ];
        sentences.into_iter().flatten().map(Text::from).collect()
    }

    fn closest(&self, class: &str, place: &str) -> Option<String> {
        let asked = [
            "four moments",
            "four moments, middle",
            "six moments, middle",
            "eight moments, middle",
            "absorbance 4",
            "absorbance 6",
            "Fourier 16",
            "Fourier 32",
            "convolution",
            "variance",
            "stochastic 8",
            "deep",
        ];
        let errors: Vec<String> = asked
            .iter()
            .filter_map(|role| self.row(self.named(role)?, class))
            .map(|row| format!("{} {}", row.technique, percent(row.l1_error, 2)))
            .collect();
        (!errors.is_empty()).then(|| format!("{place}, mean distance from the truth: {}.", errors.join(", ")))
    }

    fn engines(&self) -> Option<String> {
        let of = |role: &str| self.row(self.named(role)?, "all").map(|row| percent(row.l1_error, 1));
        let (opaque, tested, ignored) = (of("opaque")?, of("tested")?, of("ignored")?);
        Some(format!(
            "Without translucency percentage-closer filtering errs by {opaque} with all surfaces opaque, {tested} with those \
             opaque that are closer to opaque than to clear, {ignored} with translucent ones ignored."
        ))
    }

    fn bounds(&self) -> Option<String> {
        let blends = ["four moments", "four moments, quarter", "four moments, middle", "four moments, upper"];
        let rows = |class: &str| {
            let all = blends.iter().map(|role| self.row(self.named(role)?, class));
            all.collect::<Option<Vec<_>>>()
        };
        let say = |class: &str| -> Option<String> {
            let rows = rows(class)?;
            let best = rows.iter().min_by(|a, b| a.l1_error.total_cmp(&b.l1_error))?;
            let errors: Vec<String> = rows.iter().map(|row| percent(row.l1_error, 2)).collect();
            Some(format!("{} (least: {})", errors.join(", "), best.technique))
        };
        Some(format!(
            "Four moments of transmittance with beta = 0, 0.25, 0.5 and 1: on opaque surfaces {}, inside {}.",
            say("surfaces")?,
            say("inside")?
        ))
    }

    fn order(&self) -> Option<String> {
        let of = |role: &str| self.row(self.named(role)?, "all").map(|row| percent(row.l1_error, 2));
        let (exact, centre, unsorted) = (of("four moments")?, of("centre")?, of("unsorted")?);
        Some(format!(
            "Blended in the exact order, by triangles' centres and unsorted, four moments err by {exact}, {centre} and {unsorted}."
        ))
    }

    /// The layers that a moment bias carries.
    fn biases(&self) -> Option<String> {
        let of_case = |case: &'static str| {
            let rows = self.stability.iter().filter(move |r| {
                r.bound == "hamburger4" && r.format == "unorm16" && r.case == case && r.opacity > 0.0
            });
            // A kind of texel for which no bias is enough has none.
            let all: Option<Vec<f64>> = rows.map(|r| r.smallest_alpha).collect();
            all?.into_iter().max_by(f64::total_cmp)
        };
        let most = self.stability.iter().map(|r| r.layers).max()?;
        Some(format!(
            "Four moments in 16 bits, blended from up to {most} layers, stay moments of a distribution with a bias of {:.1e} at \
             random depths and {:.1e} where layers coincide.",
            of_case("spread")?,
            of_case("coincident")?
        ))
    }
}
