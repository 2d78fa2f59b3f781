//! What every shard would compute anew, computed once by the selection before the first round and read by those who need it.

use super::Task;
use super::folder::Folder;
use super::sealed::foreign;
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::run_directory::write_whole;
use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use std::path::PathBuf;

const MAGIC: &[u8; 16] = b"msm supply 0001\n";

/// Bytes of a hash.
const HASH: usize = 32;

/// What stands before the content: magic, hash of the inputs as text, hash of the content.
const BEFORE: usize = MAGIC.len() + 2 * HASH + HASH;

fn path(context: &RunContext<'_>, name: &str) -> Option<PathBuf> {
    match context.task {
        Task::Select { parts, .. } | Task::Part { parts, .. } => Some(parts.join(format!("{name}.supply"))),
        Task::Whole | Task::Shard(_) | Task::Merge { .. } | Task::Measure(_) => None,
    }
}

/// Writes something down for all shards of this program and experiment.
pub(crate) fn supply<T: Serialize>(
    context: &RunContext<'_>,
    name: &str,
    content: &T,
) -> Result<(), EvaluationError> {
    let Some(path) = path(context, name) else { return Ok(()) };
    let mut bytes = vec![0; BEFORE];
    ciborium::into_writer(content, &mut bytes)
        .map_err(|error| EvaluationError::Table { table: name.to_owned(), reason: error.to_string() })?;
    let hash = Sha256::digest(&bytes[BEFORE..]);
    bytes[..MAGIC.len()].copy_from_slice(MAGIC);
    bytes[MAGIC.len()..BEFORE - HASH].copy_from_slice(context.identity.as_bytes());
    bytes[BEFORE - HASH..BEFORE].copy_from_slice(&hash);
    if let Some(folder) = path.parent() {
        let fail = |source| EvaluationError::Write { path: folder.to_owned(), source };
        std::fs::create_dir_all(folder).map_err(fail)?;
    }
    write_whole(&path, &bytes)
}

/// What was written down, where it was.
pub(crate) fn supplied<T: DeserializeOwned>(
    context: &RunContext<'_>,
    name: &str,
) -> Result<Option<T>, EvaluationError> {
    let Some(path) = path(context, name) else { return Ok(None) };
    if let Task::Select { parts, patience, .. } | Task::Part { parts, patience, .. } = context.task {
        Folder { path: parts, patience }.await_supply(&path);
    }
    if !path.exists() {
        return Ok(None);
    }
    let fail = |reason: String| EvaluationError::Input { path: path.clone(), reason };
    let bytes = std::fs::read(&path).map_err(|error| fail(error.to_string()))?;
    let damaged = || fail("is damaged or truncated: select round 0 again".to_owned());
    let (before, content) = bytes.split_at_checked(BEFORE).ok_or_else(damaged)?;
    let theirs = std::str::from_utf8(&before[MAGIC.len()..BEFORE - HASH]).map_err(|_| damaged())?;
    if !before.starts_with(MAGIC) || Sha256::digest(content)[..] != before[BEFORE - HASH..] {
        return Err(damaged());
    }
    if theirs != context.identity {
        return Err(fail(foreign(theirs, &context.identity)));
    }
    ciborium::from_reader(content).map(Some).map_err(|error| fail(error.to_string()))
}
