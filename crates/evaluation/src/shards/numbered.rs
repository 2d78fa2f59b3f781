//! Work of one round whose pieces are numbered: views, cameras, families.

use super::{Finding, Gathered, Keep, Known, Pieces, gather};
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;

/// Pieces 0 to `count - 1`, done one after the other: each uses all threads.
struct Numbered<'a, F> {
    name: &'static str,
    costs: &'a [u64],
    find: &'a dyn Fn(usize) -> Result<F, EvaluationError>,
    context: &'a RunContext<'a>,
}

impl<F: Finding> Pieces for Numbered<'_, F> {
    type Key = usize;
    type Finding = F;

    fn name(&self) -> &'static str {
        self.name
    }

    fn keys(&self, _round: usize, _known: &Known<Self>) -> Vec<usize> {
        (0..self.costs.len()).collect()
    }

    fn cost(&self, key: &usize) -> u64 {
        self.costs.get(*key).copied().unwrap_or(1)
    }

    fn find(
        &self,
        keys: &[usize],
        (before, all): (usize, usize),
        keep: Keep<'_, Self>,
    ) -> Result<(), EvaluationError> {
        for (done, &number) in keys.iter().enumerate() {
            keep(vec![(number, (self.find)(number)?)])?;
            (self.context.progress)(before + done + 1, all);
        }
        Ok(())
    }
}

/// The findings of numbered pieces, in order. `costs` says how many there are, and what each costs beside the others.
pub(crate) fn numbered<F: Finding>(
    context: &RunContext<'_>,
    name: &'static str,
    costs: &[u64],
    find: &dyn Fn(usize) -> Result<F, EvaluationError>,
) -> Result<Gathered<Vec<F>>, EvaluationError> {
    let pieces = Numbered { name, costs, find, context };
    Ok(match gather(context, &context.identity, &pieces)? {
        Gathered::All(mut known) => {
            Gathered::All((0..costs.len()).filter_map(|number| known.remove(&number)).collect())
        }
        Gathered::Part(recorded) => Gathered::Part(recorded),
    })
}
