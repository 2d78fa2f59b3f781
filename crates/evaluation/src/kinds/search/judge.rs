//! One candidate on one block.

use super::block::Block;
use super::workload::Workload;
use crate::statistics::{Mean, Running, stratified};
use moment_problem::fast_simplex::FastSolution;
use moment_problem::lane_simplex::BatchSolution;
use serde::{Deserialize, Serialize};

/// What a block says about a candidate.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub(crate) struct Verdict {
    /// Mean of |G - F|.
    pub(crate) error: f64,
    /// Mean of the difference to the control's |G - F|, with its sampling variance.
    pub(crate) difference: Mean,
    /// Linear programs solved.
    pub(crate) programs: u32,
    /// Of these, programs that the double-double route decided.
    pub(crate) exact: u32,
    /// Programs that nobody could certify.
    pub(crate) uncertified: u32,
}

/// What a solver says about a block, whichever it was.
pub(crate) struct Solved {
    /// G.
    pub(crate) lower: Vec<f64>,
    /// What is proved.
    pub(crate) proved: Vec<f64>,
    exact: usize,
    pub(crate) uncertified: usize,
}

impl From<&FastSolution> for Solved {
    fn from(solution: &FastSolution) -> Self {
        Self {
            lower: solution.bounds.iter().map(|bound| bound.lower).collect(),
            proved: solution.bounds.iter().map(|bound| bound.lower_proved).collect(),
            exact: solution.exact,
            uncertified: solution.uncertified.len(),
        }
    }
}

impl From<BatchSolution> for Solved {
    fn from(solution: BatchSolution) -> Self {
        let BatchSolution { lower, proved, exact, uncertified, .. } = solution;
        Self { lower, proved, exact, uncertified: uncertified.len() }
    }
}

/// |G - F| of one basis on the fragments of a block, in their order.
pub(crate) fn errors(block: &Block, solution: &Solved) -> Vec<f64> {
    let pairs = solution.lower.iter().zip(&block.entries);
    pairs.map(|(lower, entry)| (lower - entry.reference).abs()).collect()
}

/// Compares a solution with the control's errors on the same block.
pub(crate) fn judge(workload: &Workload, block: &Block, solution: &Solved, control: &[f64]) -> Verdict {
    let views = workload.views.len();
    let mut differences = vec![Running::default(); views];
    let mut sums = block.idle.clone();
    let mut seen = vec![0u32; views];
    for (i, error) in errors(block, solution).into_iter().enumerate() {
        let entry = &block.entries[i];
        let view = usize::from(entry.view);
        let count = f64::from(entry.count);
        differences[view].add_repeated(error - control[i], count);
        sums[view] += count * error;
        seen[view] += entry.count;
    }
    for view in 0..views {
        // Where F_Z = 0 every basis has the same error.
        let idle = block.sampled[view] - seen[view];
        if idle > 0 {
            differences[view].add_repeated(0.0, f64::from(idle));
        }
    }
    let all: Vec<usize> = workload.views.iter().map(|view| view.fragments).collect();
    let mean = |view: usize| sums[view] / f64::from(block.sampled[view].max(1));
    Verdict {
        error: (0..views).map(mean).sum::<f64>() / views as f64,
        difference: stratified(&differences, &all),
        programs: solution.lower.len() as u32,
        exact: solution.exact as u32,
        uncertified: solution.uncertified as u32,
    }
}

/// Which verdict: block, order, number of the subset.
pub(crate) type Key = (u16, u16, u32);

/// What was found about a candidate on a block.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub(crate) struct Finding {
    pub(crate) verdict: Verdict,
    /// Bit i: the i-th function of the candidate depends on those before it and was left out.
    pub(crate) dropped: u16,
}

impl Finding {
    /// Nothing is left of the candidate.
    pub(crate) fn is_rejected(&self, order: usize) -> bool {
        self.dropped.count_ones() as usize == order
    }
}
