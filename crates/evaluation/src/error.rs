//! What can go wrong between a TOML file and a run directory.

use moment_problem::MomentError;
use std::path::PathBuf;
use thiserror::Error;

/// Why an experiment could not be read, run or recorded.
#[derive(Debug, Error)]
pub enum EvaluationError {
    /// The experiment file or a recorded file is at fault.
    #[error("{}: {reason}", path.display())]
    Input {
        /// The file.
        path: PathBuf,
        /// What is wrong with it; names the key or value.
        reason: String,
    },
    /// A value of an experiment makes no sense.
    #[error("{0}")]
    Value(String),
    /// A value of an experiment makes no sense, and its place in the file is known.
    #[error("{reason}")]
    Key {
        /// Path of the key, such as `technique[3].method.exponent`.
        key: String,
        /// What is wrong; names the value.
        reason: String,
    },
    /// A technique has no method.
    #[error("technique `{technique}`: {source}")]
    Technique {
        /// Its name in the experiment.
        technique: String,
        /// Why.
        source: MomentError,
    },
    /// A file or directory could not be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file or directory.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Records could not be turned into text.
    #[error("records of {table}: {reason}")]
    Table {
        /// File name of the table.
        table: String,
        /// The reason.
        reason: String,
    },
    /// The thread pool could not be started.
    #[error("cannot start {threads} threads: {reason}")]
    Threads {
        /// Threads asked for.
        threads: usize,
        /// The reason.
        reason: String,
    },
}

impl EvaluationError {
    /// Whether the input, and not the machine, is at fault.
    pub fn is_input(&self) -> bool {
        matches!(self, Self::Input { .. } | Self::Value(_) | Self::Key { .. } | Self::Technique { .. })
    }
}
