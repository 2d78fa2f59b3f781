//! What the records of a candidate search say, in numbers.

use crate::kinds::reference::ReferenceLevel;
use crate::kinds::rows::{distinct, programs_solved, tables};
use crate::page::{Text, in_percent, percent};
use evaluation::{
    MarkRecord, ReferenceRecord, SearchAgreementRecord, SearchExperiment, SearchRecord, SearchReference,
    SearchSample, StageRecord, ViewRecord, with_role,
};

/// Names of the marked candidates of MSM15 in the family's order.
pub(super) const POWER_4: &str = "z, z^2, z^3, z^4";
pub(super) const TRIGONOMETRIC_4: &str = "sin(2pi z), cos(2pi z), sin(4pi z), cos(4pi z)";

/// Power moments in the family's order.
fn power_basis(m: usize) -> String {
    let powers = (1..=m).map(|k| if k == 1 { "z".to_owned() } else { format!("z^{k}") });
    powers.collect::<Vec<_>>().join(", ")
}

/// Trigonometric moments in the family's order; as many functions where m is odd as there are below it.
fn trigonometric_basis(m: usize) -> String {
    let waves = (1..=m / 2).map(|k| format!("sin({0}pi z), cos({0}pi z)", 2 * k));
    waves.collect::<Vec<_>>().join(", ")
}

tables! {
    /// The recorded tables of a run, with its experiment.
    SearchTables<'a> of SearchExperiment {
        records: SearchRecord,
        stages: StageRecord,
        marks: MarkRecord,
        views: ViewRecord,
        agreement: SearchAgreementRecord,
        samples: SearchSample,
    }
    some_runs {
        reference: ReferenceRecord,
    }
}

/// A point of reference in the histogram.
pub(crate) struct Landmark {
    pub(crate) name: String,
    pub(crate) error: f64,
}

/// Certified solvers of which one is timed, the present one first.
const CERTIFIED: [&str; 2] = ["LaneSimplex", "FastSimplex"];

/// Speed of a solver on one basis: its fastest repetition, which was disturbed least.
pub(crate) struct Speed {
    pub(crate) basis: String,
    /// Name of the certified solver.
    pub(crate) solver: &'static str,
    pub(crate) fast: f64,
    pub(crate) microlp: f64,
    pub(crate) microlp_wrong: usize,
    pub(crate) microlp_programs: usize,
}

/// Candidates of one size by rank. Of some runs only the best rows are recorded and a share of the others, each of which
/// then stands for all from the row before it on.
pub(crate) struct Ranking<'a> {
    rows: Vec<&'a SearchRecord>,
}

impl<'a> Ranking<'a> {
    /// Candidates, whether they are recorded or not.
    pub(crate) fn count(&self) -> usize {
        self.rows.last().map_or(0, |record| record.rank)
    }

    pub(crate) fn first(&self) -> Option<&'a SearchRecord> {
        self.rows.first().copied()
    }

    /// What is recorded, by rank.
    pub(crate) fn rows(&self) -> &[&'a SearchRecord] {
        &self.rows
    }

    /// The recorded row of a place from 0, or the next one, or the last.
    pub(crate) fn at(&self, place: usize) -> Option<&'a SearchRecord> {
        let row = self.rows.partition_point(|record| record.rank <= place);
        self.rows.get(row).or(self.rows.last()).copied()
    }

    /// Recorded rows with the number of candidates that each stands for.
    pub(crate) fn weighted(&self) -> impl Iterator<Item = (&'a SearchRecord, usize)> {
        let mut before = 0;
        self.rows.iter().map(move |record| {
            let weight = record.rank - before;
            before = record.rank;
            (*record, weight)
        })
    }

    /// Candidates for which something holds.
    pub(crate) fn count_if(&self, holds: impl Fn(&SearchRecord) -> bool) -> usize {
        self.weighted().filter(|(record, _)| holds(record)).map(|(_, weight)| weight).sum()
    }
}

impl<'a> SearchTables<'a> {
    /// The reference that errors are against.
    pub(crate) fn level(&self) -> ReferenceLevel<'_> {
        let bias = match self.experiment.reference {
            SearchReference::Plain => self.experiment.bias.technique,
            SearchReference::Plane => self.experiment.bias.reference,
        };
        ReferenceLevel::new(bias, &self.reference)
    }

    /// Sizes of candidates, ascending.
    pub(crate) fn orders(&self) -> Vec<usize> {
        let mut orders = distinct(self.records.iter().map(|record| record.m));
        orders.sort_unstable();
        orders
    }

    /// Candidates of one size with an error, the best first.
    pub(crate) fn of(&self, m: usize) -> Ranking<'_> {
        let rows = self.records.iter().filter(|record| record.m == m && record.fragments > 0);
        Ranking { rows: rows.collect() }
    }

    /// The size whose search is the headline: four functions where they are among the candidates.
    pub(crate) fn main_order(&self) -> usize {
        let orders = self.orders();
        if orders.contains(&4) { 4 } else { orders.last().copied().unwrap_or_default() }
    }

    /// A candidate by its functions.
    pub(crate) fn find(&self, basis: &str) -> Option<&SearchRecord> {
        self.records.iter().find(|record| record.basis == basis && record.fragments > 0)
    }

    /// The closed form with this role.
    fn mark(&self, role: &str) -> Option<&MarkRecord> {
        let player = with_role(&self.experiment.mark, role)?;
        self.marks.iter().find(|mark| mark.technique == player.name)
    }

    /// Power moments of the main size.
    pub(crate) fn power(&self) -> Option<&SearchRecord> {
        self.find(&power_basis(self.main_order()))
    }

    /// Trigonometric moments of the main size.
    pub(crate) fn trigonometric(&self) -> Option<&SearchRecord> {
        let m = self.main_order();
        self.find(&trigonometric_basis(m)).filter(|record| record.m == m)
    }

    /// What the histogram annotates (MSM15 Figure 4): PCF, closed forms on the moved depths, power and trigonometric
    /// moments.
    pub(crate) fn landmarks(&self) -> Vec<Landmark> {
        let mut references = vec![Landmark { name: "PCF".to_owned(), error: 0.0 }];
        for mark in ["VSM", "ESM"].iter().filter_map(|role| self.mark(role)) {
            references.push(Landmark { name: mark.technique.clone(), error: mark.moved_l1_error });
        }
        for (name, record) in [("power", self.power()), ("trigonometric", self.trigonometric())] {
            references
                .extend(record.map(|r| Landmark { name: format!("{name} {}", r.m), error: r.l1_error }));
        }
        references
    }

    /// Speeds by basis, in the order in which they were measured.
    pub(crate) fn speeds(&self) -> Vec<Speed> {
        let bases = distinct(self.samples.iter().map(|sample| sample.basis.as_str()));
        let best = |basis: &str, solver: &str| {
            let of_solver = self.samples.iter().filter(|s| s.basis == basis && s.solver.starts_with(solver));
            let rate = |s: &SearchSample| s.programs as f64 / (s.time_ns.max(1) as f64 * 1e-9);
            of_solver.map(|s| (rate(s), s.wrong, s.programs)).max_by(|a, b| a.0.total_cmp(&b.0))
        };
        let speed = |basis: &&str| {
            let (solver, (fast, ..)) = CERTIFIED.iter().find_map(|s| Some((*s, best(basis, s)?)))?;
            let (microlp, microlp_wrong, microlp_programs) = best(basis, "good_lp")?;
            Some(Speed { basis: (*basis).to_owned(), solver, fast, microlp, microlp_wrong, microlp_programs })
        };
        bases.iter().filter_map(speed).collect()
    }

    /// The answer to the experiment's question.
    pub(crate) fn answer(&self) -> Vec<Text> {
        let m = self.main_order();
        let all = self.of(m);
        let mut sentences: Vec<Text> = Vec::new();
        if let Some(best) = all.first() {
            let (count, high) = (all.count(), best.rank_high);
            // Who shares the first place is no winner.
            let found = match high {
                1 => format!("of {count} candidates of {m} functions the best is "),
                _ => format!(
                    "of {count} candidates of {m} functions {high} are not told from the best; the least mean has "
                ),
            };
            let with = format!(" with {}.", self.error(best));
            sentences.push(Text::from(self.level().before(&found)).code(&best.basis).and(with));
        }
        for (name, record) in [("trigonometric", self.trigonometric()), ("power", self.power())] {
            if let Some(record) = record {
                sentences.push(
                    format!(
                        "{} {name} moments are at rank {} ({} to {}) with {}.",
                        in_words(m),
                        record.rank,
                        record.rank_low,
                        record.rank_high,
                        self.error(record)
                    )
                    .into(),
                );
            }
        }
        if let (Some(best), Some(power)) = (all.first(), self.power()) {
            let near = all.count_if(|r| r.l1_error <= 1.1 * best.l1_error);
            let better = all.count_if(|r| r.l1_error + r.interval < power.l1_error);
            sentences.push(format!(
                "{near} candidates are within a tenth of the best one's error, {better} are certainly better than \
                 power moments."
            ).into());
        }
        if let Some(vsm) = self.mark("VSM") {
            let beaten = all.count_if(|r| r.l1_error < vsm.moved_l1_error);
            let share = beaten as f64 / all.count().max(1) as f64;
            sentences.push(format!("{} of all candidates beat VSM.", percent(share, 1)).into());
        }
        let best_of: Vec<String> = self
            .orders()
            .iter()
            .filter_map(|&m| Some(format!("{} for m = {m}", percent(self.of(m).first()?.l1_error, 2))))
            .collect();
        if best_of.len() > 1 {
            sentences.push(format!("The best error by number of functions: {}.", best_of.join(", ")).into());
        }
        let programs: u64 = self.stages.iter().map(|stage| stage.programs).sum();
        let uncertified: u64 = self.stages.iter().map(|stage| stage.uncertified).sum();
        sentences.push(programs_solved(programs, uncertified));
        sentences
    }
}

/// 99 % of a normal distribution lie within so many standard deviations, as in the records' intervals.
const DEVIATIONS: f64 = 2.576;

impl SearchTables<'_> {
    /// An error in percent with half a 99 % interval of its own, and with that of its difference to the power moments.
    ///
    /// A candidate's error is that of the power moments on the whole sample plus the difference to them, so that its interval
    /// is at most the sum of both.
    pub(crate) fn error(&self, record: &SearchRecord) -> String {
        let control = format!("power:{} over the support", record.m);
        let control = self.marks.iter().find(|mark| mark.technique == control);
        let own = control.map(|mark| DEVIATIONS * mark.moved_standard_error + record.interval);
        let level = own.map_or_else(|| percent(record.l1_error, 3), |own| within(record.l1_error, own));
        match is_power(record) {
            true => level,
            false => format!("{level} (against power moments ± {})", percent(record.interval, 3)),
        }
    }
}

/// Whether these are the power moments, whose difference to themselves is certain.
fn is_power(record: &SearchRecord) -> bool {
    record.basis == power_basis(record.m)
}

/// A number of functions at the beginning of a sentence.
fn in_words(m: usize) -> String {
    const WORDS: [&str; 8] = ["One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight"];
    WORDS.get(m.wrapping_sub(1)).map_or_else(|| m.to_string(), |word| (*word).to_owned())
}

pub(crate) fn within(value: f64, deviation: f64) -> String {
    format!("{} ± {}", in_percent(value, 3), percent(deviation, 3))
}
