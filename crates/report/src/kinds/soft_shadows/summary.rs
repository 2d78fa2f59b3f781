//! What the records of a `soft-shadows` experiment say, in numbers.

use super::sweeps;
use crate::kinds::rows::tables;
use crate::page::{Measured, Text, count_of, percent, player, recorded};
use evaluation::{
    GpuRecord, PassSample, Population, ReceiverRecord, ReconstructionPoint, SearchTexel, SoftPictureRecord,
    SoftRecord, SoftShadowsExperiment, SoftViewRecord, SweepRecord, TimedSample, with_role,
};

tables! {
    /// The recorded tables of a run, with its experiment.
    SoftTables<'a> of SoftShadowsExperiment {
        records: SoftRecord,
        views: SoftViewRecord,
        samples: TimedSample,
    }
    some_runs {
        sweeps: SweepRecord,
        pictures: SoftPictureRecord,
        receivers: ReceiverRecord,
        kernels: SearchTexel,
        curves: ReconstructionPoint,
        passes: PassSample,
        gpu: GpuRecord,
    }
}

impl SoftTables<'_> {
    /// The row of a technique over all views under its best bias.
    pub(super) fn pooled(
        &self,
        (light, population): (&str, Population),
        technique: &str,
        (group, class): (&str, &str),
    ) -> Option<&SoftRecord> {
        self.records.iter().find(|r| {
            r.best
                && r.light == light
                && r.population == population
                && r.scene == "all"
                && r.technique == technique
                && r.group == group
                && r.class == class
        })
    }

    /// Over all receivers of a population.
    pub(super) fn whole(&self, light: &str, population: Population, technique: &str) -> Option<&SoftRecord> {
        self.pooled((light, population), technique, ("all", "all"))
    }

    /// Names of the lights.
    pub(super) fn lights(&self) -> impl Iterator<Item = &str> {
        self.experiment.light.iter().map(|light| light.name.as_str())
    }

    /// The light of the widest penumbrae, in which everything shows most.
    pub(super) fn widest(&self) -> Option<&str> {
        let widest = self.views.iter().max_by(|a, b| a.largest_width.total_cmp(&b.largest_width));
        widest.map(|view| view.light.as_str())
    }

    /// The row of whoever has a role, under the widest light.
    pub(super) fn playing(
        &self,
        role: &'static str,
        population: Population,
        class: (&str, &str),
    ) -> Measured<&SoftRecord> {
        let name = &player(&self.experiment.technique, role)?.name;
        let light = recorded(self.widest())?;
        recorded(self.pooled((light, population), name, class))
    }

    /// The answer to the experiment's question.
    pub(super) fn answer(&self) -> Vec<Text> {
        let sentences = [self.ranking(), self.fusion(), self.imitation(), self.later(), self.truth()];
        let mut all: Vec<Text> = sentences.into_iter().flatten().map(Text::from).collect();
        all.extend(sweeps::findings(self).into_iter().map(Text::from));
        all
    }

    /// Everybody who plays the roles that people ask for, by light.
    fn ranking(&self) -> Option<String> {
        const ASKED: [&str; 4] = ["PCSS", "four moments", "two moments", "fixed size"];
        let of_light = |light: &str| {
            let errors: Vec<String> = ASKED
                .iter()
                .filter_map(|role| with_role(&self.experiment.technique, role))
                .filter_map(|technique| {
                    let row = self.whole(light, Population::Fragments, &technique.name)?;
                    Some(format!("{} {}", technique.name, percent(row.mean_error, 2)))
                })
                .collect();
            (!errors.is_empty()).then(|| format!("under the light \"{light}\" {}", errors.join(", ")))
        };
        let lights: Vec<String> = self.lights().filter_map(of_light).collect();
        let text = lights.join("; ");
        (!lights.is_empty()).then(|| format!("Mean distance from the area light over all fragments: {text}."))
    }

    /// What occluders behind each other do.
    fn fusion(&self) -> Option<String> {
        let light = self.widest()?;
        let name = &with_role(&self.experiment.technique, "four moments")?.name;
        let first = &self.experiment.technique[0].name;
        let error = |technique: &str, class: &str| {
            let row = self.pooled((light, Population::Fragments), technique, ("layers", class))?;
            (row.receivers > 0).then_some(row.mean_error)
        };
        Some(format!(
            "With the number of occluding layers (1, 2, 3 and more) {first} errs by {}, {} and {}, {name} by {}, {} and {} \
             (light \"{light}\").",
            percent(error(first, "1")?, 2),
            percent(error(first, "2")?, 2),
            percent(error(first, "3+")?, 2),
            percent(error(name, "1")?, 2),
            percent(error(name, "2")?, 2),
            percent(error(name, "3+")?, 2),
        ))
    }

    /// How well the first technique is imitated.
    fn imitation(&self) -> Option<String> {
        let light = self.widest()?;
        let of = |role: &str| {
            let name = &with_role(&self.experiment.technique, role)?.name;
            Some((name, self.whole(light, Population::Fragments, name)?.mean_to_first))
        };
        let ((four, near), (two, far)) = (of("four moments")?, of("two moments")?);
        Some(format!(
            "From {} {four} differ by {}, {two} by {}.",
            self.experiment.technique[0].name,
            percent(near, 2),
            percent(far, 2)
        ))
    }

    /// The author's later changes.
    fn later(&self) -> Option<String> {
        const CHANGES: [&str; 7] = [
            "signed depth",
            "sparse transform",
            "unbiased search",
            "growing bias",
            "dithered corners",
            "later epsilon",
            "later",
        ];
        let light = self.widest()?;
        let error = |role: &str| {
            let name = &with_role(&self.experiment.technique, role)?.name;
            Some((name, self.whole(light, Population::Fragments, name)?.mean_error))
        };
        let (name, before) = error("four moments")?;
        let changes: Vec<String> = CHANGES
            .iter()
            .filter_map(|role| error(role))
            .map(|(name, after)| format!("{name} {:+.2}", 100.0 * (after - before)))
            .collect();
        let text = changes.join(", ");
        (!changes.is_empty()).then(|| {
            format!(
                "Changes to {name}, in points of error: {text} (light \"{light}\", each with its best bias)."
            )
        })
    }

    fn truth(&self) -> Option<String> {
        let largest = self.views.iter().map(|view| view.largest_standard_error).max_by(f64::total_cmp)?;
        let rays: u64 = self.views.iter().map(|view| view.rays).sum();
        Some(format!(
            "The truth of every receiver has a standard error of at most {}, by {} shadow rays in all.",
            percent(largest, 2),
            count_of(rays)
        ))
    }
}
