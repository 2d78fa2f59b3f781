//! An append-only file of findings: what a killed run has found is not computed again.
//!
//! One line a finding, ended by a checksum. The first line names the inputs. A last line without its end was being written when
//! the run was killed and is dropped; any other damage is an error, and nothing is changed.

use super::sealed::{foreign, read, sealed, unsealed, written};
use super::{Pieces, Shard};
use crate::error::EvaluationError;
use serde::Serialize;
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// File name within a run directory.
pub(crate) const FILE: &str = "checkpoint.log";

const MAGIC: &str = "msm findings, checkpoint 3";

/// The findings of a file and where its valid part ends.
pub(super) struct Loaded<P: Pieces> {
    pub(super) shard: Shard,
    pub(super) findings: HashMap<P::Key, P::Finding>,
    length: u64,
}

/// An open checkpoint.
pub(super) struct Checkpoint {
    path: PathBuf,
    file: File,
}

impl Checkpoint {
    /// Starts a file.
    pub(super) fn create(path: &Path, inputs: &str, shard: Shard) -> Result<Self, EvaluationError> {
        let fail = |source| EvaluationError::Write { path: path.to_owned(), source };
        let file = OpenOptions::new().append(true).create_new(true).open(path).map_err(fail)?;
        let mut checkpoint = Self { path: path.to_owned(), file };
        checkpoint.write(&sealed(&format!("{MAGIC} inputs {inputs} shard {shard}")))?;
        Ok(checkpoint)
    }

    /// Goes on with a file, without what follows its last whole line.
    pub(super) fn resume<P: Pieces>(path: &Path, loaded: &Loaded<P>) -> Result<Self, EvaluationError> {
        let fail = |source| EvaluationError::Write { path: path.to_owned(), source };
        let file = OpenOptions::new().append(true).open(path).map_err(fail)?;
        file.set_len(loaded.length).map_err(fail)?;
        Ok(Self { path: path.to_owned(), file })
    }

    /// Appends findings with one write.
    pub(super) fn append<K: Serialize, F: Serialize>(
        &mut self,
        findings: &[(K, F)],
    ) -> Result<(), EvaluationError> {
        let text: String = findings.iter().map(|(key, finding)| written(key, finding)).collect();
        self.write(&text)
    }

    fn write(&mut self, text: &str) -> Result<(), EvaluationError> {
        let fail = |source| EvaluationError::Write { path: self.path.clone(), source };
        self.file.write_all(text.as_bytes()).map_err(fail)
    }

    /// Makes sure that everything has reached the disk.
    pub(super) fn sync(&self) -> Result<(), EvaluationError> {
        let fail = |source| EvaluationError::Write { path: self.path.clone(), source };
        self.file.sync_data().map_err(fail)
    }
}

/// Reads a file that was written for these inputs.
pub(super) fn load<P: Pieces>(path: &Path, inputs: &str) -> Result<Loaded<P>, EvaluationError> {
    let fail = |reason: String| EvaluationError::Input { path: path.to_owned(), reason };
    let bytes = std::fs::read(path).map_err(|error| fail(error.to_string()))?;
    let end = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
    let text = std::str::from_utf8(&bytes[..end])
        .map_err(|error| fail(format!("is damaged after byte {}: no text", error.valid_up_to())))?;
    let mut lines = text.lines().enumerate();
    let header = lines.next().ok_or_else(|| fail("is empty: no whole line was written".to_owned()))?.1;
    let header = unsealed(header).ok_or_else(|| fail("line 1 is damaged: wrong checksum".to_owned()))?;
    let rest = header.strip_prefix(MAGIC).ok_or_else(|| fail(format!("line 1 is not `{MAGIC} ...`")))?;
    let words: Vec<&str> = rest.split_whitespace().collect();
    let ["inputs", theirs, "shard", shard] = words[..] else {
        return Err(fail("line 1 names no inputs and shard".to_owned()));
    };
    if theirs != inputs {
        return Err(fail(foreign(theirs, inputs)));
    }
    let shard = shard.parse().map_err(fail)?;
    let mut findings = HashMap::new();
    for (number, line) in lines {
        let damaged = |what: &str| fail(format!("line {} is damaged: {what}", number + 1));
        let content = unsealed(line).ok_or_else(|| damaged("wrong checksum"))?;
        let (key, finding) = read(content).ok_or_else(|| damaged("not a finding"))?;
        findings.insert(key, finding);
    }
    Ok(Loaded { shard, findings, length: end as u64 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::search::{Finding, SearchPieces, Verdict};
    use crate::statistics::Mean;

    fn finding(error: f64) -> Finding {
        let difference = Mean { value: -0.125, variance: f64::MIN_POSITIVE };
        let verdict = Verdict { error, difference, programs: 9, exact: 1, uncertified: 0 };
        Finding { verdict, dropped: 0b10 }
    }

    fn file(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("msm-checkpoint-{}-{name}", std::process::id()));
        let _ = std::fs::remove_file(&path);
        path
    }

    #[test]
    fn findings_come_back_bit_for_bit_and_torn_lines_are_dropped() {
        let path = file("torn");
        let mut checkpoint = Checkpoint::create(&path, "abc", Shard { index: 2, count: 3 }).unwrap();
        let findings = [((0, 4, 7), finding(0.1)), ((1, 4, 8), finding(1.0 / 3.0))];
        checkpoint.append(&findings).unwrap();
        let whole = std::fs::read(&path).unwrap();
        let header = whole.iter().position(|&byte| byte == b'\n').unwrap() + 1;
        for length in header..=whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            let loaded = load::<SearchPieces<'_>>(&path, "abc").unwrap();
            assert_eq!(loaded.shard, Shard { index: 2, count: 3 });
            let expected = whole[header..length].iter().filter(|&&byte| byte == b'\n').count();
            assert_eq!(loaded.findings.len(), expected);
            // What is appended after a torn line starts a line of its own.
            let mut resumed = Checkpoint::resume(&path, &loaded).unwrap();
            resumed.append(&findings[expected..]).unwrap();
            assert_eq!(std::fs::read(&path).unwrap(), whole);
        }
        let loaded = load::<SearchPieces<'_>>(&path, "abc").unwrap();
        assert!(findings.iter().all(|(key, finding)| loaded.findings[key] == *finding));
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn damage_and_foreign_files_are_refused() {
        let path = file("damage");
        let mut checkpoint = Checkpoint::create(&path, "abc", Shard::WHOLE).unwrap();
        checkpoint.append(&[((0, 4, 7), finding(0.1)), ((0, 4, 8), finding(0.2))]).unwrap();
        let message = |inputs: &str| {
            load::<SearchPieces<'_>>(&path, inputs).err().map(|e| e.to_string()).unwrap_or_default()
        };
        assert!(message("abd").contains("another search"));
        let whole = std::fs::read(&path).unwrap();
        // Every byte but the ends of lines, whose change can make a line torn.
        for at in (0..whole.len()).filter(|&at| whole[at] != b'\n') {
            let mut bytes = whole.clone();
            bytes[at] ^= 1;
            std::fs::write(&path, &bytes).unwrap();
            assert!(message("abc").contains("line"), "byte {at}: {}", message("abc"));
            assert_eq!(std::fs::read(&path).unwrap(), bytes);
        }
        std::fs::write(&path, b"").unwrap();
        assert!(message("abc").contains("empty"));
        std::fs::remove_file(&path).unwrap();
    }
}
