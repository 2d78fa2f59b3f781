//! An append-only file of verdicts: what a killed run has found is not computed again.
//!
//! One line a verdict, ended by a checksum; numbers as the bits of their doubles, so that a resumed run ends with the
//! bytes of an undisturbed one. The first line names the inputs. A last line without its end was being written when
//! the run was killed and is dropped; any other damage is an error, and nothing is changed.

use super::judge::Verdict;
use super::statistics::Mean;
use crate::error::EvaluationError;
use crate::provenance::sha256;
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// File name within a run directory.
pub(crate) const FILE: &str = "checkpoint.log";

const MAGIC: &str = "msm candidate search, checkpoint 1";

/// Which verdict: block, order, number of the subset.
pub(crate) type Key = (u16, u16, u32);

/// What was found about a candidate on a block.
#[derive(Clone, Copy, Debug, PartialEq)]
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

/// Part of the candidates: `index` of `count`, counted from 1.
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

    /// Whether a candidate belongs to it.
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

/// The findings of a file and where its valid part ends.
pub(crate) struct Loaded {
    pub(crate) shard: Shard,
    pub(crate) findings: HashMap<Key, Finding>,
    length: u64,
}

/// An open checkpoint.
pub(crate) struct Checkpoint {
    path: PathBuf,
    file: File,
}

impl Checkpoint {
    /// Starts a file.
    pub(crate) fn create(path: &Path, inputs: &str, shard: Shard) -> Result<Self, EvaluationError> {
        let fail = |source| EvaluationError::Write { path: path.to_owned(), source };
        let file = OpenOptions::new().append(true).create_new(true).open(path).map_err(fail)?;
        let mut checkpoint = Self { path: path.to_owned(), file };
        checkpoint.write(&sealed(&format!("{MAGIC} inputs {inputs} shard {shard}")))?;
        Ok(checkpoint)
    }

    /// Goes on with a file, without what follows its last whole line.
    pub(crate) fn resume(path: &Path, loaded: &Loaded) -> Result<Self, EvaluationError> {
        let fail = |source| EvaluationError::Write { path: path.to_owned(), source };
        let file = OpenOptions::new().append(true).open(path).map_err(fail)?;
        file.set_len(loaded.length).map_err(fail)?;
        Ok(Self { path: path.to_owned(), file })
    }

    /// Appends findings with one write.
    pub(crate) fn append(&mut self, findings: &[(Key, Finding)]) -> Result<(), EvaluationError> {
        let text: String = findings.iter().map(|(key, finding)| sealed(&line(key, finding))).collect();
        self.write(&text)
    }

    fn write(&mut self, text: &str) -> Result<(), EvaluationError> {
        let fail = |source| EvaluationError::Write { path: self.path.clone(), source };
        self.file.write_all(text.as_bytes()).map_err(fail)
    }

    /// Makes sure that everything has reached the disk.
    pub(crate) fn sync(&self) -> Result<(), EvaluationError> {
        let fail = |source| EvaluationError::Write { path: self.path.clone(), source };
        self.file.sync_data().map_err(fail)
    }
}

/// Reads a file that was written for these inputs.
pub(crate) fn load(path: &Path, inputs: &str) -> Result<Loaded, EvaluationError> {
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
        return Err(fail(format!(
            "belongs to another search: its inputs are {}, those of this run are {} (experiment, scenes, seed, scale \
             and program must be the same)",
            short(theirs),
            short(inputs)
        )));
    }
    let shard = shard.parse().map_err(fail)?;
    let mut findings = HashMap::new();
    for (number, line) in lines {
        let damaged = |what: &str| fail(format!("line {} is damaged: {what}", number + 1));
        let content = unsealed(line).ok_or_else(|| damaged("wrong checksum"))?;
        let (key, finding) = parse(content).ok_or_else(|| damaged("not a finding"))?;
        findings.insert(key, finding);
    }
    Ok(Loaded { shard, findings, length: end as u64 })
}

fn short(hash: &str) -> &str {
    hash.get(..12).unwrap_or(hash)
}

fn line(key: &Key, finding: &Finding) -> String {
    let v = &finding.verdict;
    format!(
        "{} {} {} {:016x} {:016x} {:016x} {} {} {} {:x}",
        key.0,
        key.1,
        key.2,
        v.error.to_bits(),
        v.difference.value.to_bits(),
        v.difference.variance.to_bits(),
        v.programs,
        v.exact,
        v.uncertified,
        finding.dropped
    )
}

fn parse(content: &str) -> Option<(Key, Finding)> {
    let words: Vec<&str> = content.split(' ').collect();
    let [block, order, number, error, value, variance, programs, exact, uncertified, dropped] = words[..]
    else {
        return None;
    };
    let double = |word: &str| u64::from_str_radix(word, 16).ok().map(f64::from_bits);
    let verdict = Verdict {
        error: double(error)?,
        difference: Mean { value: double(value)?, variance: double(variance)? },
        programs: programs.parse().ok()?,
        exact: exact.parse().ok()?,
        uncertified: uncertified.parse().ok()?,
    };
    let key = (block.parse().ok()?, order.parse().ok()?, number.parse().ok()?);
    Some((key, Finding { verdict, dropped: u16::from_str_radix(dropped, 16).ok()? }))
}

/// A line with its checksum.
fn sealed(content: &str) -> String {
    format!("{content} {}\n", checksum(content))
}

fn unsealed(line: &str) -> Option<&str> {
    let (content, sum) = line.rsplit_once(' ')?;
    (checksum(content) == sum).then_some(content)
}

fn checksum(content: &str) -> String {
    sha256(content.as_bytes())[..8].to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let loaded = load(&path, "abc").unwrap();
            assert_eq!(loaded.shard, Shard { index: 2, count: 3 });
            let expected = whole[header..length].iter().filter(|&&byte| byte == b'\n').count();
            assert_eq!(loaded.findings.len(), expected);
            // What is appended after a torn line starts a line of its own.
            let mut resumed = Checkpoint::resume(&path, &loaded).unwrap();
            resumed.append(&findings[expected..]).unwrap();
            assert_eq!(std::fs::read(&path).unwrap(), whole);
        }
        let loaded = load(&path, "abc").unwrap();
        assert!(findings.iter().all(|(key, finding)| loaded.findings[key] == *finding));
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn damage_and_foreign_files_are_refused() {
        let path = file("damage");
        let mut checkpoint = Checkpoint::create(&path, "abc", Shard::WHOLE).unwrap();
        checkpoint.append(&[((0, 4, 7), finding(0.1)), ((0, 4, 8), finding(0.2))]).unwrap();
        let message = |inputs: &str| load(&path, inputs).err().map(|e| e.to_string()).unwrap_or_default();
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
