//! All candidates on the first block, the best on the later ones.

use super::block::Block;
use super::candidates::Subsets;
use super::judge::{Finding, Key, Solved, Verdict, errors, judge};
use super::settings::SearchExperiment;
use super::workload::Workload;
use crate::error::EvaluationError;
use crate::statistics::{Mean, Running, joined, stratified};
use moment_problem::fast_simplex::{FastSimplex, FastStart, SupportColumns};
use moment_problem::lane_simplex::{LaneSimplex, LaneStarts, MAX_FUNCTIONS, ProgramBatch};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// A candidate is given up when it is worse than the best ones by more than this many standard errors of both: of
/// 66 045 comparisons of normal variables two would be wrong.
const KEEP_DEVIATIONS: f64 = 4.0;

/// The control of an order: power moments, on one block.
#[derive(Deserialize, Serialize)]
pub(crate) struct Control {
    /// Every candidate starts near one of these.
    starts: Starts,
    pub(crate) errors: Vec<f64>,
    pub(crate) verdict: Verdict,
}

/// Solutions for power and trigonometric moments, for the solver that serves this number of functions.
#[derive(Deserialize, Serialize)]
enum Starts {
    Lanes(LaneStarts),
    Fast([FastStart; 2]),
}

/// On no programs.
impl Default for Control {
    fn default() -> Self {
        let starts = Starts::Fast([FastStart::default(), FastStart::default()]);
        Self { starts, errors: Vec::new(), verdict: Verdict::default() }
    }
}

impl Control {
    /// The starts, where lanes serve this number of functions.
    pub(crate) fn lane_starts(&self) -> Option<&LaneStarts> {
        match &self.starts {
            Starts::Lanes(starts) => Some(starts),
            Starts::Fast(_) => None,
        }
    }
}

/// Everything that a sweep works with.
pub(crate) struct Sweep<'a> {
    pub(crate) experiment: &'a SearchExperiment,
    pub(crate) workload: &'a Workload,
    pub(crate) subsets: Vec<Subsets>,
    /// By block.
    batches: Vec<ProgramBatch<'a>>,
    /// By order and block.
    pub(crate) controls: Vec<Vec<Control>>,
}

impl<'a> Sweep<'a> {
    /// Solves the controls.
    pub(crate) fn new(
        experiment: &'a SearchExperiment,
        workload: &'a Workload,
        members: usize,
    ) -> Result<Self, EvaluationError> {
        let subsets: Vec<Subsets> =
            experiment.orders.iter().map(|&order| Subsets::new(members, order)).collect();
        let batch = |block: &'a Block| ProgramBatch::new(&workload.span, &block.kernels, &block.fragments);
        let batches: Vec<ProgramBatch<'a>> = workload.blocks.par_iter().map(batch).collect();
        let mut controls = Vec::new();
        for &order in &experiment.orders {
            let columns = |functions: &[usize]| {
                SupportColumns::new(&workload.table, functions)
                    .map_err(|error| EvaluationError::Value(format!("moments of order {order}: {error}")))
            };
            let power = columns(&workload.powers[..order])?;
            let trigonometric = columns(&workload.waves[..order])?;
            let of_block = |(block, batch): (&Block, &ProgramBatch<'_>)| {
                let solve = |columns: &SupportColumns| {
                    let solver = FastSimplex::new(columns, experiment.tolerance).thorough();
                    solver.solve(&block.kernels, &block.fragments)
                };
                let solution = solve(&power);
                let solved = Solved::from(&solution);
                let errors = errors(block, &solved);
                let verdict = judge(workload, block, &solved, &errors);
                let starts = [solution.start(), solve(&trigonometric).start()];
                let starts = if order <= MAX_FUNCTIONS {
                    Starts::Lanes(LaneStarts::new(batch, [&starts[0], &starts[1]], order + 1))
                } else {
                    Starts::Fast(starts)
                };
                Control { starts, errors, verdict }
            };
            controls.push(workload.blocks.par_iter().zip(&batches).map(of_block).collect());
        }
        Ok(Self { experiment, workload, subsets, batches, controls })
    }

    /// With controls that were solved and coordinates that were computed before, by block.
    pub(crate) fn with(
        experiment: &'a SearchExperiment,
        workload: &'a Workload,
        members: usize,
        (controls, coordinates): (Vec<Vec<Control>>, &[Vec<f64>]),
    ) -> Self {
        let subsets = experiment.orders.iter().map(|&order| Subsets::new(members, order)).collect();
        let batch = |(block, given): (&'a Block, &Vec<f64>)| {
            let (span, Block { kernels, fragments, .. }) = (&workload.span, block);
            ProgramBatch::with_coordinates(span, kernels, fragments, given)
                .unwrap_or_else(|| ProgramBatch::new(span, kernels, fragments))
        };
        let batches = workload.blocks.iter().zip(coordinates).map(batch).collect();
        Self { experiment, workload, subsets, batches, controls }
    }

    /// The programs of a block.
    pub(crate) fn batch(&self, block: usize) -> Option<&ProgramBatch<'a>> {
        self.batches.get(block)
    }

    /// Members of a candidate as indices into the workload's table.
    pub(crate) fn members(&self, order: usize, number: u32) -> Vec<usize> {
        self.subsets[order].subset(number as usize)
    }

    /// Solves the programs of a block for a basis of an order, given by its members; `None` if all of them are constant on
    /// the support. The second value are those that depend on the ones before them.
    pub(crate) fn solve(
        &self,
        block: usize,
        order: usize,
        members: &[usize],
    ) -> Option<(Solved, Vec<usize>)> {
        let tolerance = self.experiment.tolerance;
        let Block { kernels, fragments, .. } = &self.workload.blocks[block];
        match &self.controls[order][block].starts {
            Starts::Lanes(starts) => {
                let columns = self.workload.span.columns(members).ok()?;
                let support = columns.columns();
                let dropped = support.dropped().to_vec();
                let solver = LaneSimplex::new(&columns, tolerance).filter(|_| dropped.is_empty());
                let solved = match solver {
                    Some(solver) => solver.solve(&self.batches[block], starts).into(),
                    // Starts are for another number of rows.
                    None => Solved::from(&FastSimplex::new(support, tolerance).solve(kernels, fragments)),
                };
                Some((solved, dropped))
            }
            Starts::Fast([power, trigonometric]) => {
                let columns = SupportColumns::new(&self.workload.table, members).ok()?;
                let solver = FastSimplex::new(&columns, tolerance);
                let solution = solver.solve_near(kernels, fragments, &[power, trigonometric]);
                Some((Solved::from(&solution), columns.dropped().to_vec()))
            }
        }
    }

    /// Judges one candidate on one block. `order` counts the experiment's list.
    pub(crate) fn find(&self, block: usize, order: usize, number: u32) -> Finding {
        let members = self.members(order, number);
        let Some((solved, dependent)) = self.solve(block, order, &members) else {
            return Finding { verdict: Verdict::default(), dropped: (1u16 << members.len()) - 1 };
        };
        let control = &self.controls[order][block];
        let verdict = judge(self.workload, &self.workload.blocks[block], &solved, &control.errors);
        let mut dropped = 0;
        for (i, _) in members.iter().enumerate().filter(|(_, member)| dependent.contains(member)) {
            dropped |= 1 << i;
        }
        Finding { verdict, dropped }
    }

    /// Error of a control with its sampling variance.
    pub(crate) fn control_level(&self, order: usize, all: &[usize]) -> Mean {
        let mut views = vec![Running::default(); self.workload.views.len()];
        for (control, block) in self.controls[order].iter().zip(&self.workload.blocks) {
            let mut seen = vec![0; views.len()];
            for (entry, error) in block.entries.iter().zip(&control.errors) {
                views[usize::from(entry.view)].add_repeated(*error, f64::from(entry.count));
                seen[usize::from(entry.view)] += entry.count;
            }
            for (view, seen) in seen.into_iter().enumerate() {
                let idle = f64::from(block.sampled[view] - seen);
                if idle > 0.0 {
                    views[view].add_repeated(block.idle[view] / idle, idle);
                }
            }
        }
        stratified(&views, all)
    }

    /// All candidates, on the first block.
    pub(crate) fn first_keys(&self) -> Vec<Key> {
        let of_order =
            |order: usize| (0..self.subsets[order].len()).map(move |number| (0, order as u16, number as u32));
        (0..self.subsets.len()).flat_map(of_order).collect()
    }

    /// What the blocks before one say about the difference to the control, and how many there are.
    pub(crate) fn estimate(
        &self,
        known: &HashMap<Key, Finding>,
        blocks: usize,
        order: usize,
        number: u32,
    ) -> Option<(Mean, usize)> {
        let findings = |block: usize| known.get(&(block as u16, order as u16, number));
        let judged = (0..blocks).take_while(|&block| findings(block).is_some()).count();
        if judged == 0 || findings(0).is_some_and(|f| f.is_rejected(self.subsets[order].order())) {
            return None;
        }
        let parts = (0..judged).filter_map(|block| {
            Some((findings(block)?.verdict.difference, self.workload.blocks[block].fragments_drawn()))
        });
        Some((joined(parts), judged))
    }

    /// Candidates that can still be among the best, and the marked ones, ascending.
    pub(crate) fn survivors(&self, known: &HashMap<Key, Finding>, block: usize, order: usize) -> Vec<u32> {
        let numbers = 0..self.subsets[order].len() as u32;
        // Only what was judged on every block before this one is still in the race.
        let estimates: Vec<(u32, Mean)> = numbers
            .filter_map(|number| {
                let (mean, judged) = self.estimate(known, block, order, number)?;
                (judged == block).then_some((number, mean))
            })
            .collect();
        let bound = |mean: &Mean, sign: f64| mean.value + sign * KEEP_DEVIATIONS * mean.variance.sqrt();
        let mut uppers: Vec<f64> = estimates.iter().map(|(_, mean)| bound(mean, 1.0)).collect();
        uppers.sort_by(f64::total_cmp);
        let limit = uppers.get(self.experiment.best - 1).copied().unwrap_or(f64::INFINITY);
        let always = self.always(order);
        let stays = |(number, mean): &&(u32, Mean)| bound(mean, -1.0) <= limit || always.contains(number);
        estimates.iter().filter(stays).map(|(number, _)| *number).collect()
    }

    /// Numbers of the power moments and, from four functions, of the trigonometric ones: charts mark them.
    pub(crate) fn always(&self, order: usize) -> Vec<u32> {
        let subsets = &self.subsets[order];
        let members = self.workload.members;
        let size = subsets.order();
        let mut wanted = vec![self.workload.powers[..size].to_vec()];
        if size >= 4 && size.is_multiple_of(2) {
            wanted.push(self.workload.waves[..size].to_vec());
        }
        let number = |mut places: Vec<usize>| {
            places.sort_unstable();
            places.iter().all(|&place| place < members).then(|| subsets.number(&places) as u32)
        };
        wanted.into_iter().filter_map(number).collect()
    }
}
