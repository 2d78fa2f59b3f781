//! What the records of a `filterable` experiment say, in numbers.

use crate::kinds::rows::tables;
use crate::page::{Text, percent};
use evaluation::{
    AgreementRecord, CurveRecord, FilterableExperiment, FilterableRecord, FilterableSample, PictureRecord,
    ViewRecord, with_role,
};

tables! {
    /// The recorded tables of a run, with its experiment.
    FilterableTables<'a> of FilterableExperiment {
        records: FilterableRecord,
        views: ViewRecord,
        samples: FilterableSample,
    }
    some_runs {
        agreement: AgreementRecord,
        kernels: PictureRecord,
        curves: CurveRecord,
    }
}

/// Agreement of one technique with the linear program over all views.
pub(crate) struct Agreement {
    pub(crate) technique: String,
    pub(crate) fragments: usize,
    pub(crate) largest: f64,
    pub(crate) failed: usize,
}

impl<'a> FilterableTables<'a> {
    /// The row of a group.
    pub(crate) fn row(
        &self,
        (scene, view): (&str, &str),
        technique: &str,
        bias: usize,
        class: &str,
    ) -> Option<&FilterableRecord> {
        self.records.iter().find(|r| {
            r.scene == scene
                && r.view == view
                && r.technique == technique
                && r.bias == bias
                && r.class == class
        })
    }

    /// Pooled rows under one bias, the least error first.
    pub(crate) fn pooled(&self, bias: usize) -> Vec<&FilterableRecord> {
        let pooled =
            |r: &&FilterableRecord| r.scene == "all" && r.view == "all" && r.class == "all" && r.bias == bias;
        let mut rows: Vec<&FilterableRecord> = self.records.iter().filter(pooled).collect();
        rows.sort_by(|a, b| a.l1_error.total_cmp(&b.l1_error));
        rows
    }

    /// The bias of least error of a technique, among those that share the first one's reference.
    pub(crate) fn best(&self, technique: &str) -> Option<&FilterableRecord> {
        let experiment = self.experiment;
        let same = |bias: usize| {
            experiment.bias.get(bias).is_some_and(|b| b.reference == experiment.bias[0].reference)
        };
        let rows = (0..experiment.bias.len()).filter(|&bias| same(bias));
        let rows = rows.filter_map(|bias| self.row(("all", "all"), technique, bias, "all"));
        rows.min_by(|a, b| a.l1_error.total_cmp(&b.l1_error))
    }

    pub(crate) fn agreements(&self) -> Vec<Agreement> {
        let mut all: Vec<Agreement> = Vec::new();
        for record in &self.agreement {
            let index = match all.iter().position(|a| a.technique == record.technique) {
                Some(index) => index,
                None => {
                    all.push(Agreement {
                        technique: record.technique.clone(),
                        fragments: 0,
                        largest: 0.0,
                        failed: 0,
                    });
                    all.len() - 1
                }
            };
            all[index].fragments += record.fragments;
            all[index].largest = all[index].largest.max(record.largest_disagreement);
            all[index].failed += record.failed;
        }
        all
    }

    /// Least time of a stage, in nanoseconds an item: the repetition that was disturbed least.
    pub(crate) fn least_time(&self, technique: &str, stage: &str) -> Option<f64> {
        let of_stage = self.samples.iter().filter(|s| s.technique == technique && s.stage == stage);
        let times = of_stage.map(|s| s.time_ns as f64 / s.items.max(1) as f64);
        times.min_by(f64::total_cmp)
    }

    /// The answer to the experiment's question.
    pub(crate) fn answer(&self) -> Vec<Text> {
        let mut sentences: Vec<String> = Vec::new();
        let order = |rows: &mut dyn Iterator<Item = (String, f64)>| -> String {
            let entries: Vec<String> =
                rows.map(|(name, error)| format!("{name} {}", percent(error, 2))).collect();
            entries.join(" < ")
        };
        let pooled = self.pooled(0);
        let agreements = self.agreements();
        // Where techniques are there to be compared with the linear program, that is the answer.
        let is_compared = |r: &&FilterableRecord| agreements.iter().any(|a| a.technique == r.technique);
        let against_program = agreements.iter().map(|agreement| {
            format!(
                "{} differs from the certified linear program by at most {:.1e} on {} fragments ({} failed).",
                agreement.technique, agreement.largest, agreement.fragments, agreement.failed
            )
        });
        let only_compared = !pooled.is_empty() && pooled.iter().all(is_compared);
        if only_compared {
            sentences.extend(against_program.clone());
        } else if let Some(sentence) = self.over_references(&pooled) {
            sentences.push(sentence);
        } else {
            sentences.extend(self.headline(&pooled));
        }
        let mut rows = pooled.iter().map(|r| (r.technique.clone(), r.l1_error));
        sentences.push(format!("In order of mean |G - F| over all views: {}.", order(&mut rows)));
        if self.experiment.bias.len() > 1 {
            let mut best: Vec<(String, f64)> = pooled
                .iter()
                .filter_map(|r| Some((r.technique.clone(), self.best(&r.technique)?.l1_error)))
                .collect();
            best.sort_by(|a, b| a.1.total_cmp(&b.1));
            sentences.push(format!(
                "Each with its own best bias of those listed: {}.",
                order(&mut best.into_iter())
            ));
        }
        let bounds: Vec<_> = pooled.iter().filter(|r| r.unbiased_violations.is_some()).collect();
        if !bounds.is_empty() {
            let checked: usize = bounds.iter().map(|r| r.fragments).sum();
            let violations: usize = bounds.iter().filter_map(|r| r.unbiased_violations).sum();
            sentences.push(format!(
                "{} of {checked} unbiased comparisons of the {} lower bounds exceed PCF by more than 1e-6.",
                violations,
                bounds.len()
            ));
        }
        if !only_compared {
            sentences.extend(against_program);
        }
        sentences.into_iter().map(Text::from).collect()
    }

    /// How the closest technique's error moves with the bias of the reference, where that is what varies.
    fn over_references(&self, rows: &[&FilterableRecord]) -> Option<String> {
        let experiment = self.experiment;
        let first = experiment.bias.first()?;
        if experiment.bias.iter().all(|bias| bias.reference == first.reference) {
            return None;
        }
        let name = &self.playing("four moments", rows).or(rows.first().copied())?.technique;
        let alike = experiment.bias.iter().enumerate().filter(|(_, bias)| bias.technique == first.technique);
        let errors: Vec<String> = alike
            .filter_map(|(i, bias)| {
                let error = self.row(("all", "all"), name, i, "all")?.l1_error;
                Some(format!("{} at {}", percent(error, 2), bias.reference.texels))
            })
            .collect();
        Some(format!(
            "As the depth bias of percentage-closer filtering grows, {name} errs by {} texels.",
            errors.join(", ")
        ))
    }

    /// The row of the technique with this role.
    fn playing<'r>(&self, role: &str, rows: &[&'r FilterableRecord]) -> Option<&'r FilterableRecord> {
        let player = with_role(&self.experiment.technique, role)?;
        rows.iter().find(|r| r.technique == player.name).copied()
    }

    /// The closest of those that can be filtered, and what everybody asks for; `rows` by error.
    fn headline(&self, rows: &[&FilterableRecord]) -> Option<String> {
        let can_be_filtered = |r: &&&FilterableRecord| {
            let of = self.experiment.technique.iter().find(|technique| technique.name == r.technique);
            of.is_some_and(|technique| technique.comparison.is_none() && !technique.is_certified())
        };
        let best = rows.iter().find(can_be_filtered)?;
        let others: Vec<String> = ["four moments", "VSM", "PCF"]
            .iter()
            .filter_map(|role| self.playing(role, rows))
            .filter(|r| r.technique != best.technique)
            .map(|r| format!("{} by {}", r.technique, percent(r.l1_error, 2)))
            .collect();
        let besides = if others.is_empty() { String::new() } else { format!("; {}", others.join(", ")) };
        let error = percent(best.l1_error, 2);
        Some(format!(
            "The filterable shadow map closest to percentage-closer filtering is {}, which errs by {error}{besides}.",
            best.technique
        ))
    }
}
