//! Experiments in parts, on one machine or many, that make the bytes of the whole.
//!
//! A kind says what its work consists of: [`Pieces`], in one round or several, where the pieces of a round follow from what the
//! rounds before it have found. [`gather`] does the rest alike for all kinds, whatever [`Task`] a run is given: all of it, a
//! shard, the selection of the pieces of a round, or the completion of what shards have found.

mod checkpoint;
mod deal;
mod folder;
mod numbered;
mod part;
mod raw;
mod sealed;
mod shard;
mod supply;

pub(crate) use checkpoint::FILE;
pub use folder::{RoundState, ranges, round_state};
pub(crate) use numbered::numbered;
pub(crate) use raw::Raw;
pub use shard::Shard;
pub(crate) use supply::{supplied, supply};

use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::run::Recorded;
use checkpoint::Checkpoint;
use folder::Folder;
use part::{Header, Writer};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::{HashMap, HashSet};
use std::hash::Hash;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// What pieces are called by.
pub(crate) trait Key: Copy + Eq + Hash + Ord + Send + Serialize + DeserializeOwned {}

impl<T: Copy + Eq + Hash + Ord + Send + Serialize + DeserializeOwned> Key for T {}

/// What is known of a piece of work.
pub(crate) trait Finding: Clone + Send + Serialize + DeserializeOwned {}

impl<T: Clone + Send + Serialize + DeserializeOwned> Finding for T {}

/// What is known, by piece.
pub(crate) type Known<P> = HashMap<<P as Pieces>::Key, <P as Pieces>::Finding>;

/// Takes findings as they come.
pub(crate) type Keep<'a, P> =
    &'a (dyn Fn(Vec<(<P as Pieces>::Key, <P as Pieces>::Finding)>) -> Result<(), EvaluationError> + Sync);

/// Work that can be divided.
pub(crate) trait Pieces {
    type Key: Key;
    type Finding: Finding;

    /// What pieces are called, in messages.
    fn name(&self) -> &'static str;

    /// Number of rounds.
    fn rounds(&self) -> usize {
        1
    }

    /// The pieces of a round, ascending; what the rounds before it have found is known.
    fn keys(&self, round: usize, known: &Known<Self>) -> Vec<Self::Key>
    where
        Self: Sized;

    /// What a piece costs beside the others of its round.
    fn cost(&self, _key: &Self::Key) -> u64 {
        1
    }

    /// Works on pieces of one round; how many were done before, and how many there are.
    fn find(
        &self,
        keys: &[Self::Key],
        done: (usize, usize),
        keep: Keep<'_, Self>,
    ) -> Result<(), EvaluationError>
    where
        Self: Sized;
}

/// What of an experiment is to be done.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) enum Task<'a> {
    /// All.
    #[default]
    Whole,
    /// A shard of the first round, whose findings stay in its run directory.
    Shard(Shard),
    /// What shards have found is to be completed: their run directories, or the folder that they shared.
    Merge { directories: &'a [PathBuf], patience: Duration },
    /// To work on one piece, for what it costs.
    Measure(&'a Mutex<Option<Measured>>),
    /// To write down the pieces of a round in the folder that shards share.
    Select { parts: &'a Path, round: usize, patience: Duration },
    /// A shard of a round, whose findings become a file in that folder.
    Part { parts: &'a Path, round: usize, shard: Shard, patience: Duration },
}

/// What one piece of the first round took, and how much more there is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Measured {
    pub(crate) pieces: usize,
    /// On all threads of the run.
    pub(crate) seconds: f64,
    /// Of its finding.
    pub(crate) bytes: usize,
    /// What it costs, the most expensive one, and all together.
    pub(crate) cost: [u64; 3],
}

/// All findings, or what a task leaves that was given less than all.
pub(crate) enum Gathered<T> {
    All(T),
    Part(Recorded),
}

fn part_of(pieces: usize) -> Recorded {
    Recorded { files: Vec::new(), trials: pieces, failed: 0, complete: false }
}

/// Does what the task of a run says. `inputs` is a hash of everything that findings depend on.
pub(crate) fn gather<P: Pieces>(
    context: &RunContext<'_>,
    inputs: &str,
    pieces: &P,
) -> Result<Gathered<Known<P>>, EvaluationError> {
    let mut known = HashMap::new();
    match context.task {
        Task::Whole => {
            let mut log =
                context.keeps_findings.then(|| open::<P>(context, inputs, &mut known)).transpose()?;
            complete(pieces, &mut known, &mut log)?;
        }
        Task::Shard(shard) => {
            let mut log = Some(open::<P>(context, inputs, &mut known)?);
            let keys = share(pieces, pieces.keys(0, &HashMap::new()), shard);
            known.retain(|key, _| keys.binary_search(key).is_ok());
            round(pieces, &keys, &mut known, &mut log)?;
            return Ok(Gathered::Part(part_of(keys.len())));
        }
        Task::Merge { directories, patience } => {
            let rounds = merge((directories, patience), inputs, pieces, &mut known)?;
            check(pieces, rounds, &mut known)?;
            let mut log =
                context.keeps_findings.then(|| open::<P>(context, inputs, &mut known)).transpose()?;
            complete(pieces, &mut known, &mut log)?;
        }
        Task::Measure(measured) => {
            let keys = pieces.keys(0, &HashMap::new());
            let found = measure(pieces, &keys)?;
            *measured.lock().unwrap_or_else(PoisonError::into_inner) = found;
            return Ok(Gathered::Part(part_of(keys.len())));
        }
        Task::Select { parts, round, patience } => {
            let folder = Folder { path: parts, patience };
            let keys = selected(pieces, &folder, inputs, round)?;
            folder.select::<P>(inputs, round, &keys)?;
            return Ok(Gathered::Part(part_of(keys.len())));
        }
        Task::Part { parts, round: number, shard, patience } => {
            let folder = Folder { path: parts, patience };
            let program = context.identity.clone();
            let header = Header { program, inputs: inputs.to_owned(), round: number, shard };
            let mut writer = Writer::create(&folder::of_round(parts, number), &header)?;
            let keys = match folder.selection::<P>(inputs, number)? {
                Some(keys) => keys,
                None => selected(pieces, &folder, inputs, number)?,
            };
            let keys = share(pieces, keys, shard);
            let shared = Mutex::new(&mut writer);
            let keep = |findings: Vec<(P::Key, P::Finding)>| {
                // A thread that panicked has left the file between two writes.
                shared.lock().unwrap_or_else(PoisonError::into_inner).append(&findings)
            };
            pieces.find(&keys, (0, keys.len()), &keep)?;
            writer.finish(context.started.elapsed().as_secs_f64(), rayon::current_num_threads())?;
            return Ok(Gathered::Part(part_of(keys.len())));
        }
    }
    Ok(Gathered::All(known))
}

/// Works on a piece of middling cost.
fn measure<P: Pieces>(pieces: &P, keys: &[P::Key]) -> Result<Option<Measured>, EvaluationError> {
    let mut costs: Vec<(u64, P::Key)> = keys.iter().map(|key| (pieces.cost(key), *key)).collect();
    costs.sort_unstable();
    let (Some(&(cost, key)), Some(&(most, _))) = (costs.get(costs.len() / 2), costs.last()) else {
        return Ok(None);
    };
    let bytes = Mutex::new(0);
    let keep = |findings: Vec<(P::Key, P::Finding)>| {
        let written = findings.iter().map(|(key, finding)| sealed::written(key, finding).len());
        *bytes.lock().unwrap_or_else(PoisonError::into_inner) += written.sum::<usize>();
        Ok(())
    };
    let clock = Instant::now();
    pieces.find(&[key], (0, 1), &keep)?;
    Ok(Some(Measured {
        pieces: keys.len(),
        seconds: clock.elapsed().as_secs_f64(),
        bytes: bytes.into_inner().unwrap_or_else(PoisonError::into_inner),
        cost: [cost, most, costs.iter().map(|(cost, _)| cost).sum()],
    }))
}

/// The pieces in the file of a shard, if it has been there before: then nothing needs to be prepared.
///
/// # Errors
/// [`EvaluationError::Input`] if the file is of another program or experiment, which nobody asked to replace.
pub(crate) fn already_there(context: &RunContext<'_>) -> Result<Option<Recorded>, EvaluationError> {
    match context.task {
        Task::Part { parts, round, shard, patience } => {
            let found = Folder { path: parts, patience }.found(&context.identity, round, shard)?;
            Ok(found.map(part_of))
        }
        Task::Whole | Task::Shard(_) | Task::Merge { .. } | Task::Measure(_) | Task::Select { .. } => {
            Ok(None)
        }
    }
}

/// The pieces of a round from what is known in the folder.
fn selected<P: Pieces>(
    pieces: &P,
    folder: &Folder<'_>,
    inputs: &str,
    round: usize,
) -> Result<Vec<P::Key>, EvaluationError> {
    if round >= pieces.rounds() {
        let reason = format!("round {round} is none of {} that are counted from 0", pieces.rounds());
        return Err(EvaluationError::Value(reason));
    }
    let mut known = HashMap::new();
    for earlier in 0..round {
        folder.round::<P>(inputs, earlier, &mut known)?;
    }
    check(pieces, round, &mut known)?;
    Ok(pieces.keys(round, &known))
}

/// The pieces of a shard, ascending.
fn share<P: Pieces>(pieces: &P, keys: Vec<P::Key>, shard: Shard) -> Vec<P::Key> {
    let costs: Vec<u64> = keys.iter().map(|key| pieces.cost(key)).collect();
    let places = deal::dealt(&costs, shard.count);
    places[shard.index - 1].iter().map(|&place| keys[place]).collect()
}

/// Refuses to go on while something is unknown in the first rounds, and forgets what does not belong to them.
fn check<P: Pieces>(pieces: &P, rounds: usize, known: &mut Known<P>) -> Result<(), EvaluationError> {
    let mut needed: HashSet<P::Key> = HashSet::new();
    for round in 0..rounds {
        let keys = pieces.keys(round, known);
        let missing = keys.iter().filter(|key| !known.contains_key(key)).count();
        if missing > 0 {
            let reason = format!(
                "{missing} of {} {} are in none of the merged shards: resume the unfinished ones first",
                keys.len(),
                pieces.name()
            );
            return Err(EvaluationError::Value(reason));
        }
        needed.extend(keys);
    }
    known.retain(|key, _| needed.contains(key));
    Ok(())
}

/// Does what is not known yet, round by round.
fn complete<P: Pieces>(
    pieces: &P,
    known: &mut Known<P>,
    log: &mut Option<Checkpoint>,
) -> Result<(), EvaluationError> {
    for number in 0..pieces.rounds() {
        let keys = pieces.keys(number, known);
        round(pieces, &keys, known, log)?;
    }
    Ok(())
}

fn round<P: Pieces>(
    pieces: &P,
    keys: &[P::Key],
    known: &mut Known<P>,
    log: &mut Option<Checkpoint>,
) -> Result<(), EvaluationError> {
    let missing: Vec<P::Key> = keys.iter().filter(|key| !known.contains_key(*key)).copied().collect();
    let found = Mutex::new((Vec::new(), log));
    let keep = |findings: Vec<(P::Key, P::Finding)>| {
        // A thread that panicked has left both between two writes.
        let mut found = found.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(log) = &mut *found.1 {
            log.append(&findings)?;
        }
        found.0.extend(findings);
        Ok(())
    };
    pieces.find(&missing, (keys.len() - missing.len(), keys.len()), &keep)?;
    let (found, log) = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    known.extend(found);
    log.as_ref().map_or(Ok(()), Checkpoint::sync)
}

/// Opens the checkpoint of a run, with what it holds.
fn open<P: Pieces>(
    context: &RunContext<'_>,
    inputs: &str,
    known: &mut Known<P>,
) -> Result<Checkpoint, EvaluationError> {
    let path = context.directory.join(FILE);
    let shard = match context.task {
        Task::Shard(shard) => shard,
        Task::Whole | Task::Merge { .. } | Task::Measure(_) | Task::Select { .. } | Task::Part { .. } => {
            Shard::WHOLE
        }
    };
    if path.exists() && std::fs::metadata(&path).is_ok_and(|data| data.len() > 0) {
        let loaded = checkpoint::load::<P>(&path, inputs)?;
        if loaded.shard != shard {
            let reason = format!("holds shard {}, not {shard}", loaded.shard);
            return Err(EvaluationError::Input { path, reason });
        }
        let checkpoint = Checkpoint::resume(&path, &loaded)?;
        known.extend(loaded.findings);
        return Ok(checkpoint);
    }
    // Left by a run that was killed before its first write.
    let _ = std::fs::remove_file(&path);
    let mut checkpoint = Checkpoint::create(&path, inputs, shard)?;
    let mut merged: Vec<(P::Key, P::Finding)> =
        known.iter().map(|(key, finding)| (*key, finding.clone())).collect();
    merged.sort_by_key(|(key, _)| *key);
    checkpoint.append(&merged)?;
    Ok(checkpoint)
}

/// Reads the findings of all shards of one experiment; how many rounds they must cover.
fn merge<P: Pieces>(
    (directories, patience): (&[PathBuf], Duration),
    inputs: &str,
    pieces: &P,
    known: &mut Known<P>,
) -> Result<usize, EvaluationError> {
    if let [path] = directories
        && folder::of_round(path, 0).is_dir()
    {
        for round in 0..pieces.rounds() {
            Folder { path, patience }.round::<P>(inputs, round, known)?;
        }
        return Ok(pieces.rounds());
    }
    let mut seen: Vec<Shard> = Vec::new();
    for directory in directories {
        let path = directory.join(FILE);
        let loaded = checkpoint::load::<P>(&path, inputs)?;
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
    Ok(1)
}

#[cfg(test)]
mod tests;
