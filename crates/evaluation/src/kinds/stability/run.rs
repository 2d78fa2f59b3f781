//! From an experiment to its tables.

use super::cell::{Failure, Outcome, PIVOT_ORDERS, StabilityPlan, Worst};
use super::family::Draw;
use super::input::{Input, Moments};
use super::method::{Prepared, Start};
use super::records::{CellRecord, CheckRecord, PivotRecord, StabilityRecord, StabilitySample, WorstRecord};
use super::scenes;
use super::settings::{Arithmetic, Shape, StabilityExperiment, StabilityFamily, StabilityMethod};
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::fragments::ViewRecord;
use crate::run::Recorded;
use crate::run_directory::RecordedFile;
use crate::shards::{self, Gathered};
use moment_problem::MomentBound;
use moment_problem::arithmetic::{DoubleDouble, Real};
use random_stream::Random;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::cell::OnceCell;
use std::fmt::Write as _;
use std::time::Instant;

impl StabilityExperiment {
    /// Evaluates all cells of all families in parallel, then times the methods alone.
    pub(super) fn evaluate(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        let plan = self.plan()?;
        // Fragments are for some families only, and a shard may have none of these.
        let scenes = OnceCell::new();
        let of_scenes = || -> Result<&Scenes, EvaluationError> {
            match scenes.get() {
                Some(found) => Ok(found),
                None => scenes::inputs(self).map(|found| scenes.get_or_init(|| found)),
            }
        };
        let one = |number: usize| {
            let (family, row) = (number / self.cells, number % self.cells);
            let settings = &self.family[family];
            let by_cell = match settings.shape {
                Shape::Scenes => self.by_cell(settings, &of_scenes()?.0),
                Shape::OneSurface
                | Shape::TwoSurfaces
                | Shape::LightSurface
                | Shape::AtSurface
                | Shape::ThreeSurfaces
                | Shape::Pole
                | Shape::SqueezedRange => Vec::new(),
            };
            Ok(self.row(&plan, (family, row), &by_cell))
        };
        let costs = vec![1; self.family.len() * self.cells];
        let rows = match shards::numbered(context, "rows of cells", &costs, &one)? {
            Gathered::All(rows) => rows,
            Gathered::Part(recorded) => return Ok(recorded),
        };
        let mut tables = Tables::default();
        for (index, rows) in rows.chunks(self.cells).enumerate() {
            tables.add(self, &plan, index, rows);
        }
        let views = if self.has_scenes() { of_scenes()?.1.clone() } else { Vec::new() };
        let samples = self.time(&plan)?;
        let trials = tables.records.len();
        let failed = tables.records.iter().filter(|record| !record.error.is_empty()).count();
        let files = vec![
            RecordedFile::csv("records.csv", &tables.records)?,
            RecordedFile::csv("cells.csv", &tables.cells)?,
            RecordedFile::csv("worst.csv", &tables.worst)?,
            RecordedFile::csv("checks.csv", &tables.checks)?,
            RecordedFile::csv("pivots.csv", &tables.pivots)?,
            RecordedFile::csv("views.csv", &views)?,
            RecordedFile::csv("samples.csv", &samples)?,
        ];
        Ok(Recorded { files, trials, failed, complete: true })
    }

    fn has_scenes(&self) -> bool {
        self.family.iter().any(|family| family.shape == Shape::Scenes)
    }

    /// The cells of one row of a family, in parallel.
    fn row(&self, plan: &StabilityPlan, (family, row): (usize, usize), fragments: &[Vec<&Input>]) -> Row {
        let cells = row * self.cells..(row + 1) * self.cells;
        let outcomes: Vec<Outcome> =
            cells.into_par_iter().map(|cell| self.cell(plan, family, cell, fragments)).collect();
        let mut found = Row { whole: Outcome::new(plan), cells: Vec::new() };
        for (x, outcome) in outcomes.iter().enumerate() {
            found.whole.merge(outcome);
            for (i, method) in self.technique.iter().enumerate() {
                let tally = &outcome.tallies[i][0];
                if method.atlas && tally.inputs > 0 {
                    found.cells.push(CellRecord {
                        method: i,
                        family,
                        x,
                        y: row,
                        inputs: tally.inputs,
                        error_max: format!("{:.1e}", tally.error_max).parse().unwrap_or(tally.error_max),
                        not_finite: tally.not_finite,
                        visible: tally.visible,
                    });
                }
            }
        }
        found
    }

    fn plan(&self) -> Result<StabilityPlan, EvaluationError> {
        let methods: Vec<Prepared> = self
            .technique
            .iter()
            .enumerate()
            .map(|(i, method)| Prepared::new(method, &format!("technique[{i}]")))
            .collect::<Result<_, _>>()?;
        let alphas = |method: &Prepared| {
            let others = [0.0].into_iter().chain(self.alphas.values());
            [method.alpha].into_iter().chain(others.filter(|&alpha| alpha != method.alpha)).collect()
        };
        let first_like = |(i, method): (usize, &Prepared)| {
            methods[..i].iter().position(|other| other.same_problem(method)).unwrap_or(i)
        };
        Ok(StabilityPlan {
            alphas: methods.iter().map(alphas).collect(),
            problems: methods.iter().enumerate().map(first_like).collect(),
            methods,
        })
    }

    /// The fragments in each cell of a family of shape `scenes`; nothing for others.
    fn by_cell<'a>(&self, family: &StabilityFamily, fragments: &'a [Input]) -> Vec<Vec<&'a Input>> {
        let mut cells = vec![Vec::new(); self.cells * self.cells];
        if family.shape == Shape::Scenes {
            for input in fragments {
                let (x, y) = scenes::knobs(input);
                let place = family.y.cell(y, self.cells) * self.cells + family.x.cell(x, self.cells);
                cells[place].push(input);
            }
        }
        cells
    }

    fn cell(&self, plan: &StabilityPlan, family: usize, cell: usize, fragments: &[Vec<&Input>]) -> Outcome {
        let mut outcome = Outcome::new(plan);
        let settings = &self.family[family];
        if settings.shape == Shape::Scenes {
            for input in &fragments[cell] {
                outcome.evaluate(plan, input);
                outcome.check(plan, input);
            }
            return outcome;
        }
        let mut draw = Draw(Random::substream(self.scenery.seed, family as u64, cell as u64));
        let next = |draw: &mut Draw| {
            let place = |index: usize, fraction: f64| (index as f64 + fraction) / self.cells as f64;
            let x = settings.x.at(place(cell % self.cells, draw.0.unit()));
            let y = settings.y.at(place(cell / self.cells, draw.0.unit()));
            draw.input(settings.shape, x, y)
        };
        for _ in 0..self.draws {
            outcome.evaluate(plan, &next(&mut draw));
        }
        for _ in 0..self.checked {
            outcome.check(plan, &next(&mut draw));
        }
        outcome
    }

    /// Methods in turns, so that all see the same machine.
    fn time(&self, plan: &StabilityPlan) -> Result<Vec<StabilitySample>, EvaluationError> {
        let Some(family) = self.family.iter().find(|family| family.shape != Shape::Scenes) else {
            return Ok(Vec::new());
        };
        let mut draw = Draw(Random::substream(self.scenery.seed, u64::MAX, 0));
        let inputs: Vec<(Input, Moments<DoubleDouble>)> = (0..self.timing.inputs)
            .map(|_| {
                let (x, y) = (family.x.at(draw.0.unit()), family.y.at(draw.0.unit()));
                let input = draw.input(family.shape, x, y);
                let moments = Moments::exact(&input);
                (input, moments)
            })
            .collect();
        let mut samples = Vec::new();
        for repetition in 0..self.timing.repetitions {
            // A processor takes longer for half floats than for single ones, of which they are made here.
            let timed = |settings: &StabilityMethod| settings.arithmetic != Arithmetic::F16;
            for (method, settings) in plan.methods.iter().zip(&self.technique).filter(|(_, s)| timed(s)) {
                let ready: Vec<_> = inputs
                    .iter()
                    .map(|(input, moments)| {
                        let b = method.moments(moments);
                        (method.stored(b), b.map(Real::to_f64), method.depth(input))
                    })
                    .collect();
                let begin = Instant::now();
                for (stored, plain, z_f) in &ready {
                    let start = stored.as_ref().map_or(Start::Plain(plain), Start::Stored);
                    std::hint::black_box(method.answer(std::hint::black_box(start), *z_f, method.alpha));
                }
                let elapsed = begin.elapsed();
                samples.push(StabilitySample {
                    method: settings.name.clone(),
                    repetition,
                    bounds: ready.len(),
                    time_ns: u64::try_from(elapsed.as_nanos()).unwrap_or(u64::MAX),
                });
            }
        }
        Ok(samples)
    }
}

/// A row of cells of a family: together, and what pictures show of each.
#[derive(Clone, Deserialize, Serialize)]
struct Row {
    whole: Outcome,
    cells: Vec<CellRecord>,
}

/// Fragments of all views, with the views.
type Scenes = (Vec<Input>, Vec<ViewRecord>);

#[derive(Default)]
struct Tables {
    records: Vec<StabilityRecord>,
    cells: Vec<CellRecord>,
    worst: Vec<WorstRecord>,
    checks: Vec<CheckRecord>,
    pivots: Vec<PivotRecord>,
}

/// Three digits.
fn short(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

impl Tables {
    fn add(&mut self, experiment: &StabilityExperiment, plan: &StabilityPlan, family: usize, rows: &[Row]) {
        let name = &experiment.family[family].name;
        let mut whole = Outcome::new(plan);
        for row in rows {
            whole.merge(&row.whole);
            self.cells.extend(row.cells.iter().cloned());
        }
        for (i, method) in experiment.technique.iter().enumerate() {
            for (step, &alpha) in plan.alphas[i].iter().enumerate() {
                let tally = &whole.tallies[i][step];
                self.records.push(StabilityRecord {
                    method: method.name.clone(),
                    family: name.clone(),
                    alpha: short(alpha),
                    recommended: step == 0,
                    inputs: tally.inputs,
                    not_finite: tally.not_finite,
                    outside: tally.outside,
                    violated: tally.violated,
                    visible: tally.visible,
                    largest_excess: short(tally.largest_excess),
                    error_median: short(tally.errors.quantile(0.5)),
                    error_999: short(tally.errors.quantile(0.999)),
                    error_max: short(tally.error_max),
                    mean_loss: short(tally.loss_sum / tally.losses_known.max(1) as f64),
                    loss_99: short(tally.losses.quantile(0.99)),
                    error: if tally.inputs > 0 { String::new() } else { "no inputs".to_owned() },
                });
            }
            for (worst, failure) in whole.worst[i].iter().zip(Failure::ALL) {
                self.worst.extend(worst.as_ref().map(|worst| WorstRecord {
                    method: method.name.clone(),
                    family: name.clone(),
                    failure: failure.name().to_owned(),
                    value: worst.value,
                    exact_biased: worst.exact_biased,
                    exact: worst.exact,
                    mass_before: worst.input.mass_before(),
                    command: command(plan.methods[i].bound, worst),
                }));
            }
            if plan.methods[i].is_checked() {
                let check = &whole.checks[i];
                self.checks.push(CheckRecord {
                    method: method.name.clone(),
                    family: name.clone(),
                    inputs: check.inputs,
                    not_finite: check.not_finite,
                    outside: check.outside,
                    violated: check.violated,
                    largest_excess: short(check.largest_excess),
                });
            }
        }
        for (histogram, order) in whole.pivots.iter().zip(PIVOT_ORDERS) {
            self.pivots.push(PivotRecord {
                family: name.clone(),
                order,
                inputs: whole.tallies.first().map_or(0, |tallies| tallies[0].inputs),
                below_1e3: short(histogram.share_below(-3)),
                below_1e6: short(histogram.share_below(-6)),
                below_1e9: short(histogram.share_below(-9)),
                median: short(histogram.quantile(0.5)),
            });
        }
    }
}

/// The command line that prints the exact bound of an input.
fn command(bound: MomentBound, worst: &Worst) -> String {
    let (basis, interval) = (bound.basis_name(), bound.interval().name());
    let mut text = format!("msm bound --basis {basis} --interval {interval} --atoms ");
    for (i, (z, w)) in worst.input.atoms.iter().enumerate() {
        let comma = if i > 0 { "," } else { "" };
        // Writing to a string cannot fail.
        let _ = write!(text, "{comma}{z}:{w}");
    }
    let _ = write!(text, " --depth {}", worst.input.z_f);
    text
}
