//! Experiments in parts: what a shard finds goes to a file of its run directory, and all of these make the whole.
//!
//! A kind divides its work into numbered pieces and says how the [`Finding`] of a piece is written on a line; shards,
//! checksums, going on after a kill and merging are the same for all kinds.

mod checkpoint;

pub(crate) use checkpoint::{Checkpoint, FILE};

use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use std::collections::{HashMap, HashSet};
use std::hash::Hash;
use std::path::PathBuf;

/// What is known of a piece of work.
pub(crate) trait Finding: Clone {
    /// What pieces are called, in messages.
    const PIECES: &'static str;

    /// Names the piece.
    type Key: Copy + Eq + Hash + Ord;

    /// On one line, exactly.
    fn line(&self, key: &Self::Key) -> String;

    /// Back from a line.
    fn parse(content: &str) -> Option<(Self::Key, Self)>;
}

/// Part of what an experiment divides its work into: `index` of `count`, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// 1 to `count`.
    pub index: usize,
    /// Number of parts.
    pub count: usize,
}

impl Shard {
    /// Everything.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// Whether a piece of work of this number belongs to it.
    pub(crate) fn contains(&self, number: usize) -> bool {
        number % self.count == self.index - 1
    }
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let fail = || format!("`{text}` is no shard: write i/N with i from 1 to N, such as 2/4");
        let (index, count) = text.split_once('/').ok_or_else(fail)?;
        let (index, count) = (index.parse().map_err(|_| fail())?, count.parse().map_err(|_| fail())?);
        if !(1..=count).contains(&index) {
            return Err(fail());
        }
        Ok(Self { index, count })
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

/// The findings so far by their keys, and where the next ones go.
pub(crate) type Opened<F> = (HashMap<<F as Finding>::Key, F>, Checkpoint);

/// Opens the checkpoint of a run, with what it holds and what shards to be merged have found. `inputs` is a hash of
/// everything that findings depend on; `needed` are the pieces that shards have to cover.
pub(crate) fn open<F: Finding>(
    context: &RunContext<'_>,
    inputs: &str,
    needed: impl FnOnce() -> Vec<F::Key>,
) -> Result<Opened<F>, EvaluationError> {
    let mut known = HashMap::new();
    if !context.merge.is_empty() {
        merge(context.merge, inputs, &mut known)?;
        let needed: HashSet<F::Key> = needed().into_iter().collect();
        known.retain(|key, _| needed.contains(key));
        if known.len() < needed.len() {
            let reason = format!(
                "{} of {} {} are in none of the merged shards: resume the unfinished ones first",
                needed.len() - known.len(),
                needed.len(),
                F::PIECES
            );
            return Err(EvaluationError::Value(reason));
        }
    }
    let path = context.directory.join(FILE);
    let shard = context.shard.unwrap_or(Shard::WHOLE);
    if path.exists() && std::fs::metadata(&path).is_ok_and(|data| data.len() > 0) {
        let loaded = checkpoint::load(&path, inputs)?;
        if loaded.shard != shard {
            let reason = format!("holds shard {}, not {shard}", loaded.shard);
            return Err(EvaluationError::Input { path, reason });
        }
        let checkpoint = Checkpoint::resume(&path, &loaded)?;
        known.extend(loaded.findings);
        return Ok((known, checkpoint));
    }
    // Left by a run that was killed before its first write.
    let _ = std::fs::remove_file(&path);
    let mut checkpoint = Checkpoint::create(&path, inputs, shard)?;
    let mut merged: Vec<(F::Key, F)> = known.iter().map(|(key, finding)| (*key, finding.clone())).collect();
    merged.sort_by_key(|(key, _)| *key);
    checkpoint.append(&merged)?;
    Ok((known, checkpoint))
}

/// Reads the findings of all shards of one experiment.
fn merge<F: Finding>(
    directories: &[PathBuf],
    inputs: &str,
    known: &mut HashMap<F::Key, F>,
) -> Result<(), EvaluationError> {
    let mut seen: Vec<Shard> = Vec::new();
    for directory in directories {
        let path = directory.join(FILE);
        let loaded = checkpoint::load::<F>(&path, inputs)?;
        let fail = |reason: String| EvaluationError::Input { path: path.clone(), reason };
        if seen.contains(&loaded.shard) {
            return Err(fail(format!("is shard {} once more", loaded.shard)));
        }
        if let Some(first) = seen.first()
            && first.count != loaded.shard.count
        {
            return Err(fail(format!("is shard {}, the first one was {first}", loaded.shard)));
        }
        seen.push(loaded.shard);
        known.extend(loaded.findings);
    }
    let count = seen.first().map_or(0, |shard| shard.count);
    if let Some(index) = (1..=count).find(|&index| !seen.iter().any(|shard| shard.index == index)) {
        return Err(EvaluationError::Value(format!(
            "shard {index}/{count} is missing among those to be merged"
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_divide_the_candidates() {
        let shards: Vec<Shard> = ["1/3", "2/3", "3/3"].map(|text| text.parse().unwrap()).into();
        for number in 0..20 {
            assert_eq!(shards.iter().filter(|shard| shard.contains(number)).count(), 1);
        }
        for text in ["0/3", "4/3", "1/0", "x", "1/2/3", "-1/2", ""] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
