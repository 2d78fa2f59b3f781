//! What the records of a stability experiment say, in numbers.

use crate::kinds::rows::tables;
use crate::page::{Breaks, Text, count_of, median_of, percent};
use evaluation::{
    Arithmetic, CellRecord, CheckRecord, PivotRecord, Shape, StabilityExperiment, StabilityMethod,
    StabilityRecord, StabilitySample, ViewRecord, with_role,
};

tables! {
    /// The recorded tables of a run, with its experiment.
    StabilityTables<'a> of StabilityExperiment {
        records: StabilityRecord,
        cells: CellRecord,
        checks: CheckRecord,
        pivots: PivotRecord,
        views: ViewRecord,
        samples: StabilitySample,
    }
}

/// Which inputs are meant.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Inputs {
    /// Families that are hard by construction.
    Hard,
    /// Fragments of scenes.
    Scenes,
}

/// A failure that is counted.
pub(crate) type Count = fn(&StabilityRecord) -> u64;

/// Counts over several families.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Total {
    pub(crate) inputs: u64,
    pub(crate) not_finite: u64,
    pub(crate) outside: u64,
    pub(crate) violated: u64,
    pub(crate) visible: u64,
    pub(crate) error_999: f64,
    pub(crate) error_max: f64,
    pub(crate) mean_loss: f64,
}

impl StabilityTables<'_> {
    /// Whether a family belongs to these inputs.
    pub(crate) fn belongs(&self, family: &str, inputs: Inputs) -> bool {
        let of_scenes =
            |name: &str| self.experiment.family.iter().any(|f| f.name == name && f.shape == Shape::Scenes);
        of_scenes(family) == (inputs == Inputs::Scenes)
    }

    /// Records of a method, of one kind of inputs.
    pub(crate) fn of(&self, method: &str, inputs: Inputs) -> impl Iterator<Item = &StabilityRecord> {
        self.records.iter().filter(move |r| r.method == method && self.belongs(&r.family, inputs))
    }

    /// Sums over families at the recommended bias.
    pub(crate) fn recommended(&self, method: &str, inputs: Inputs) -> Total {
        Self::total(self.of(method, inputs))
    }

    /// On which share of fragments of scenes each method breaks, by moment bias.
    pub(crate) fn breaks(&self) -> Vec<Breaks> {
        let of = |method: &StabilityMethod| {
            let mut totals: Vec<(f64, u64, u64)> = Vec::new();
            for r in self.of(&method.name, Inputs::Scenes).filter(|r| r.inputs > 0) {
                // One that gives no number may be counted as broken, too.
                let broken = r.violated.max(r.not_finite);
                match totals.iter_mut().find(|total| total.0 == r.alpha) {
                    Some(total) => *total = (r.alpha, total.1 + broken, total.2 + r.inputs),
                    None => totals.push((r.alpha, broken, r.inputs)),
                }
            }
            let share = |(alpha, broken, inputs): (f64, u64, u64)| (alpha, broken as f64 / inputs as f64);
            let shares = totals.into_iter().map(share).collect();
            Breaks { method: method.name.clone(), recommended: method.alpha(), shares }
        };
        self.experiment.technique.iter().map(of).collect()
    }

    /// The same over families of these shapes.
    pub(crate) fn recommended_on(&self, method: &str, shapes: &[Shape]) -> Total {
        let has_shape = |r: &&StabilityRecord| {
            self.experiment.family.iter().any(|f| f.name == r.family && shapes.contains(&f.shape))
        };
        Self::total(self.of(method, Inputs::Hard).filter(has_shape))
    }

    fn total<'r>(records: impl Iterator<Item = &'r StabilityRecord>) -> Total {
        let mut total = Total::default();
        for r in records.filter(|r| r.recommended) {
            total.inputs += r.inputs;
            total.not_finite += r.not_finite;
            total.outside += r.outside;
            total.violated += r.violated;
            total.visible += r.visible;
            total.error_999 = total.error_999.max(r.error_999);
            total.error_max = total.error_max.max(r.error_max);
            total.mean_loss += r.mean_loss * r.inputs as f64;
        }
        total.mean_loss /= total.inputs.max(1) as f64;
        total
    }

    /// Biases that were tried with a method, ascending, and the share of inputs that fail.
    pub(crate) fn shares(&self, method: &str, inputs: Inputs, count: Count) -> Vec<(f64, f64)> {
        let mut sums: Vec<(f64, u64, u64)> = Vec::new();
        for r in self.of(method, inputs) {
            match sums.iter_mut().find(|(alpha, ..)| *alpha == r.alpha) {
                Some((_, failed, all)) => {
                    *failed += count(r);
                    *all += r.inputs;
                }
                None => sums.push((r.alpha, count(r), r.inputs)),
            }
        }
        sums.sort_by(|a, b| a.0.total_cmp(&b.0));
        sums.into_iter().map(|(alpha, failed, all)| (alpha, failed as f64 / all.max(1) as f64)).collect()
    }

    /// The smallest bias from which on no input fails.
    pub(crate) fn smallest_alpha(&self, method: &str, inputs: Inputs, count: Count) -> Option<f64> {
        let shares = self.shares(method, inputs, count);
        let good = shares.iter().rev().take_while(|(_, share)| *share == 0.0).last();
        good.map(|&(alpha, _)| alpha)
    }

    /// Median nanoseconds a bound.
    pub(crate) fn nanoseconds(&self, method: &str) -> Option<f64> {
        let of_method = self.samples.iter().filter(|s| s.method == method);
        median_of(of_method.map(|s| s.time_ns as f64 / s.bounds.max(1) as f64))
    }

    /// Share of kernels of scenes whose smallest pivot is below 1e-6.
    pub(crate) fn nearly_singular(&self, order: usize) -> Option<f64> {
        let of = |p: &&PivotRecord| p.order == order && self.belongs(&p.family, Inputs::Scenes);
        self.pivots.iter().find(of).map(|p| p.below_1e6)
    }

    /// The answer to the experiment's question.
    pub(crate) fn answer(&self) -> Vec<Text> {
        let mut sentences: Vec<String> = Vec::new();
        // Every method has the same inputs.
        let first = self.checks.first().map(|c| c.method.as_str());
        let checked: u64 =
            self.checks.iter().filter(|c| Some(c.method.as_str()) == first).map(|c| c.inputs).sum();
        let in_arithmetic = |c: &CheckRecord, arithmetic: Arithmetic| {
            self.experiment.technique.iter().any(|m| m.name == c.method && m.arithmetic == arithmetic)
        };
        let total = |of: fn(&CheckRecord) -> u64| -> u64 { self.checks.iter().map(of).sum() };
        let broken = |arithmetic: Arithmetic| -> u64 {
            self.checks.iter().filter(|c| in_arithmetic(c, arithmetic)).map(|c| c.violated).sum()
        };
        sentences.push(format!(
            "On {} inputs our forms gave {} values that are no number and {} outside [0, 1], and broke their \
             bound {} times in double precision and {} times in single precision, at the recommended biases.",
            count_of(checked),
            total(|c| c.not_finite),
            total(|c| c.outside),
            broken(Arithmetic::F64),
            broken(Arithmetic::F32),
        ));
        if let Some(share) = self.nearly_singular(4) {
            sentences.push(format!(
                "The smallest pivot of the matrix of four moments is below 1e-6 for {} of the scenes' fragments.",
                percent(share, 0)
            ));
        }
        let violated = |r: &StabilityRecord| r.violated;
        let alpha = |role| {
            let player = with_role(&self.experiment.technique, role)?;
            self.smallest_alpha(&player.name, Inputs::Hard, violated)
        };
        if let (Some(plain), Some(pairs)) =
            (alpha("four moments, single precision"), alpha("four moments, single precision in pairs"))
        {
            sentences.push(format!(
                "Four moments stored in single precision need a bias of {plain:e} on hard inputs, and {pairs:e} if the \
                 bound is computed with twice the digits{}.",
                if plain == pairs { ": storage sets the bias, not arithmetic" } else { "" }
            ));
        }
        sentences.into_iter().map(Text::from).collect()
    }
}
