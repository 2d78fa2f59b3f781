//! Candidates of four functions on a graphics processor: many at a time, on all programs of the one block of a search without
//! race.

use super::block::Block;
use super::judge::{Finding, Key, Verdict};
use super::sweep::{Control, Sweep};
use crate::error::EvaluationError;
use crate::run::Backend;
use crate::statistics::{Running, stratified};
use moment_problem::lane_simplex::{ExactSimplex, LaneStarts, MAX_FUNCTIONS, ProgramBatch, SpanColumns};
use moment_problem_gpu::{Answer, Card, CardError, GROUP, Programs, ResidentPrograms, Submitted, Weighting};
use rayon::prelude::*;

/// Candidates that the card works on together.
pub(crate) const TOGETHER: usize = 32;

/// Programs that stay together on the card: a pass over them and all candidates takes some milliseconds.
const TILE: usize = 1 << 18;

/// The card and the CPU may differ by the tolerances of both.
const LARGEST_DIFFERENCE: f64 = 2e-6;

/// The card for a run; `None` for the CPU.
pub(crate) fn chosen(backend: Backend) -> Result<Option<Card>, EvaluationError> {
    match backend {
        Backend::Cpu => Ok(None),
        Backend::Gpu => Card::open(false).map(Some).map_err(failed),
        // A software adapter is slower than the solver for the CPU.
        Backend::Auto => Ok(Card::open(false).ok().filter(|card| !card.is_software())),
    }
}

fn failed(error: CardError) -> EvaluationError {
    EvaluationError::Value(format!("--backend gpu: {error}"))
}

/// All programs of a block on the card.
pub(crate) struct CardSweep<'a> {
    sweep: &'a Sweep<'a>,
    card: &'a Card,
    /// Which order, counted in the experiment's list.
    order: usize,
    block: &'a Block,
    batch: &'a ProgramBatch<'a>,
    control: &'a Control,
    starts: &'a LaneStarts,
    tiles: Vec<Tile<'a>>,
}

struct Tile<'a> {
    /// Programs by place.
    order: Vec<Option<u32>>,
    /// By group.
    views: Vec<u16>,
    resident: ResidentPrograms<'a>,
}

/// A batch of candidates on its way.
pub(crate) struct Pending {
    keys: Vec<Key>,
    columns: Vec<SpanColumns>,
    submitted: Vec<Submitted>,
}

impl<'a> CardSweep<'a> {
    /// Puts the programs of the first block on the card; `None` if no candidates have four functions.
    pub(crate) fn new(sweep: &'a Sweep<'a>, card: &'a Card) -> Result<Option<Self>, EvaluationError> {
        let order = sweep.subsets.iter().position(|subsets| subsets.order() == MAX_FUNCTIONS);
        let Some((order, control)) = order.and_then(|order| Some((order, sweep.controls[order].first()?)))
        else {
            return Ok(None);
        };
        let (Some(block), Some(batch), Some(starts)) =
            (sweep.workload.blocks.first(), sweep.batch(0), control.lane_starts())
        else {
            return Ok(None);
        };
        let weight = |(entry, &control): (&super::block::Entry, &f64)| Weighting {
            reference: entry.reference,
            control,
            count: f64::from(entry.count),
        };
        let weighting: Vec<Weighting> = block.entries.iter().zip(&control.errors).map(weight).collect();
        // Programs of a view together, in the order of their depths; each view fills whole groups.
        let mut order_of_all: Vec<u32> = (0..block.entries.len() as u32).collect();
        order_of_all.sort_by_key(|&program| (block.entries[program as usize].view, program));
        let mut places: Vec<Option<u32>> = Vec::new();
        let mut views: Vec<u16> = Vec::new();
        for program in order_of_all {
            let view = block.entries[program as usize].view;
            if places.len().is_multiple_of(GROUP) || views.last() != Some(&view) {
                places.resize(places.len().next_multiple_of(GROUP), None);
                views.push(view);
            }
            places.push(Some(program));
        }
        let mut tiles: Vec<Tile<'a>> = Vec::new();
        for (order, views) in places.chunks(TILE).zip(views.chunks(TILE / GROUP)) {
            let programs = Programs { batch, starts, weighting: &weighting, order };
            let shared = tiles.first().map(|tile| &tile.resident);
            let resident = card.upload(programs, TOGETHER, shared).map_err(failed)?;
            tiles.push(Tile { order: order.to_vec(), views: views.to_vec(), resident });
        }
        Ok(Some(Self { sweep, card, order, block, batch, control, starts, tiles }))
    }

    /// Whether the card serves a candidate. Those with dependent functions have another rank.
    pub(crate) fn serves(&self, (block, order, _): &Key) -> bool {
        (usize::from(*block), usize::from(*order)) == (0, self.order)
    }

    /// Candidates that it serves, spread evenly.
    pub(crate) fn spread(&self, count: usize) -> Vec<Key> {
        let all = self.sweep.subsets[self.order].len();
        let number = |i: usize| ((2 * i + 1) * all / (2 * count)) as u32;
        (0..count).map(|i| (0, self.order as u16, number(i))).collect()
    }

    /// Hands a batch of candidates to the card; those that it does not serve are left out.
    pub(crate) fn submit(&self, keys: &[Key]) -> Result<Pending, EvaluationError> {
        let span = self.batch.span();
        let columns = |&(block, order, number): &Key| {
            let columns = span.columns(&self.sweep.members(order.into(), number)).ok()?;
            (columns.columns().rank() == MAX_FUNCTIONS + 1).then_some(((block, order, number), columns))
        };
        let (keys, columns): (Vec<Key>, Vec<SpanColumns>) =
            keys.par_iter().filter_map(columns).collect::<Vec<_>>().into_iter().unzip();
        let wanted: Vec<&SpanColumns> = columns.iter().collect();
        let tolerance = self.sweep.experiment.tolerance;
        let mut submitted = Vec::new();
        if !wanted.is_empty() {
            for tile in &self.tiles {
                submitted.push(tile.resident.submit(self.batch, &wanted, tolerance).map_err(failed)?);
            }
        }
        Ok(Pending { keys, columns, submitted })
    }

    /// Waits for a batch and decides what the card left.
    pub(crate) fn finish(&self, pending: Pending) -> Result<Vec<(Key, Finding)>, EvaluationError> {
        let Pending { keys, columns, submitted } = pending;
        let mut answers: Vec<Answer> = Vec::new();
        for (tile, submitted) in self.tiles.iter().zip(submitted) {
            answers.push(tile.resident.finish(submitted).map_err(failed)?.0);
        }
        let judged: Result<Vec<Finding>, EvaluationError> =
            (0..keys.len()).into_par_iter().map(|c| self.judge(c, keys[c], &columns[c], &answers)).collect();
        Ok(keys.into_iter().zip(judged?).collect())
    }

    fn judge(
        &self,
        candidate: usize,
        key: Key,
        columns: &SpanColumns,
        answers: &[Answer],
    ) -> Result<Finding, EvaluationError> {
        let views = self.block.sampled.len();
        let (mut sums, mut squares) = (vec![0.0; views], vec![0.0; views]);
        let exact = ExactSimplex::new(columns.columns());
        let tolerance = self.sweep.experiment.tolerance;
        let bound = |program: u32, support: &[u16]| {
            let fragment = &self.block.fragments[program as usize];
            let kernel = &self.block.kernels[fragment.kernel as usize];
            exact.bound(kernel, fragment.step, fragment.mass_before, support)
        };
        let (mut decided, mut uncertified) = (0, 0);
        for (tile, answer) in self.tiles.iter().zip(answers) {
            let groups = &answer.sums[candidate * answer.groups..][..answer.groups];
            for (group, &view) in groups.iter().zip(&tile.views) {
                sums[usize::from(view)] += group.difference;
                squares[usize::from(view)] += group.square;
            }
            let first = answer.left.partition_point(|left| (left.candidate as usize) < candidate);
            let own = answer.left[first..].iter().take_while(|left| left.candidate as usize == candidate);
            for left in own {
                let Some(program) = tile.order[left.program as usize] else { continue };
                decided += 1;
                let found = bound(program, &left.support);
                let certified = found.as_ref().is_some_and(|found| found.lower - found.proved <= tolerance);
                uncertified += u32::from(!certified);
                let entry = &self.block.entries[program as usize];
                let error = (found.map_or(0.0, |found| found.lower) - entry.reference).abs();
                let difference = error - self.control.errors[program as usize];
                sums[usize::from(entry.view)] += f64::from(entry.count) * difference;
                squares[usize::from(entry.view)] += f64::from(entry.count) * difference * difference;
            }
            self.check(candidate, key, answer, tile, &bound)?;
        }
        let sampled = &self.block.sampled;
        let control = &self.control.verdict;
        let running: Vec<Running> =
            (0..views).map(|view| Running::of(f64::from(sampled[view]), sums[view], squares[view])).collect();
        let all: Vec<usize> = self.sweep.workload.views.iter().map(|view| view.fragments).collect();
        let difference = stratified(&running, &all);
        let verdict = Verdict {
            error: control.error + difference.value,
            difference,
            programs: self.block.fragments.len() as u32,
            exact: decided,
            uncertified,
        };
        Ok(Finding { verdict, dropped: 0 })
    }

    /// Solves one program of a tile again and compares.
    fn check(
        &self,
        candidate: usize,
        (_, _, number): Key,
        answer: &Answer,
        tile: &Tile<'_>,
        bound: &dyn Fn(u32, &[u16]) -> Option<moment_problem::lane_simplex::ExactBound>,
    ) -> Result<(), EvaluationError> {
        let group = number as usize * 7919 % answer.groups;
        let place = answer.sampled(candidate, group);
        let sample = answer.sums[candidate * answer.groups + group].sample;
        let Some(program) = tile.order.get(place).copied().flatten().filter(|_| sample >= 0.0) else {
            return Ok(());
        };
        let [first, _] = self.starts.of(program as usize);
        let Some(found) = bound(program, first) else { return Ok(()) };
        if (sample - found.lower).abs() <= LARGEST_DIFFERENCE {
            return Ok(());
        }
        Err(EvaluationError::Value(format!(
            "{} answers {sample} for program {program} of candidate {number}, where {} is right: nothing of it is recorded",
            self.card.name(),
            found.lower
        )))
    }
}
