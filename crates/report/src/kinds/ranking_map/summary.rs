//! What the records of a `ranking-map` experiment say, in numbers.

use crate::kinds::rows::{distinct, programs_solved, tables};
use crate::page::{Text, percent};
use evaluation::{ClassRecord, FollowedRecord, RankingMapExperiment, VariationRecord};

tables! {
    /// The recorded tables of a run, with its experiment.
    RankingTables<'a> of RankingMapExperiment {
        records: VariationRecord,
        followed: FollowedRecord,
        classes: ClassRecord,
    }
}

impl RankingTables<'_> {
    /// The settings that others are compared with.
    pub(super) fn base(&self) -> Option<&VariationRecord> {
        self.records.first()
    }

    /// All other settings.
    pub(super) fn others(&self) -> impl Iterator<Item = &VariationRecord> {
        self.records.iter().skip(1)
    }

    /// Those that differ from the first in nothing but the fragments that were drawn.
    fn resampled(&self) -> impl Iterator<Item = &VariationRecord> {
        let seeded = |name: &str| {
            self.experiment
                .variation
                .iter()
                .any(|variation| variation.name == name && variation.seed.is_some())
        };
        self.others().filter(move |record| seeded(&record.variation))
    }

    /// Bases that are followed, in the order of the records.
    pub(super) fn bases(&self) -> Vec<&str> {
        distinct(self.followed.iter().map(|row| row.basis.as_str()))
    }

    pub(super) fn rank(&self, variation: &str, basis: &str) -> Option<&FollowedRecord> {
        self.followed.iter().find(|row| row.variation == variation && row.basis == basis)
    }

    /// The answer to the experiment's question.
    pub(super) fn answer(&self) -> Vec<Text> {
        let mut sentences: Vec<Text> = Vec::new();
        let Some(base) = self.base() else { return sentences };
        if let Some(worst) = self.others().max_by(|a, b| a.regret.total_cmp(&b.regret)) {
            let text = format!(
                ", the best of {} bases as the search is set, errs at most {} more than the best basis of other settings ({}).",
                base.candidates,
                percent(worst.regret, 1),
                worst.variation
            );
            sentences.push(Text::default().code(&base.best).and(text));
        }
        if let Some(same) = self.resampled().min_by(|a, b| a.correlation.total_cmp(&b.correlation)) {
            sentences.push(
                format!(
                    "Other fragments of the same views alone lower the rank correlation to {:.3} and keep {} of the best {}.",
                    same.correlation,
                    percent(same.kept, 0),
                    self.experiment.best
                )
                .into(),
            );
        }
        let mut varied: Vec<&VariationRecord> = self.others().collect();
        varied.sort_by(|a, b| a.correlation.total_cmp(&b.correlation));
        let words: Vec<String> = varied
            .iter()
            .take(3)
            .map(|r| {
                format!("{} ({:.3}, {} of the best kept)", r.variation, r.correlation, percent(r.kept, 0))
            })
            .collect();
        if !words.is_empty() {
            sentences.push(format!("The ranking moves most with: {}.", words.join("; ")).into());
        }
        let programs: u64 = self.records.iter().map(|record| record.programs).sum();
        let uncertified: u64 = self.records.iter().map(|record| record.uncertified).sum();
        sentences.push(programs_solved(programs, uncertified));
        sentences
    }
}
