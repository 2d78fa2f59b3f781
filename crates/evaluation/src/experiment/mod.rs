//! Reading `experiments/*.toml`: a question, an expectation, the trials as data, and overrides per scale.

mod alphas;
pub(crate) mod keys;
pub(crate) mod kind;
mod lines;
mod prediction;

pub use self::alphas::Alphas;
use self::kind::AnySettings;
pub use self::prediction::{CardPrediction, Prediction};
use crate::error::EvaluationError;
use crate::kinds::KINDS;
use serde::{Deserialize, Serialize};
use std::any::Any;
use std::fmt;
use std::path::Path;
use std::sync::Arc;
use toml::{Table, Value};

/// How much of an experiment is run. The file's own values hold where `[scale.NAME]` says nothing.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// Seconds: does everything still work?
    Smoke,
    /// All experiments together in some ten minutes on two cores; what `[scale.brief]` does not say is as for quick.
    Brief,
    /// Minutes on two cores: do the results still hold?
    #[default]
    Quick,
    /// As large as the publication's.
    Paper,
}

impl Scale {
    /// All scales, ascending.
    pub const ALL: [Self; 4] = [Self::Smoke, Self::Brief, Self::Quick, Self::Paper];

    /// The tables of a file that may hold its overrides; the first that is there counts.
    pub(crate) fn tables(self) -> &'static [&'static str] {
        match self {
            Self::Smoke => &["smoke"],
            Self::Brief => &["brief", "quick"],
            Self::Quick => &["quick"],
            Self::Paper => &["paper"],
        }
    }
}

impl fmt::Display for Scale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Smoke => "smoke",
            Self::Brief => "brief",
            Self::Quick => "quick",
            Self::Paper => "paper",
        })
    }
}

/// An experiment, ready to run.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Name: the file's stem, and the directory under `results/`.
    pub name: String,
    /// The file's text, for its hash.
    pub(crate) source: String,
    /// Resolved at one scale; can be read again.
    pub(crate) resolved: Table,
    /// What is to be done.
    pub(crate) settings: Arc<dyn AnySettings>,
}

/// How lists of techniques were called before all kinds spelled them alike.
const FORMER_LISTS: [&str; 3] = ["candidate", "store", "method"];

/// The settings of a table, by its key `kind`.
fn parse_kind(mut table: Table) -> Result<Arc<dyn AnySettings>, String> {
    let name = table.remove("kind").ok_or("key `kind` is missing")?;
    if let Some(former) = FORMER_LISTS.into_iter().find(|list| table.contains_key(*list)) {
        return Err(format!(
            "[[{former}]] is spelled [[technique]] now, with `method = {{ bound = \"...\", .. }}`"
        ));
    }
    match KINDS.iter().find(|kind| name.as_str() == Some(kind.name)) {
        Some(kind) => (kind.parse)(table),
        None => {
            let known: Vec<String> = KINDS.iter().map(|kind| format!("\"{}\"", kind.name)).collect();
            Err(format!("kind = {name} is unknown (known: {})", known.join(", ")))
        }
    }
}

impl Experiment {
    /// Reads a file and resolves it at one scale. The other scales are checked too: a mistake in `[scale.paper]`
    /// shows at once and not after an hour.
    pub fn read(path: &Path, scale: Scale, seed: Option<u64>) -> Result<Self, EvaluationError> {
        let fail = |reason: String| EvaluationError::Input { path: path.to_owned(), reason };
        let source = std::fs::read_to_string(path).map_err(|error| fail(error.to_string()))?;
        Self::parse(path, &source, scale, seed)
    }

    /// The same for the text of a file, whose path names the experiment and stands in messages.
    pub fn parse(
        path: &Path,
        source: &str,
        scale: Scale,
        seed: Option<u64>,
    ) -> Result<Self, EvaluationError> {
        let fail = |reason: String| EvaluationError::Input { path: path.to_owned(), reason };
        let source = source.to_owned();
        let mut table: Table = toml::from_str(&source).map_err(|error| fail(located(&source, &error)))?;
        let overrides = match table.remove("scale") {
            None => Table::new(),
            Some(Value::Table(scales)) => scales,
            Some(other) => return Err(fail(format!("scale = {other} is not a table"))),
        };
        let mut resolved = None;
        for candidate in Scale::ALL {
            let mut merged = table.clone();
            match candidate.tables().iter().find_map(|name| overrides.get(*name)) {
                None => {}
                Some(Value::Table(changes)) => merge(&mut merged, changes.clone()),
                Some(other) => return Err(fail(format!("scale.{candidate} = {other} is not a table"))),
            }
            if let Some(seed) = seed {
                let seed = i64::try_from(seed).map_err(|_| fail(format!("seed {seed} exceeds 2^63 - 1")))?;
                merged.insert("seed".to_owned(), Value::Integer(seed));
            }
            let settings = parse_kind(merged.clone()).map_err(|reason| {
                fail(format!(
                    "{}{reason} (scale {candidate})",
                    line_before(lines::of_mistake(&source, candidate))
                ))
            })?;
            if candidate == scale {
                resolved = Some((merged, settings));
            }
        }
        let known = |name: &String| Scale::ALL.iter().any(|scale| scale.to_string() == *name);
        if let Some(unknown) = overrides.keys().find(|name| !known(name)) {
            let line = line_before(lines::of_key(&source, &format!("scale.{unknown}")));
            return Err(fail(format!("{line}unknown scale `{unknown}` (known: smoke, brief, quick, paper)")));
        }
        let Some((resolved, settings)) = resolved else {
            return Err(fail(format!("scale {scale} is missing")));
        };
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        Ok(Self { name, source, resolved, settings })
    }
}

impl Experiment {
    /// Evaluates other scenes than the file's: procedural names or scene files.
    ///
    /// # Errors
    /// [`EvaluationError::Value`] for an experiment that has no scenes.
    pub fn with_scenes(mut self, scenes: &[String]) -> Result<Self, EvaluationError> {
        if scenes.is_empty() {
            return Ok(self);
        }
        if !self.has_scenes() {
            let reason = format!("experiment `{}` has no scenes that --scene could replace", self.name);
            return Err(EvaluationError::Value(reason));
        }
        self.settings = self.settings.with_scenes(scenes);
        self.resolved_again()
    }

    /// Looks at so many fragments a view, 0 for all.
    ///
    /// # Errors
    /// [`EvaluationError::Value`] for an experiment that has no scenes.
    pub fn with_fragments(mut self, fragments: usize) -> Result<Self, EvaluationError> {
        if !self.has_scenes() {
            return Err(self.refused("--fragments"));
        }
        let count = i64::try_from(fragments)
            .map_err(|_| EvaluationError::Value(format!("--fragments {fragments} exceeds 2^63 - 1")))?;
        self.resolved.insert("fragments".to_owned(), Value::Integer(count));
        self.settings = parse_kind(self.resolved.clone()).map_err(EvaluationError::Value)?;
        Ok(self)
    }

    /// Every candidate on every fragment instead of a race.
    ///
    /// # Errors
    /// [`EvaluationError::Value`] for an experiment of another kind.
    pub fn exhaustive(mut self) -> Result<Self, EvaluationError> {
        self.settings = self.settings.exhaustive().ok_or_else(|| self.refused("--exhaustive"))?;
        self.resolved_again()
    }

    /// With the table that its settings have now.
    fn resolved_again(mut self) -> Result<Self, EvaluationError> {
        self.resolved = self.settings.table().map_err(|error| EvaluationError::Table {
            table: "experiment.toml".to_owned(),
            reason: error.to_string(),
        })?;
        self.resolved.insert("kind".to_owned(), Value::String(self.kind_name().to_owned()));
        Ok(self)
    }

    /// What it asks, in inline Markdown of the file's author.
    pub fn question(&self) -> &str {
        self.settings.statement().question.trim()
    }

    /// What its author expects, in inline Markdown.
    pub fn expectation(&self) -> &str {
        self.settings.statement().expectation.trim()
    }

    /// Value of the key `kind`.
    pub fn kind_name(&self) -> &'static str {
        self.settings.kind().name
    }

    /// The settings, if the experiment is of the kind that they belong to.
    pub fn settings<T: Any>(&self) -> Option<&T> {
        self.settings.own().downcast_ref()
    }

    /// Whether it evaluates scenes.
    pub fn has_scenes(&self) -> bool {
        self.settings.scenes().is_some()
    }

    /// Whether a run that was interrupted can go on where it stopped.
    pub fn can_resume(&self) -> bool {
        self.settings.kind().is_resumable
    }

    /// Scenes that the experiment reads, for their hashes.
    pub(crate) fn scenes(&self) -> &[String] {
        self.settings.scenes().unwrap_or_default()
    }
}

/// Overrides single keys; tables are merged, arrays replaced.
fn merge(base: &mut Table, changes: Table) {
    for (key, change) in changes {
        match (base.get_mut(&key), change) {
            (Some(Value::Table(inner)), Value::Table(changes)) => merge(inner, changes),
            (_, change) => {
                base.insert(key, change);
            }
        }
    }
}

/// The message with the line it is about.
fn located(source: &str, error: &toml::de::Error) -> String {
    match error.span() {
        Some(span) => {
            let line = source[..span.start.min(source.len())].matches('\n').count() + 1;
            format!("line {line}: {}", error.message())
        }
        None => one_line(error),
    }
}

/// `line 12: ` where the line of a mistake was found.
fn line_before(line: Option<usize>) -> String {
    line.map(|line| format!("line {line}: ")).unwrap_or_default()
}

fn one_line(error: &toml::de::Error) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}
