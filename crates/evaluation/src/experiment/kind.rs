//! What a kind of experiment is, and how the registry of `kinds` finds it by its name.

use super::lines;
use super::one_line;
use crate::error::EvaluationError;
use crate::kinds::search::{Prediction, Shard};
use crate::run::{Progress, Recorded};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::any::Any;
use std::fmt::Debug;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml::Table;
use toml::de::DeTable;

/// The settings of one kind: its TOML keys beside `kind` and `scale`, and what is done with them.
pub(crate) trait Settings: Any + Clone + Debug + DeserializeOwned + Serialize + Send + Sync {
    /// Value of the key `kind`.
    const KIND: &'static str;

    /// Whether a run that was interrupted can go on, and can be divided into shards.
    const IS_RESUMABLE: bool = false;

    /// Seed of everything random.
    fn seed(&self) -> u64;

    /// Rejects values that make no sense, before anything is computed; names the key.
    fn check(&self) -> Result<(), EvaluationError>;

    /// Scenes that are read; `None` for kinds without.
    fn scenes(&self) -> Option<&[String]> {
        None
    }

    /// Replaces the scenes of kinds that have some.
    fn replace_scenes(&mut self, _scenes: &[String]) {}

    /// Evaluates all trials.
    fn run(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError>;

    /// What a run will cost, for kinds that can tell.
    fn predict(&self, _threads: usize) -> Option<Result<Prediction, EvaluationError>> {
        None
    }
}

/// What a run gives to a kind.
pub(crate) struct RunContext<'a> {
    /// Told of every finished trial.
    pub(crate) progress: Progress<'a>,
    /// The run directory, for checkpoints.
    pub(crate) directory: &'a Path,
    /// The part that is wanted; all without it.
    pub(crate) shard: Option<Shard>,
    /// Run directories of all shards, to be completed.
    pub(crate) merge: &'a [PathBuf],
    /// Stands for the program and the resolved experiment.
    pub(crate) identity: String,
}

/// [`Settings`] of any kind.
pub(crate) trait AnySettings: Any + Debug + Send + Sync {
    fn kind(&self) -> &'static Kind;
    fn seed(&self) -> u64;
    fn scenes(&self) -> Option<&[String]>;
    fn with_scenes(&self, scenes: &[String]) -> Arc<dyn AnySettings>;
    fn table(&self) -> Result<Table, toml::ser::Error>;
    fn run(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError>;
    fn predict(&self, threads: usize) -> Option<Result<Prediction, EvaluationError>>;
}

impl<T: Settings> AnySettings for T {
    fn kind(&self) -> &'static Kind {
        const { &Kind::of::<T>() }
    }

    fn seed(&self) -> u64 {
        T::seed(self)
    }

    fn scenes(&self) -> Option<&[String]> {
        T::scenes(self)
    }

    fn with_scenes(&self, scenes: &[String]) -> Arc<dyn AnySettings> {
        let mut changed = self.clone();
        changed.replace_scenes(scenes);
        Arc::new(changed)
    }

    fn table(&self) -> Result<Table, toml::ser::Error> {
        Table::try_from(self)
    }

    fn run(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        T::run(self, context)
    }

    fn predict(&self, threads: usize) -> Option<Result<Prediction, EvaluationError>> {
        T::predict(self, threads)
    }
}

/// An entry of the registry.
#[derive(Debug)]
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    pub(crate) is_resumable: bool,
    /// Reads and checks the keys beside `kind`; the reason of a mistake on one line.
    pub(crate) parse: fn(Table) -> Result<Arc<dyn AnySettings>, String>,
    /// The line of the mistake that `parse` reports.
    pub(super) line_of_mistake: fn(&str, &DeTable<'_>) -> Option<usize>,
}

impl Kind {
    pub(crate) const fn of<T: Settings>() -> Self {
        Self {
            name: T::KIND,
            is_resumable: T::IS_RESUMABLE,
            parse: |table| {
                let settings: T = table.try_into().map_err(|error| one_line(&error))?;
                settings.check().map_err(|error| error.to_string())?;
                Ok(Arc::new(settings))
            },
            line_of_mistake: lines::mistake::<T>,
        }
    }
}
