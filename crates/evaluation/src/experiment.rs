//! Reading `experiments/*.toml`: a question, an expectation, the trials as data, and overrides per scale.

use crate::error::EvaluationError;
use crate::kinds::bounds::BoundsExperiment;
use crate::kinds::filterable::FilterableExperiment;
use crate::kinds::quantization::QuantizationExperiment;
use crate::kinds::search::SearchExperiment;
use crate::kinds::speed_accuracy::SpeedAccuracyExperiment;
use crate::kinds::stability::StabilityExperiment;
use crate::lines;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;
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
    pub source: String,
    /// Resolved at one scale; can be read again.
    pub resolved: Table,
    /// What is to be done.
    pub kind: Kind,
}

/// One variant per `kind` of experiment.
#[derive(Clone, Debug)]
pub enum Kind {
    /// Bounds over all fragment depths for given kernels and bases.
    Bounds(BoundsExperiment),
    /// Filterable shadow maps against percentage-closer filtering on scenes.
    Filterable(FilterableExperiment),
    /// Transforms, number formats and biases of stored moments.
    Quantization(QuantizationExperiment),
    /// All bases of a family, ranked by their error on scenes.
    Search(SearchExperiment),
    /// Errors and failures of closed forms on inputs that are hard in a known way.
    Stability(StabilityExperiment),
    /// Error against cost of techniques, formats and map sizes.
    SpeedAccuracy(Box<SpeedAccuracyExperiment>),
}

impl Kind {
    fn from_table(mut table: Table) -> Result<Self, String> {
        let Some(kind) = table.remove("kind") else { return Err("key `kind` is missing".to_owned()) };
        match kind.as_str() {
            Some("bounds") => {
                let experiment: BoundsExperiment = table.try_into().map_err(|error| one_line(&error))?;
                experiment.check().map_err(|error| error.to_string())?;
                Ok(Self::Bounds(experiment))
            }
            Some("filterable") => {
                let experiment: FilterableExperiment = table.try_into().map_err(|error| one_line(&error))?;
                experiment.check().map_err(|error| error.to_string())?;
                Ok(Self::Filterable(experiment))
            }
            Some("quantization") => {
                let experiment: QuantizationExperiment =
                    table.try_into().map_err(|error| one_line(&error))?;
                experiment.check().map_err(|error| error.to_string())?;
                Ok(Self::Quantization(experiment))
            }
            Some("search") => {
                let experiment: SearchExperiment = table.try_into().map_err(|error| one_line(&error))?;
                experiment.check().map_err(|error| error.to_string())?;
                Ok(Self::Search(experiment))
            }
            Some("stability") => {
                let experiment: StabilityExperiment = table.try_into().map_err(|error| one_line(&error))?;
                experiment.check().map_err(|error| error.to_string())?;
                Ok(Self::Stability(experiment))
            }
            Some("speed-accuracy") => {
                let experiment: SpeedAccuracyExperiment =
                    table.try_into().map_err(|error| one_line(&error))?;
                experiment.check().map_err(|error| error.to_string())?;
                Ok(Self::SpeedAccuracy(Box::new(experiment)))
            }
            _ => {
                let known = "\"bounds\", \"filterable\", \"quantization\", \"search\", \"stability\", \
                             \"speed-accuracy\"";
                Err(format!("kind = {kind} is unknown (known: {known})"))
            }
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

    /// The same for the text of a file.
    pub(crate) fn parse(
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
            let kind = Kind::from_table(merged.clone()).map_err(|reason| {
                fail(format!("{}{reason} (scale {candidate})", line_prefix(&source, candidate)))
            })?;
            if candidate == scale {
                resolved = Some((merged, kind));
            }
        }
        let known = |name: &String| Scale::ALL.iter().any(|scale| scale.to_string() == *name);
        if let Some(unknown) = overrides.keys().find(|name| !known(name)) {
            return Err(fail(format!("unknown scale `{unknown}` (known: smoke, brief, quick, paper)")));
        }
        let Some((resolved, kind)) = resolved else { return Err(fail(format!("scale {scale} is missing"))) };
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        Ok(Self { name, source, resolved, kind })
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
        let fail = |error: toml::ser::Error| EvaluationError::Table {
            table: "experiment.toml".to_owned(),
            reason: error.to_string(),
        };
        let (kind, resolved) = match &mut self.kind {
            Kind::Filterable(experiment) => {
                experiment.with_scenes(scenes);
                ("filterable", Table::try_from(&*experiment).map_err(fail)?)
            }
            Kind::Quantization(experiment) => {
                experiment.scenes = scenes.to_vec();
                experiment.views.clear();
                ("quantization", Table::try_from(&*experiment).map_err(fail)?)
            }
            Kind::Search(experiment) => {
                experiment.scenes = scenes.to_vec();
                experiment.views.clear();
                ("search", Table::try_from(&*experiment).map_err(fail)?)
            }
            Kind::Stability(experiment) => {
                experiment.scenes = scenes.to_vec();
                experiment.views.clear();
                ("stability", Table::try_from(&*experiment).map_err(fail)?)
            }
            Kind::SpeedAccuracy(experiment) => {
                experiment.with_scenes(scenes);
                ("speed-accuracy", Table::try_from(&*experiment).map_err(fail)?)
            }
            Kind::Bounds(_) => {
                let reason = format!("experiment `{}` has no scenes that --scene could replace", self.name);
                return Err(EvaluationError::Value(reason));
            }
        };
        let mut resolved = resolved;
        resolved.insert("kind".to_owned(), Value::String(kind.to_owned()));
        self.resolved = resolved;
        Ok(self)
    }

    /// Whether it evaluates scenes.
    pub fn has_scenes(&self) -> bool {
        !matches!(self.kind, Kind::Bounds(_))
    }

    /// Whether a run that was interrupted can go on where it stopped.
    pub fn can_resume(&self) -> bool {
        matches!(self.kind, Kind::Search(_))
    }

    /// Scenes that the experiment reads, for their hashes.
    pub(crate) fn scenes(&self) -> &[String] {
        match &self.kind {
            Kind::Bounds(_) => &[],
            Kind::Filterable(experiment) => &experiment.scenes,
            Kind::Quantization(experiment) => &experiment.scenes,
            Kind::Search(experiment) => &experiment.scenes,
            Kind::Stability(experiment) => &experiment.scenes,
            Kind::SpeedAccuracy(experiment) => &experiment.scenes,
        }
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

/// `line 12: ` where the line of the mistake can be found.
fn line_prefix(source: &str, scale: Scale) -> String {
    lines::of_mistake(source, scale).map(|line| format!("line {line}: ")).unwrap_or_default()
}

fn one_line(error: &toml::de::Error) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}
