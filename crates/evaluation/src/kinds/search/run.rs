//! From a search to its tables.

use super::agreement::compare;
use super::candidates::Subsets;
use super::card::{self, CardSweep};
use super::judge::{Finding, Key};
use super::pieces::SearchPieces;
use super::ranking::{STEPS, control_error, ranked};
use super::records::{MarkRecord, SearchRecord, StageRecord};
use super::settings::SearchExperiment;
use super::supplies::Given;
use super::sweep::Sweep;
use super::timing::time;
use super::workload::Workload;
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::experiment::{CardPrediction, Prediction};
use crate::run::{Backend, Recorded};
use crate::run_directory::RecordedFile;
use crate::shards::{self, Gathered, Task};
use crate::statistics::{Mean, rounded_to, stratified};
use moment_problem::BasisFunction;
use moment_problem_gpu::Card;
use std::collections::HashMap;
use std::time::Instant;

/// Fragments of a view that predictions are measured on at most.
const MEASURED_FRAGMENTS: usize = 32_000;

impl SearchExperiment {
    fn prepare(&self) -> Result<(Workload, Vec<BasisFunction>), EvaluationError> {
        Ok((Workload::prepare(self)?, self.functions()?))
    }

    /// Runs the search or a part of it.
    pub(super) fn evaluate(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        let Given { workload, solved, inputs } = self.given(context)?;
        let functions = self.functions()?;
        let sweep = match solved {
            Some((controls, coordinates)) => {
                Sweep::with(self, &workload, functions.len(), (controls, &coordinates))
            }
            None => Sweep::new(self, &workload, functions.len())?,
        };
        let is_work = !matches!(context.task, Task::Select { .. });
        let card = if is_work { card::chosen(context.backend)? } else { None };
        let on_card = card.as_ref().map(|card| CardSweep::new(&sweep, card)).transpose()?.flatten();
        let pieces = SearchPieces { sweep: &sweep, card: on_card.as_ref(), progress: context.progress };
        if matches!(context.task, Task::Select { round: 0, .. }) {
            self.supply(context, &sweep)?;
        }
        match shards::gather(context, &inputs, &pieces)? {
            Gathered::All(known) => self.recorded(&sweep, &functions, &known),
            Gathered::Part(recorded) => Ok(recorded),
        }
    }

    fn recorded(
        &self,
        sweep: &Sweep<'_>,
        functions: &[BasisFunction],
        known: &HashMap<Key, Finding>,
    ) -> Result<Recorded, EvaluationError> {
        let of_order = |order: usize| ranked(sweep, functions, known, order);
        let records: Vec<SearchRecord> = (0..sweep.subsets.len()).flat_map(of_order).collect();
        let agreement = compare(sweep, functions);
        let samples = time(sweep, functions);
        let failed = records.iter().filter(|record| !record.error.is_empty()).count();
        let files = vec![
            RecordedFile::csv("records.csv", &records)?,
            RecordedFile::csv("stages.csv", &stages(sweep, known))?,
            RecordedFile::csv("marks.csv", &marks(sweep))?,
            RecordedFile::csv("views.csv", &sweep.workload.views)?,
            RecordedFile::csv("reference.csv", &sweep.workload.references)?,
            RecordedFile::csv("agreement.csv", &agreement)?,
            RecordedFile::csv("samples.csv", &samples)?,
        ];
        let trials = sweep.subsets.iter().map(Subsets::len).sum();
        Ok(Recorded { files, trials, failed, complete: true })
    }

    /// Measures some candidates and says what all will cost.
    pub(crate) fn predict(&self, threads: usize, backend: Backend) -> Result<Prediction, EvaluationError> {
        const MEASURED: usize = 24;
        // The first block says all that is needed, and the later ones can be large; so can the only one.
        let mut first = Self { blocks: 1, ..self.clone() };
        let share = self.scenery.fragments.div_ceil(MEASURED_FRAGMENTS).max(1) as u64;
        first.scenery.fragments = self.scenery.fragments.div_ceil(share as usize);
        let (workload, functions) = first.prepare()?;
        let sweep = Sweep::new(&first, &workload, functions.len())?;
        let (mut candidates, mut measured, mut seconds) = (0, 0, 0.0);
        for (order, subsets) in sweep.subsets.iter().enumerate() {
            candidates += subsets.len() as u64;
            let clock = Instant::now();
            for i in 0..MEASURED {
                let number = (2 * i + 1) * subsets.len() / (2 * MEASURED);
                measured += u64::from(sweep.find(0, order, number as u32).verdict.programs);
            }
            seconds += clock.elapsed().as_secs_f64();
        }
        let distinct =
            |block: usize| (share * workload.blocks[0].fragments.len() as u64) << block.saturating_sub(1);
        let programs = candidates * distinct(0);
        let best = (self.best * self.orders.len()) as u64;
        let later = (1..self.blocks)
            .map(|block| distinct(block) * (candidates / 50u64.pow(block as u32)).max(best.min(candidates)))
            .sum::<u64>();
        let programs_per_second = measured as f64 / seconds.max(1e-9);
        let card = match card::chosen(backend)? {
            Some(card) => self.predict_card(&sweep, &card, (programs + later) as f64)?,
            None => None,
        };
        /// Bytes of a candidate in checkpoint and table.
        const BYTES: u64 = 400;
        /// Bytes of a program: kernel, its coordinates, starts, errors, and the same once more while they are read.
        const PROGRAM_BYTES: u64 = 1_000;
        /// Bytes of everything else.
        const CODE_BYTES: u64 = 64 << 20;
        Ok(Prediction {
            candidates,
            programs,
            later_programs: later,
            programs_per_second,
            threads,
            hours: (programs + later) as f64 / programs_per_second / threads as f64 / 3600.0,
            disk_bytes: candidates * BYTES,
            memory_bytes: PROGRAM_BYTES * (0..self.blocks).map(distinct).max().unwrap_or(0) + CODE_BYTES,
            card,
        })
    }

    /// The same on a card, for candidates spread evenly over those of four functions.
    fn predict_card(
        &self,
        sweep: &Sweep<'_>,
        card: &Card,
        programs: f64,
    ) -> Result<Option<CardPrediction>, EvaluationError> {
        let Some(on_card) = CardSweep::new(sweep, card)? else { return Ok(None) };
        let keys = on_card.spread(4 * card::TOGETHER);
        let (mut solved, mut left) = (0u64, 0u64);
        let mut clock = Instant::now();
        let mut waiting = None;
        // The first batch warms up.
        for (number, batch) in keys.chunks(card::TOGETHER).chain([&[][..]]).enumerate() {
            let next = on_card.submit(batch)?;
            let Some(before) = waiting.replace(next) else { continue };
            for (_, finding) in on_card.finish(before)? {
                solved += u64::from(finding.verdict.programs);
                left += u64::from(finding.verdict.exact);
            }
            if number == 1 {
                (solved, left, clock) = (0, 0, Instant::now());
            }
        }
        let programs_per_second = solved as f64 / clock.elapsed().as_secs_f64().max(1e-9);
        Ok(Some(CardPrediction {
            adapter: card.name(),
            programs_per_second,
            exact: left as f64 / solved.max(1) as f64,
            hours: programs / programs_per_second.max(1.0) / 3600.0,
        }))
    }
}

fn stages(sweep: &Sweep<'_>, known: &HashMap<Key, Finding>) -> Vec<StageRecord> {
    let mut stages = Vec::new();
    for (order, subsets) in sweep.subsets.iter().enumerate() {
        for (block, fragments) in sweep.workload.blocks.iter().enumerate() {
            let mut stage = StageRecord {
                m: subsets.order(),
                block,
                fragments: fragments.fragments_drawn(),
                candidates: 0,
                programs: 0,
                exact: 0,
                uncertified: 0,
            };
            for ((b, o, _), finding) in known {
                if (usize::from(*b), usize::from(*o)) == (block, order) {
                    stage.candidates += 1;
                    stage.programs += u64::from(finding.verdict.programs);
                    stage.exact += u64::from(finding.verdict.exact);
                    stage.uncertified += u64::from(finding.verdict.uncertified);
                }
            }
            stages.push(stage);
        }
    }
    stages
}

/// Closed forms, and the controls over the support.
fn marks(sweep: &Sweep<'_>) -> Vec<MarkRecord> {
    let all: Vec<usize> = sweep.workload.views.iter().map(|view| view.fragments).collect();
    let deviation = |mean: &Mean| rounded_to(mean.variance.sqrt(), STEPS);
    let mut marks = Vec::new();
    for mark in &sweep.workload.marks {
        let [exact, moved, difference] =
            [&mark.exact, &mark.moved, &mark.difference].map(|views| stratified(views, &all));
        marks.push(MarkRecord {
            technique: mark.name.clone(),
            l1_error: Some(rounded_to(exact.value, STEPS)),
            standard_error: Some(deviation(&exact)),
            moved_l1_error: rounded_to(moved.value, STEPS),
            moved_standard_error: deviation(&moved),
            difference_standard_error: Some(deviation(&difference)),
        });
    }
    for (order, subsets) in sweep.subsets.iter().enumerate() {
        let error = sweep.control_level(order, &all);
        marks.push(MarkRecord {
            technique: format!("power:{} over the support", subsets.order()),
            l1_error: None,
            standard_error: None,
            moved_l1_error: rounded_to(control_error(sweep, order).value, STEPS),
            moved_standard_error: deviation(&error),
            difference_standard_error: None,
        });
    }
    marks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::{Experiment, Scale};
    use std::path::Path;

    /// Of 6.06 billion programs of the scale quick without a race, one of each of these candidates had no certificate while the
    /// walk in double-double had one start.
    #[test]
    fn programs_that_need_another_start_are_certified() {
        let text = include_str!("../../../../../experiments/candidate-search.toml");
        let read = Experiment::parse(Path::new("candidate-search.toml"), text, Scale::Quick, None).unwrap();
        let mut experiment = read.settings::<SearchExperiment>().unwrap().clone();
        experiment.scenery.fragments = experiment.sampled();
        experiment.blocks = 1;
        experiment.orders = vec![4];
        let (workload, functions) = experiment.prepare().unwrap();
        let sweep = Sweep::new(&experiment, &workload, functions.len()).unwrap();
        for names in
            [["z", "cos(1pi z)", "sin(4pi z)", "cos(4pi z)"], ["z", "cos(1pi z)", "cos(3pi z)", "cos(4pi z)"]]
        {
            let place = |name: &str| functions.iter().position(|function| function.name() == name).unwrap();
            let mut members = names.map(place);
            members.sort_unstable();
            let number = sweep.subsets[0].number(&members) as u32;
            let verdict = sweep.find(0, 0, number).verdict;
            assert!(verdict.programs > 80_000 && verdict.uncertified == 0, "{names:?}: {verdict:?}");
        }
    }
}
