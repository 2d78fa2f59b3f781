//! What a kind of experiment is, and how the registry of `kinds` finds it by its name.

use super::lines;
use super::one_line;
use super::prediction::Prediction;
use crate::error::EvaluationError;
use crate::fragments::SceneSettings;
use crate::run::{Backend, Progress, Recorded};
use crate::shards::Task;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize};
use std::any::Any;
use std::fmt::Debug;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;
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

    /// Seed of everything random, for kinds without the keys of [`SceneSettings`].
    fn seed(&self) -> u64 {
        0
    }

    /// Rejects values that make no sense, before anything is computed; names the key.
    fn check(&self) -> Result<(), EvaluationError>;

    /// Takes what the keys of [`SceneSettings`] hold, for kinds on scenes.
    fn on_scenes(&mut self, _scenery: SceneSettings) {}

    /// Replaces a race by every candidate on every fragment, for kinds that have one. False for the others.
    fn make_exhaustive(&mut self, _scenery: &mut SceneSettings) -> bool {
        false
    }

    /// Follows the scenes where other keys name them, once they have been replaced.
    fn scenes_replaced(&mut self) {}

    /// Rounds in which shards work: a round begins when the one before it is complete.
    fn rounds(&self) -> usize {
        1
    }

    /// Evaluates all trials.
    fn run(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError>;

    /// What a run will cost, for kinds that can tell.
    fn predict(&self, _threads: usize, _backend: Backend) -> Option<Result<Prediction, EvaluationError>> {
        None
    }
}

/// The items of [`Settings`] that are alike for kinds on scenes, which keep what [`SceneSettings`] hold in `scenery` and have
/// `evaluate` in a file of its own.
macro_rules! evaluated_on_scenes {
    () => {
        fn on_scenes(&mut self, scenery: $crate::fragments::SceneSettings) {
            self.scenery = scenery;
        }

        fn run(
            &self,
            context: &$crate::experiment::kind::RunContext<'_>,
        ) -> Result<$crate::run::Recorded, $crate::error::EvaluationError> {
            self.evaluate(context)
        }
    };
}
pub(crate) use evaluated_on_scenes;

/// What a run gives to a kind.
pub(crate) struct RunContext<'a> {
    /// Told of every finished trial.
    pub(crate) progress: Progress<'a>,
    /// The run directory, for checkpoints.
    pub(crate) directory: &'a Path,
    /// What of the experiment is wanted.
    pub(crate) task: Task<'a>,
    /// Whether findings go to a file of the run directory as they come.
    pub(crate) keeps_findings: bool,
    /// What solves linear programs.
    pub(crate) backend: Backend,
    /// Stands for the program, the resolved experiment and the files of its scenes.
    pub(crate) identity: String,
    /// When the run began.
    pub(crate) started: Instant,
}

/// Keys of every experiment.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Statement {
    /// What is asked, in inline Markdown.
    pub(crate) question: String,
    /// What is expected, written before the first run.
    pub(crate) expectation: String,
}

impl Statement {
    const KEYS: [&'static str; 2] = ["question", "expectation"];
}

/// Keys by who reads them: serde cannot flatten structures into one that denies unknown keys.
pub(super) struct Keys<M> {
    own: M,
    statement: M,
    scenery: M,
}

impl<M> Keys<M> {
    /// `take` removes some keys from a table.
    pub(super) fn split<T: Settings>(mut all: M, take: impl Fn(&mut M, &[&str]) -> M) -> Self {
        let scenery = take(&mut all, if T::ON_SCENES { &SceneSettings::KEYS } else { &[] });
        Self { statement: take(&mut all, &Statement::KEYS), scenery, own: all }
    }

    /// The settings; the kind's own keys first.
    pub(super) fn read<'de, T, D>(self, source: impl Fn(M) -> D) -> Result<Given<T>, D::Error>
    where
        T: Settings,
        D: Deserializer<'de>,
    {
        let mut own = T::deserialize(source(self.own))?;
        let statement = Statement::deserialize(source(self.statement))?;
        let scenery =
            if T::ON_SCENES { Some(SceneSettings::deserialize(source(self.scenery))?) } else { None };
        scenery.iter().for_each(|scenery| own.on_scenes(scenery.clone()));
        Ok(Given { statement, scenery, own })
    }
}

/// Settings of one kind with the keys that others have too.
#[derive(Debug)]
pub(super) struct Given<T> {
    statement: Statement,
    scenery: Option<SceneSettings>,
    pub(super) own: T,
}

/// [`Settings`] of any kind.
pub(crate) trait AnySettings: Debug + Send + Sync {
    fn kind(&self) -> &'static Kind;
    fn own(&self) -> &dyn Any;
    fn statement(&self) -> &Statement;
    fn seed(&self) -> u64;
    fn scenes(&self) -> Option<&[String]>;
    fn with_scenes(&self, scenes: &[String]) -> Arc<dyn AnySettings>;
    fn exhaustive(&self) -> Option<Arc<dyn AnySettings>>;
    fn table(&self) -> Result<Table, toml::ser::Error>;
    fn rounds(&self) -> usize;
    fn run(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError>;
    fn predict(&self, threads: usize, backend: Backend) -> Option<Result<Prediction, EvaluationError>>;
}

impl<T: Settings> AnySettings for Given<T> {
    fn kind(&self) -> &'static Kind {
        const { &Kind::of::<T>() }
    }

    fn own(&self) -> &dyn Any {
        &self.own
    }

    fn statement(&self) -> &Statement {
        &self.statement
    }

    fn seed(&self) -> u64 {
        self.scenery.as_ref().map_or_else(|| self.own.seed(), |scenery| scenery.seed)
    }

    fn scenes(&self) -> Option<&[String]> {
        self.scenery.as_ref().map(|scenery| scenery.scenes.as_slice())
    }

    fn with_scenes(&self, scenes: &[String]) -> Arc<dyn AnySettings> {
        let (mut scenery, mut own) = (self.scenery.clone(), self.own.clone());
        if let Some(scenery) = &mut scenery {
            scenes.clone_into(&mut scenery.scenes);
            scenery.views.clear();
            own.on_scenes(scenery.clone());
            own.scenes_replaced();
        }
        Arc::new(Self { statement: self.statement.clone(), scenery, own })
    }

    fn exhaustive(&self) -> Option<Arc<dyn AnySettings>> {
        let (mut scenery, mut own) = (self.scenery.clone()?, self.own.clone());
        own.make_exhaustive(&mut scenery).then(|| {
            own.on_scenes(scenery.clone());
            let statement = self.statement.clone();
            Arc::new(Self { statement, scenery: Some(scenery), own }) as Arc<dyn AnySettings>
        })
    }

    fn table(&self) -> Result<Table, toml::ser::Error> {
        let mut table = Table::try_from(&self.own)?;
        table.extend(Table::try_from(&self.statement)?);
        if let Some(scenery) = &self.scenery {
            table.extend(Table::try_from(scenery)?);
        }
        Ok(table)
    }

    fn rounds(&self) -> usize {
        self.own.rounds()
    }

    fn run(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        self.own.run(context)
    }

    fn predict(&self, threads: usize, backend: Backend) -> Option<Result<Prediction, EvaluationError>> {
        self.own.predict(threads, backend)
    }
}

/// A mistyped key differs from the one that was meant by a third of its letters at most.
const MISTYPED: f64 = 0.66;

/// The known key that an unknown one resembles, for the end of serde's message about it, which lists known keys behind the word
/// `expected`.
fn nearest(reason: &str, more: &[&str]) -> Option<String> {
    let (_, rest) = reason.split_once("unknown field `")?;
    let (unknown, rest) = rest.split_once('`')?;
    let known = rest.split_once("expected")?.1.split('`').skip(1).step_by(2).chain(more.iter().copied());
    let likeness = |key: &str| strsim::normalized_damerau_levenshtein(unknown, key);
    let best = known.map(|key| (likeness(key), key)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 >= MISTYPED).then(|| format!("; `{}` is near", best.1))
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
            parse: |table| {
                let take = |table: &mut Table, keys: &[&str]| {
                    keys.iter().filter_map(|&key| table.remove_entry(key)).collect()
                };
                let keys = Keys::split::<T>(table, take);
                let own: Vec<String> = keys.own.keys().cloned().collect();
                let given: Given<T> = keys.read(|table| table).map_err(|error| {
                    let mut reason = one_line(&error);
                    // Serde knows of the kind's own keys only.
                    let unknown = own.iter().find(|key| reason.contains(&format!("unknown field `{key}`")));
                    let mut more = Vec::new();
                    if unknown.is_some() {
                        let scenery = if T::ON_SCENES { &SceneSettings::KEYS[..] } else { &[] };
                        more = [&Statement::KEYS, scenery].concat();
                        reason += &format!(", or of `{}`", more.join("`, `"));
                    }
                    let near = nearest(&reason, &more).unwrap_or_default();
                    reason + &near
                })?;
                given.own.check().map_err(|error| error.to_string())?;
                Ok(Arc::new(given))
            },
            line_of_mistake: lines::mistake::<T>,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn mistyped_keys_are_recognised() {
        let reason = "unknown field `scense`, expected one of `size`, `scenes`, `light`";
        assert_eq!(nearest(reason, &[]).as_deref(), Some("; `scenes` is near"));
        let reason = "unknown field `fragmnets`, expected `size` or `light`";
        assert_eq!(nearest(reason, &["fragments"]).as_deref(), Some("; `fragments` is near"));
        assert_eq!(nearest("unknown field `colour`, expected `size` or `light`", &[]), None);
        assert_eq!(nearest("invalid type", &[]), None);
    }
}
