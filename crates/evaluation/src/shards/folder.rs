//! The folder that shards share: a folder a round, with the pieces that were selected for it and a file for each shard.

use super::part::{self, Cost, Part};
use super::sealed::{foreign, sealed, unsealed};
use super::{Pieces, Shard};
use crate::error::EvaluationError;
use crate::provenance::sha256;
use crate::run_directory::write_whole;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// Name of a round's selection.
const SELECTION: &str = "pieces.txt";

const MAGIC: &str = "msm pieces 1";

/// Between two looks at a folder that may show files late.
const LOOK_AGAIN: Duration = Duration::from_millis(500);

/// Rounds of one experiment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Folder<'a> {
    pub(super) path: &'a Path,
    /// How long files may take to show.
    pub(super) patience: Duration,
}

/// A round as the files tell it.
#[derive(Clone, Debug, Default)]
pub struct RoundState {
    /// Whether its pieces have been selected, and how many there are.
    pub selected: Option<usize>,
    /// Finished shards with pieces, seconds and threads of each.
    pub done: BTreeMap<usize, (usize, f64, usize)>,
    /// Unfinished shards that gave a sign of life within the last minute.
    pub running: Vec<usize>,
    /// Files that are not to be believed, and why.
    pub faults: Vec<(PathBuf, String)>,
}

/// Folder of a round.
pub(super) fn of_round(parts: &Path, round: usize) -> PathBuf {
    parts.join(format!("round-{round}"))
}

/// Finished files of a round by their names, unread.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let is_part = |path: &PathBuf| path.extension().is_some_and(|ending| ending == part::ENDING);
    let mut files: Vec<PathBuf> = paths.filter(is_part).collect();
    files.sort();
    files
}

impl Folder<'_> {
    /// Waits until a condition holds or patience ends: shared folders show files late.
    fn await_that(&self, holds: impl Fn() -> bool) {
        let clock = Instant::now();
        while !holds() && clock.elapsed() < self.patience {
            std::thread::sleep(LOOK_AGAIN);
        }
    }

    /// Waits for what the selection of the first round has written, if there was one.
    pub(super) fn await_supply(&self, path: &Path) {
        let is_selected = of_round(self.path, 0).join(SELECTION).exists();
        self.await_that(|| !is_selected || path.exists());
    }

    /// The pieces of a shard whose file is there. A damaged file is put aside, one of another program refused.
    pub(super) fn found(
        &self,
        program: &str,
        round: usize,
        shard: Shard,
    ) -> Result<Option<usize>, EvaluationError> {
        let path = of_round(self.path, round).join(part::name(shard));
        let Ok(bytes) = std::fs::read(&path) else { return Ok(None) };
        match Part::parse(&String::from_utf8_lossy(&bytes)) {
            Ok(Part { header, .. }) if header.program != program => {
                let reason = foreign(&header.program, program);
                Err(EvaluationError::Input { path, reason })
            }
            Ok(found) => Ok(Some(found.cost.pieces)),
            Err(_) => {
                let aside = path.with_extension("part.damaged");
                std::fs::rename(&path, &aside)
                    .map_err(|source| EvaluationError::Write { path: aside, source })?;
                Ok(None)
            }
        }
    }

    /// What all shards of a round have found.
    pub(super) fn round<P: Pieces>(
        &self,
        inputs: &str,
        round: usize,
        known: &mut HashMap<P::Key, P::Finding>,
    ) -> Result<(), EvaluationError> {
        let folder = of_round(self.path, round);
        self.await_that(|| {
            let files = files(&folder);
            let shard = files.first().and_then(|path| part::shard_of(path.file_name()?.to_str()?));
            shard.is_some_and(|shard| files.len() >= shard.count)
        });
        let mut seen: Vec<(Shard, PathBuf)> = Vec::new();
        for path in files(&folder) {
            let fail = |reason: String| EvaluationError::Input { path: path.clone(), reason };
            let text = std::fs::read_to_string(&path).map_err(|error| fail(error.to_string()))?;
            let found = Part::parse(&text).map_err(fail)?;
            found.header.check(inputs, round).map_err(fail)?;
            let shard = found.header.shard;
            if let Some((_, other)) = seen.iter().find(|(other, _)| *other == shard) {
                let other = other.file_name().unwrap_or_default().to_string_lossy().into_owned();
                return Err(fail(format!("is shard {shard} of round {round} once more, beside {other}")));
            }
            if let Some((first, _)) = seen.first().filter(|(first, _)| first.count != shard.count) {
                return Err(fail(format!("is shard {shard} of round {round}, another one is {first}")));
            }
            known.extend(found.findings::<P>().map_err(fail)?);
            seen.push((shard, path));
        }
        let count = seen.first().map_or(0, |(shard, _)| shard.count);
        let is_there = |index: usize| seen.iter().any(|(shard, _)| shard.index == index);
        let missing: Vec<usize> = (1..=count).filter(|&index| !is_there(index)).collect();
        let reason = match (count, missing.is_empty()) {
            (0, _) => {
                format!("has no shard of round {round} yet: files that end in .{} are wanted", part::ENDING)
            }
            (_, false) => format!(
                "of round {round}, {} of {count} shards are missing: {}",
                missing.len(),
                ranges(&missing)
            ),
            (_, true) => return Ok(()),
        };
        Err(EvaluationError::Input { path: folder, reason })
    }

    /// Writes down what a round is made of.
    pub(super) fn select<P: Pieces>(
        &self,
        inputs: &str,
        round: usize,
        keys: &[P::Key],
    ) -> Result<(), EvaluationError> {
        let folder = of_round(self.path, round);
        let fail = |source| EvaluationError::Write { path: folder.clone(), source };
        std::fs::create_dir_all(&folder).map_err(fail)?;
        let mut lines = String::new();
        for key in keys {
            // Keys are numbers.
            lines += &serde_json::to_string(key).unwrap_or_default();
            lines.push('\n');
        }
        let (count, hash) = (keys.len(), sha256(lines.as_bytes()));
        let text =
            sealed(&format!("{MAGIC} inputs {inputs} round {round} pieces {count} sha256 {hash}")) + &lines;
        write_whole(&folder.join(SELECTION), text.as_bytes())
    }

    /// The pieces of a round, where they have been written down.
    pub(super) fn selection<P: Pieces>(
        &self,
        inputs: &str,
        round: usize,
    ) -> Result<Option<Vec<P::Key>>, EvaluationError> {
        let path = of_round(self.path, round).join(SELECTION);
        if round > 0 {
            self.await_that(|| path.exists());
        }
        let Ok(text) = std::fs::read_to_string(&path) else { return Ok(None) };
        let fail = |reason: String| EvaluationError::Input { path: path.clone(), reason };
        let (head, lines) = text.split_once('\n').unwrap_or((&text, ""));
        let (theirs, count, hash) =
            selected(head).ok_or_else(|| fail(format!("line 1 is not `{MAGIC} ...`")))?;
        if theirs != inputs {
            return Err(fail(foreign(&theirs, inputs)));
        }
        if sha256(lines.as_bytes()) != hash {
            let reason = format!(
                "is damaged or truncated: {} of {count} lines; select the round again",
                lines.lines().count()
            );
            return Err(fail(reason));
        }
        let key = |(number, line): (usize, &str)| {
            serde_json::from_str(line).map_err(|_| fail(format!("line {} is no piece", number + 2)))
        };
        let keys: Vec<P::Key> = lines.lines().enumerate().map(key).collect::<Result<_, _>>()?;
        Ok(Some(keys))
    }
}

/// Inputs, number of pieces and hash of their lines, from the first line of a selection.
fn selected(head: &str) -> Option<(String, usize, String)> {
    let words: Vec<&str> = unsealed(head)?.strip_prefix(MAGIC)?.split_whitespace().collect();
    let ["inputs", inputs, "round", _, "pieces", count, "sha256", hash] = words[..] else { return None };
    Some((inputs.to_owned(), count.parse().ok()?, hash.to_owned()))
}

/// What the files of a round tell about `shards` shards, without knowing their experiment.
pub fn round_state(parts: &Path, round: usize, shards: usize) -> RoundState {
    let folder = of_round(parts, round);
    let (mut state, mut inputs) = (RoundState::default(), None);
    if let Ok(text) = std::fs::read_to_string(folder.join(SELECTION)) {
        match selected(text.lines().next().unwrap_or_default()) {
            Some((of, count, _)) => (inputs, state.selected) = (Some(of), Some(count)),
            None => state.faults.push((folder.join(SELECTION), "line 1 is damaged".to_owned())),
        }
    }
    for path in files(&folder) {
        let found = std::fs::read_to_string(&path).map_err(|error| error.to_string());
        let checked = found.as_deref().map_err(Clone::clone).and_then(|text| {
            let Part { header, cost, .. } = Part::parse(text)?;
            header.check(inputs.get_or_insert(header.inputs.clone()), round)?;
            if header.shard.count != shards {
                return Err(format!("is shard {}, wanted are {shards}", header.shard));
            }
            if state.done.contains_key(&header.shard.index) {
                return Err(format!("is shard {} once more", header.shard));
            }
            Ok((header.shard.index, cost))
        });
        match checked {
            Ok((index, Cost { pieces, seconds, threads })) => {
                state.done.insert(index, (pieces, seconds, threads));
            }
            Err(reason) => state.faults.push((path, reason)),
        }
    }
    let entries = std::fs::read_dir(&folder).into_iter().flatten().filter_map(Result::ok);
    for entry in entries {
        let name = entry.file_name().to_string_lossy().into_owned();
        let Some(shard) = part::shard_of(&name).filter(|_| name.ends_with(part::UNFINISHED)) else {
            continue;
        };
        let touched = entry.metadata().and_then(|data| data.modified()).unwrap_or(SystemTime::UNIX_EPOCH);
        let silent = SystemTime::now().duration_since(touched).unwrap_or_default();
        let is_new = !state.done.contains_key(&shard.index) && !state.running.contains(&shard.index);
        if silent < part::SILENCE && is_new && shard.count == shards {
            state.running.push(shard.index);
        }
    }
    state.running.sort_unstable();
    state
}

/// Numbers as Slurm writes them: `1-3,7`.
pub fn ranges(numbers: &[usize]) -> String {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for &number in numbers {
        match runs.last_mut().filter(|run| run.1 + 1 == number) {
            Some(run) => run.1 = number,
            None => runs.push((number, number)),
        }
    }
    let run = |&(first, last): &(usize, usize)| {
        if first == last { first.to_string() } else { format!("{first}-{last}") }
    };
    runs.iter().map(run).collect::<Vec<_>>().join(",")
}
