//! What a folder of scripts is for, in a file beside them.

use super::{Arguments, Engine};
use crate::outcome::Failure;
use anyhow::anyhow;
use evaluation::{EvaluationError, Experiment, Scale};
use serde::{Deserialize, Serialize};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::time::SystemTime;

/// Its name.
pub(super) const FILE: &str = "plan.json";

/// What `msm cluster status` has to know; the scripts do not read it.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Plan {
    /// Name of the experiment; EXPERIMENT.toml lies beside.
    pub(super) experiment: String,
    pub(super) scale: Scale,
    pub(super) engine: Engine,
    pub(super) rounds: usize,
    pub(super) shards: usize,
    /// Threads of a task.
    pub(super) threads: usize,
    /// Begin of the names of all jobs.
    pub(super) job: String,
}

impl Plan {
    pub(super) fn new(
        arguments: &Arguments,
        experiment: &Experiment,
        (scale, shards): (Scale, usize),
    ) -> Result<Self, Failure> {
        if !experiment.name.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c)) {
            let reason = format!(
                "`{}`: jobs are named after the experiment: letters, digits and -_.",
                experiment.name
            );
            return Err(Failure::Input(anyhow!(reason)));
        }
        // Two folders of one experiment have jobs of different names.
        let mut hasher = DefaultHasher::new();
        (SystemTime::now(), std::process::id(), &arguments.out).hash(&mut hasher);
        Ok(Self {
            experiment: experiment.name.clone(),
            scale,
            engine: arguments.engine,
            rounds: experiment.rounds(),
            shards,
            threads: arguments.threads,
            job: format!("msm-{:06x}", hasher.finish() & 0xff_ffff),
        })
    }

    pub(super) fn read(folder: &Path) -> Result<Self, Failure> {
        let path = folder.join(FILE);
        let fail = |reason: String| Failure::from(EvaluationError::Input { path: path.clone(), reason });
        let text = std::fs::read_to_string(&path).map_err(|error| fail(error.to_string()))?;
        serde_json::from_str(&text).map_err(|error| fail(error.to_string()))
    }
}
