//! What the records of a `filterable` experiment say, in numbers.

use crate::kinds::reference::ReferenceLevel;
use crate::kinds::rows::tables;
use crate::page::{Text, percent};
use evaluation::{
    AgreementRecord, CurveRecord, FilterableExperiment, FilterableRecord, NOTHING, PairRecord, PictureRecord,
    ReferenceRecord, TimedSample, ViewRecord, with_role,
};

tables! {
    /// The recorded tables of a run, with its experiment.
    FilterableTables<'a> of FilterableExperiment {
        records: FilterableRecord,
        views: ViewRecord,
        samples: TimedSample,
    }
    some_runs {
        agreement: AgreementRecord,
        kernels: PictureRecord,
        curves: CurveRecord,
        pairs: PairRecord,
        reference: ReferenceRecord,
    }
}

/// A difference of less than so many standard errors is none.
const CERTAIN: f64 = 2.0;

/// A mean difference of |G - F| between two techniques.
struct Difference {
    mean: f64,
    standard_error: f64,
    /// Fragments that both have.
    fragments: usize,
}

impl Difference {
    fn is_certain(&self) -> bool {
        self.mean.abs() > CERTAIN * self.standard_error
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
    /// The reference that errors are against.
    pub(crate) fn level(&self) -> ReferenceLevel<'_> {
        // Settings without a bias are refused.
        let first = self.experiment.bias.first().copied().unwrap_or_default();
        ReferenceLevel::new(first.reference, &self.reference)
    }

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

    /// Pooled rows under one bias, the least error first; after those that were evaluated on all fragments come those that
    /// have fewer, whose means are not comparable with them.
    pub(crate) fn pooled(&self, bias: usize) -> Vec<&FilterableRecord> {
        let pooled =
            |r: &&FilterableRecord| r.scene == "all" && r.view == "all" && r.class == "all" && r.bias == bias;
        let mut rows: Vec<&FilterableRecord> = self.records.iter().filter(pooled).collect();
        let most = rows.iter().map(|r| r.fragments).max().unwrap_or_default();
        rows.sort_by(|a, b| {
            (a.fragments < most).cmp(&(b.fragments < most)).then(a.l1_error.total_cmp(&b.l1_error))
        });
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

    /// The answer to the experiment's question.
    pub(crate) fn answer(&self) -> Vec<Text> {
        let mut sentences: Vec<String> = Vec::new();
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
        let techniques = || pooled.iter().filter(|r| r.technique != NOTHING);
        let only_compared = techniques().next().is_some() && techniques().all(is_compared);
        let headline = self.headline(&pooled);
        let over_references = self.over_references(&pooled);
        let tells_bias = !only_compared && over_references.is_none() && headline.is_some();
        if only_compared {
            sentences.extend(against_program.clone());
        } else if over_references.is_some() {
            sentences.extend(over_references);
        } else {
            sentences.extend(headline.map(|headline| self.level().before(&headline)));
        }
        // Means over other fragments have no place in this order.
        let most = pooled.iter().map(|r| r.fragments).max().unwrap_or_default();
        let (placed, few): (Vec<_>, Vec<_>) = pooled.iter().copied().partition(|r| r.fragments == most);
        let order = format!(
            "In order of mean |G - F| over all views, ~ where {CERTAIN} standard errors of the difference leave the order open: \
             {}.",
            self.order(&placed)
        );
        sentences.push(if tells_bias { order } else { self.level().before(&order) });
        sentences.extend(few.into_iter().map(|r| self.beside(r, &placed)));
        if self.experiment.bias.len() > 1 {
            let mut best: Vec<&FilterableRecord> =
                placed.iter().filter_map(|r| self.best(&r.technique)).collect();
            best.sort_by(|a, b| a.l1_error.total_cmp(&b.l1_error));
            sentences.push(format!("Each with its own best bias of those listed: {}.", self.order(&best)));
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

    /// Names with errors, the least first.
    fn order(&self, rows: &[&FilterableRecord]) -> String {
        let mut text = String::new();
        for (i, r) in rows.iter().enumerate() {
            if let Some(before) = i.checked_sub(1).map(|before| rows[before]) {
                text += if self.is_less(before, r) { " < " } else { " ~ " };
            }
            text += &format!("{} {}", r.technique, percent(r.l1_error, 2));
        }
        text
    }

    /// The difference of two techniques under the first bias, one minus the other.
    fn pair(&self, one: &str, other: &str) -> Option<Difference> {
        let of = |p: &PairRecord, sign: f64| Difference {
            mean: sign * p.difference,
            standard_error: p.standard_error.unwrap_or_default(),
            fragments: p.fragments,
        };
        self.pairs.iter().find_map(|p| match (p.technique.as_str(), p.other.as_str()) {
            (a, b) if (a, b) == (one, other) => Some(of(p, 1.0)),
            (a, b) if (a, b) == (other, one) => Some(of(p, -1.0)),
            _ => None,
        })
    }

    /// Whether the sample leaves no doubt that one errs less than the other; without their pair as if they had been evaluated
    /// on different fragments.
    fn is_less(&self, one: &FilterableRecord, other: &FilterableRecord) -> bool {
        let paired = self.pair(&one.technique, &other.technique).filter(|_| one.bias == 0 && other.bias == 0);
        let apart = || {
            let errors = [one, other].map(|r| r.standard_error.unwrap_or_default());
            let (mean, standard_error) = (one.l1_error - other.l1_error, errors[0].hypot(errors[1]));
            Difference { mean, standard_error, fragments: 0 }
        };
        let difference = paired.unwrap_or_else(apart);
        difference.mean < 0.0 && difference.is_certain()
    }

    /// A technique that was evaluated on fewer fragments, beside the closest of the others on those that both have.
    fn beside(&self, r: &FilterableRecord, placed: &[&FilterableRecord]) -> String {
        let margin = percent(CERTAIN * r.standard_error.unwrap_or_default(), 2);
        let (name, error) = (&r.technique, percent(r.l1_error, 2));
        let own = format!("{name} errs by {error} ± {margin} on {} fragments", r.fragments);
        let pairs = placed
            .iter()
            .filter_map(|other| Some((other.technique.as_str(), self.pair(name, &other.technique)?)));
        match pairs.min_by(|a, b| a.1.mean.abs().total_cmp(&b.1.mean.abs())) {
            None => format!("{own}, and cannot be placed among the others."),
            Some((other, difference)) => format!(
                "{own}; on the {} that it shares with {other} it errs by {:+.2} ± {:.2} points against it{}.",
                difference.fragments,
                100.0 * difference.mean,
                100.0 * CERTAIN * difference.standard_error,
                if difference.is_certain() { "" } else { ", which leaves their order open" }
            ),
        }
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
        // Who shares the first place is no winner.
        let is_tied = |r: &&&FilterableRecord| r.technique != best.technique && !self.is_less(best, r);
        let tied: Vec<&FilterableRecord> =
            rows.iter().filter(can_be_filtered).filter(is_tied).copied().collect();
        let others: Vec<String> = ["four moments", "VSM", "PCF"]
            .iter()
            .filter_map(|role| self.playing(role, rows))
            .filter(|r| r.technique != best.technique && tied.iter().all(|t| t.technique != r.technique))
            .map(|r| format!("{} by {}", r.technique, percent(r.l1_error, 2)))
            .collect();
        let besides = if others.is_empty() { String::new() } else { format!("; {}", others.join(", ")) };
        let error = percent(best.l1_error, 2);
        if !tied.is_empty() {
            let names = tied.iter().map(|r| format!("{} by {}", r.technique, percent(r.l1_error, 2)));
            return Some(format!(
                "Closest to percentage-closer filtering are {} with an error of {error} and, not told from it by this \
                 sample, {}{besides}.",
                best.technique,
                names.collect::<Vec<_>>().join(", ")
            ));
        }
        Some(format!(
            "The filterable shadow map closest to percentage-closer filtering is {}, which errs by {error}{besides}.",
            best.technique
        ))
    }
}
