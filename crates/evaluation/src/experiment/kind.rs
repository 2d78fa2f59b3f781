//! What a kind of experiment is, and how the registry of `kinds` finds it by its name.

use super::lines;
use super::one_line;
use crate::error::EvaluationError;
use crate::fragments::SceneSettings;
use crate::kinds::search::Prediction;
use crate::run::{Progress, Recorded};
use crate::shards::Shard;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize};
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

    /// Whether a run that was interrupted can go on.
    const IS_RESUMABLE: bool = false;

    /// Whether it can be divided into shards, each of which can go on.
    const IS_DIVISIBLE: bool = Self::IS_RESUMABLE;

    /// Whether the keys of [`SceneSettings`] stand beside its own.
    const ON_SCENES: bool = false;

    /// Seed of everything random.
    fn seed(&self) -> u64;

    /// Rejects values that make no sense, before anything is computed; names the key.
    fn check(&self) -> Result<(), EvaluationError>;

    /// What the keys of [`SceneSettings`] hold, for kinds on scenes.
    fn scenery(&self) -> Option<&SceneSettings> {
        None
    }

    /// The same, to be filled.
    fn scenery_mut(&mut self) -> Option<&mut SceneSettings> {
        None
    }

    /// Follows the scenes where other keys name them, once they have been replaced.
    fn scenes_replaced(&mut self) {}

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
        self.scenery().map(|scenery| scenery.scenes.as_slice())
    }

    fn with_scenes(&self, scenes: &[String]) -> Arc<dyn AnySettings> {
        let mut changed = self.clone();
        if let Some(scenery) = changed.scenery_mut() {
            scenes.clone_into(&mut scenery.scenes);
            scenery.views.clear();
            changed.scenes_replaced();
        }
        Arc::new(changed)
    }

    fn table(&self) -> Result<Table, toml::ser::Error> {
        let mut table = Table::try_from(self)?;
        if let Some(scenery) = self.scenery() {
            table.extend(Table::try_from(scenery)?);
        }
        Ok(table)
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
    pub(crate) is_divisible: bool,
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
            is_divisible: T::IS_DIVISIBLE,
            parse: |mut table| {
                let common = if T::ON_SCENES { &SceneSettings::KEYS[..] } else { &[] };
                let keys = common.iter().filter_map(|&key| table.remove_entry(key)).collect();
                let own: Vec<String> = table.keys().cloned().collect();
                let settings = read::<T, _>(table, keys).map_err(|error| {
                    let mut reason = one_line(&error);
                    // Serde knows of the kind's own keys only.
                    if own.iter().any(|key| reason.contains(&format!("unknown field `{key}`")))
                        && T::ON_SCENES
                    {
                        reason += &format!(", or of `{}`", SceneSettings::KEYS.join("`, `"));
                    }
                    reason
                })?;
                settings.check().map_err(|error| error.to_string())?;
                Ok(Arc::new(settings))
            },
            line_of_mistake: lines::mistake::<T>,
        }
    }
}

/// The settings from the kind's own keys and those of [`SceneSettings`], which serde cannot flatten into a structure that
/// denies unknown ones.
pub(super) fn read<'de, T, D>(own: D, scenery: D) -> Result<T, D::Error>
where
    T: Settings,
    D: Deserializer<'de>,
{
    let mut settings = T::deserialize(own)?;
    if let Some(place) = settings.scenery_mut() {
        *place = SceneSettings::deserialize(scenery)?;
    }
    Ok(settings)
}
