//! One candidate on one block.

use super::statistics::{Mean, Moments, stratified};
use super::workload::{Block, Workload};
use moment_problem::fast_simplex::FastSolution;

/// What a block says about a candidate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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

/// |G - F| of one basis on the fragments of a block, in their order.
pub(crate) fn errors(block: &Block, solution: &FastSolution) -> Vec<f64> {
    let pairs = solution.bounds.iter().zip(&block.entries);
    pairs.map(|(bound, entry)| (bound.lower - entry.reference).abs()).collect()
}

/// Compares a solution with the control's errors on the same block.
pub(crate) fn judge(workload: &Workload, block: &Block, solution: &FastSolution, control: &[f64]) -> Verdict {
    let views = workload.views.len();
    let mut differences = vec![Moments::default(); views];
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
        programs: solution.bounds.len() as u32,
        exact: solution.exact as u32,
        uncertified: solution.uncertified.len() as u32,
    }
}
