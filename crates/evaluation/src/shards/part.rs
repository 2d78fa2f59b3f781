//! The file of one shard of one round: written whole or not at all, and checked whole before it is believed.
//!
//! The first line names inputs, round and shard, the last one the number of findings, what they took, and a hash of all lines
//! before it. Until then the file has a name of its own that no reader looks at, so that a task that is killed, or that goes on
//! beside its own repetition, does no harm.

use super::sealed::{foreign, read, sealed, short, unsealed, written};
use super::{Pieces, Shard};
use crate::error::EvaluationError;
use crate::provenance::sha256;
use serde::Serialize;
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

const MAGIC: &str = "msm part 1";

/// Ending of the files of shards.
pub(super) const ENDING: &str = "part";

/// Ending of files in the making.
pub(super) const UNFINISHED: &str = "partial";

/// A task at work says so this often.
const SIGN_OF_LIFE: Duration = Duration::from_secs(10);

/// A task that has been silent for so long is taken for dead: several signs of life, and what clocks may differ.
pub(super) const SILENCE: Duration = Duration::from_secs(60);

/// What a part belongs to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    /// Stands for program and experiment.
    pub(super) program: String,
    /// Stands for these and everything that was read.
    pub(super) inputs: String,
    pub(super) round: usize,
    pub(super) shard: Shard,
}

/// What a finished part cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cost {
    pub(super) pieces: usize,
    pub(super) seconds: f64,
    pub(super) threads: usize,
}

/// A whole part.
pub(super) struct Part<'t> {
    pub(super) header: Header,
    pub(super) cost: Cost,
    /// Its findings, not read yet.
    lines: Vec<&'t str>,
}

/// Name of a shard's file.
pub(super) fn name(shard: Shard) -> String {
    format!("shard-{:04}-of-{:04}.{ENDING}", shard.index, shard.count)
}

/// The shard that a file is of by its name, finished or not.
pub(super) fn shard_of(name: &str) -> Option<Shard> {
    let rest = name.strip_prefix('.').unwrap_or(name).strip_prefix("shard-")?;
    let (index, rest) = rest.split_once("-of-")?;
    let count = rest.split('.').next()?;
    format!("{index}/{count}").parse().ok()
}

/// A part in the making. Dropped before it is finished, it takes its file back.
pub(super) struct Writer {
    path: PathBuf,
    temporary: PathBuf,
    file: BufWriter<File>,
    /// Hash of what was written.
    text: sha2::Sha256,
    pieces: usize,
    is_finished: bool,
    /// Ends the signs of life when it is dropped.
    _alive: Sender<()>,
}

impl Writer {
    pub(super) fn create(folder: &Path, header: &Header) -> Result<Self, EvaluationError> {
        let fail = |path: &Path, source| EvaluationError::Write { path: path.to_owned(), source };
        std::fs::create_dir_all(folder).map_err(|error| fail(folder, error))?;
        let path = folder.join(name(header.shard));
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_nanos());
        // Machines that share the folder may number their processes alike, but not at the same time.
        let own = format!(".{}.{}-{now}.{UNFINISHED}", name(header.shard), std::process::id());
        let temporary = folder.join(own);
        let open = |path: &Path| OpenOptions::new().write(true).create_new(true).open(path);
        let file = open(&temporary).map_err(|error| fail(&temporary, error))?;
        let (alive, ended) = channel::<()>();
        if let Ok(touched) = file.try_clone() {
            std::thread::spawn(move || {
                while ended.recv_timeout(SIGN_OF_LIFE) == Err(RecvTimeoutError::Timeout) {
                    // Without it the status calls the task missing, and nothing else depends on it.
                    let _ = touched.set_modified(SystemTime::now());
                }
            });
        }
        let mut writer = Self {
            path,
            temporary,
            file: BufWriter::new(file),
            text: sha2::Digest::new(),
            pieces: 0,
            is_finished: false,
            _alive: alive,
        };
        let Header { program, inputs, round, shard } = header;
        writer.write(&sealed(&format!(
            "{MAGIC} program {program} inputs {inputs} round {round} shard {shard}"
        )))?;
        Ok(writer)
    }

    pub(super) fn append<K: Serialize, F: Serialize>(
        &mut self,
        findings: &[(K, F)],
    ) -> Result<(), EvaluationError> {
        self.pieces += findings.len();
        let text: String = findings.iter().map(|(key, finding)| written(key, finding)).collect();
        self.write(&text)
    }

    /// Gives the file its name.
    pub(super) fn finish(mut self, seconds: f64, threads: usize) -> Result<(), EvaluationError> {
        let hash = hexadecimal(&sha2::Digest::finalize(self.text.clone()));
        let pieces = self.pieces;
        self.write(&sealed(&format!(
            "end pieces {pieces} seconds {seconds:.3} threads {threads} sha256 {hash}"
        )))?;
        let named = self.file.flush().and_then(|()| self.file.get_ref().sync_all());
        named
            .and_then(|()| std::fs::rename(&self.temporary, &self.path))
            .map_err(|source| self.failed(source))?;
        self.is_finished = true;
        Ok(())
    }

    fn write(&mut self, text: &str) -> Result<(), EvaluationError> {
        sha2::Digest::update(&mut self.text, text.as_bytes());
        self.file.write_all(text.as_bytes()).map_err(|source| self.failed(source))
    }

    fn failed(&self, source: std::io::Error) -> EvaluationError {
        EvaluationError::Write { path: self.path.clone(), source }
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        if !self.is_finished {
            // What could not be written cannot be removed either where the folder is gone.
            let _ = std::fs::remove_file(&self.temporary);
        }
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

impl<'t> Part<'t> {
    /// Checks the text of a file.
    pub(super) fn parse(text: &'t str) -> Result<Self, String> {
        let cut = "is truncated: its last line, which counts the others, is missing; run the shard again";
        let lines: Vec<&str> = text.lines().collect();
        let [first, lines @ .., last] = lines.as_slice() else {
            return Err(if text.is_empty() { "is empty".to_owned() } else { cut.to_owned() });
        };
        let header = unsealed(first).ok_or("line 1 is damaged: wrong checksum")?;
        let header = Header::parse(header).ok_or_else(|| format!("line 1 is not `{MAGIC} ...`"))?;
        let end = unsealed(last).and_then(|line| line.strip_prefix("end ")).filter(|_| text.ends_with('\n'));
        let words: Vec<&str> = end.ok_or(cut)?.split(' ').collect();
        let ["pieces", pieces, "seconds", seconds, "threads", threads, "sha256", hash] = words[..] else {
            return Err("its last line does not count the others".to_owned());
        };
        let number =
            |word: &str| word.parse::<usize>().map_err(|_| format!("`{word}` in its last line is no number"));
        let (pieces, threads) = (number(pieces)?, number(threads)?);
        let seconds = seconds.parse().map_err(|_| format!("`{seconds}` in its last line is no time"))?;
        if let Some(line) = lines.iter().position(|line| unsealed(line).is_none()) {
            return Err(format!("line {} is damaged: wrong checksum", line + 2));
        }
        if pieces != lines.len() {
            return Err(format!("has {} findings, its last line counts {pieces}", lines.len()));
        }
        if sha256(&text.as_bytes()[..text.len() - last.len() - 1]) != hash {
            return Err("is damaged: its lines are not those that were written".to_owned());
        }
        Ok(Self { header, cost: Cost { pieces, seconds, threads }, lines: lines.to_vec() })
    }

    /// What was found.
    pub(super) fn findings<P: Pieces>(&self) -> Result<Found<P>, String> {
        let one = |(number, line): (usize, &&str)| {
            let finding = unsealed(line).and_then(read);
            finding.ok_or_else(|| format!("line {}: not a finding", number + 2))
        };
        self.lines.iter().enumerate().map(one).collect()
    }
}

/// Findings by what they are about.
type Found<P> = Vec<(<P as Pieces>::Key, <P as Pieces>::Finding)>;

impl Header {
    fn parse(line: &str) -> Option<Self> {
        let words: Vec<&str> = line.strip_prefix(MAGIC)?.split_whitespace().collect();
        let ["program", program, "inputs", inputs, "round", round, "shard", shard] = words[..] else {
            return None;
        };
        let (program, inputs) = (program.to_owned(), inputs.to_owned());
        Some(Self { program, inputs, round: round.parse().ok()?, shard: shard.parse().ok()? })
    }

    /// Refuses what is not of a round of these inputs.
    pub(super) fn check(&self, inputs: &str, round: usize) -> Result<(), String> {
        if self.inputs != inputs {
            return Err(foreign(&self.inputs, inputs));
        }
        if self.round != round {
            return Err(format!("is of round {}, not {round} (inputs {})", self.round, short(inputs)));
        }
        Ok(())
    }
}
