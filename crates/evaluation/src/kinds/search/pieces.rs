//! The candidates as pieces of work: all on the first block, the best on the later ones, a round each.

use super::card::{CardSweep, TOGETHER};
use super::judge::{Finding, Key};
use super::sweep::Sweep;
use crate::error::EvaluationError;
use crate::run::Progress;
use crate::shards::{Keep, Known, Pieces};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Candidates between two writes: a fraction of a second's work.
const CHUNK: usize = 32;

/// Candidates on blocks.
pub(crate) struct SearchPieces<'a> {
    pub(crate) sweep: &'a Sweep<'a>,
    pub(crate) card: Option<&'a CardSweep<'a>>,
    pub(crate) progress: Progress<'a>,
}

impl Pieces for SearchPieces<'_> {
    type Key = Key;
    type Finding = Finding;

    fn name(&self) -> &'static str {
        "candidates"
    }

    fn rounds(&self) -> usize {
        self.sweep.workload.blocks.len()
    }

    fn keys(&self, round: usize, known: &Known<Self>) -> Vec<Key> {
        if round == 0 {
            return self.sweep.first_keys();
        }
        let of_order = |order: usize| {
            let kept = self.sweep.survivors(known, round, order);
            kept.into_iter().map(move |number| (round as u16, order as u16, number))
        };
        (0..self.sweep.subsets.len()).flat_map(of_order).collect()
    }

    /// A pivot touches all rows of a basis for each of its columns.
    fn cost(&self, &(_, order, _): &Key) -> u64 {
        let rows = self.sweep.subsets[usize::from(order)].order() as u64 + 1;
        rows * rows
    }

    fn find(
        &self,
        keys: &[Key],
        (before, all): (usize, usize),
        keep: Keep<'_, Self>,
    ) -> Result<(), EvaluationError> {
        let done = AtomicUsize::new(before);
        let count = |more: usize| (self.progress)(done.fetch_add(more, Ordering::Relaxed) + more, all);
        let mut rest = keys.to_vec();
        // The card knows the first block only.
        if let Some(card) = self.card.filter(|_| keys.first().is_some_and(|key| key.0 == 0)) {
            let (served, others): (Vec<Key>, Vec<Key>) = keys.iter().partition(|key| card.serves(key));
            on_card(card, &served, &count, keep)?;
            rest = others;
        }
        // Small shards are for all threads, too.
        let chunk = CHUNK.min(rest.len().div_ceil(4 * rayon::current_num_threads())).max(1);
        rest.par_chunks(chunk).try_for_each(|part| {
            let mut findings = Vec::with_capacity(part.len());
            for &(block, order, number) in part {
                let finding = self.sweep.find(block.into(), order.into(), number);
                findings.push(((block, order, number), finding));
                count(1);
            }
            keep(findings)
        })
    }
}

/// Judges candidates on the card, one batch there while the CPU is busy with the one before.
fn on_card(
    card: &CardSweep<'_>,
    keys: &[Key],
    count: &(dyn Fn(usize) + Sync),
    keep: Keep<'_, SearchPieces<'_>>,
) -> Result<(), EvaluationError> {
    let finish = |pending| -> Result<(), EvaluationError> {
        let findings = card.finish(pending)?;
        let done = findings.len();
        keep(findings)?;
        count(done);
        Ok(())
    };
    let mut waiting = None;
    for batch in keys.chunks(TOGETHER) {
        let next = card.submit(batch)?;
        waiting.replace(next).map_or(Ok(()), finish)?;
    }
    waiting.map_or(Ok(()), finish)
}
