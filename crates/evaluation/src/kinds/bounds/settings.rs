//! The keys of an experiment of kind `bounds`.

use super::kernel::SyntheticKernel;
use crate::error::EvaluationError;
use crate::experiment::keys::{file_name, unique};
use crate::experiment::kind::{RunContext, Settings};
use crate::run::Recorded;
use moment_problem::Basis;
use moment_problem::{BoundMethod, Interval, Solver, method};
use serde::{Deserialize, Serialize};

/// Largest accepted number of fragment depths.
const MAX_DEPTHS: usize = 100_001;

/// The TOML keys of this kind, beside `kind` and `scale`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BoundsExperiment {
    /// Seed of rough and scattered surfaces.
    pub seed: u64,
    /// Number of fragment depths, evenly spaced from 0 to 1.
    pub depths: usize,
    /// What is timed after all errors are known.
    pub timing: BoundsTiming,
    /// The kernels.
    pub kernel: Vec<SyntheticKernel>,
    /// The figures.
    pub figure: Vec<BoundsFigure>,
}

/// Timed bounds per kernel and technique.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BoundsTiming {
    /// Fragment depths, spread over the recorded ones.
    pub depths: usize,
    /// How often each is timed.
    pub repetitions: usize,
}

/// One figure: techniques on kernels.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BoundsFigure {
    /// File name without extension, and its name in the records.
    pub id: String,
    /// Title.
    pub title: String,
    /// Number of fragment depths in place of the experiment's.
    pub depths: Option<usize>,
    /// Kernels, one column of charts each.
    pub kernels: Vec<String>,
    /// Techniques.
    pub technique: Vec<BoundsTechnique>,
    /// Arrows at fragment depths.
    #[serde(default)]
    pub mark: Vec<BoundsMark>,
}

/// A basis, its interval and the method.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BoundsTechnique {
    /// Name in records and legends.
    pub name: String,
    /// Techniques of one panel share a row of charts.
    pub panel: String,
    /// The basis as on the command line.
    pub basis: String,
    /// Admissible depths.
    #[serde(default)]
    pub interval: Interval,
    /// The solver; without it the closed form or the exchange simplex.
    pub solver: Option<Solver>,
}

/// An arrow in a chart.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BoundsMark {
    /// Fragment depth it points at.
    pub depth: f64,
    /// Whether the shadow is right there.
    pub correct: bool,
    /// What it says.
    pub text: String,
}

impl Settings for BoundsExperiment {
    const KIND: &'static str = "bounds";

    fn seed(&self) -> u64 {
        self.seed
    }

    fn check(&self) -> Result<(), EvaluationError> {
        let figures = self.figure.iter().enumerate();
        let own = figures.filter_map(|(i, figure)| Some((format!("figure[{i}].depths"), figure.depths?)));
        for (key, depths) in [("depths".to_owned(), self.depths)].into_iter().chain(own) {
            if !(2..=MAX_DEPTHS).contains(&depths) {
                let reason = format!("{key} = {depths} is not between 2 and {MAX_DEPTHS}");
                return Err(EvaluationError::key(key, reason));
            }
        }
        unique(("kernel", "id", "kernel"), self.kernel.iter().map(|kernel| kernel.id.as_str()))?;
        for (i, kernel) in self.kernel.iter().enumerate() {
            kernel.depths(self.seed, i)?;
        }
        unique(("figure", "id", "figure"), self.figure.iter().map(|figure| figure.id.as_str()))?;
        for (i, figure) in self.figure.iter().enumerate() {
            file_name(&format!("figure[{i}].id"), "figure", &figure.id)?;
            for (j, id) in figure.kernels.iter().enumerate() {
                let undefined = |error: EvaluationError| {
                    EvaluationError::key(format!("figure[{i}].kernels[{j}]"), error.to_string())
                };
                self.kernel_index(id).map_err(undefined)?;
            }
            let list = format!("figure[{i}].technique");
            unique((&list, "name", "technique"), figure.technique.iter().map(|t| t.name.as_str()))?;
            for (j, technique) in figure.technique.iter().enumerate() {
                let fail = |error: EvaluationError| {
                    EvaluationError::key(format!("{list}[{j}].basis"), error.to_string())
                };
                technique.basis().map_err(fail)?;
            }
        }
        Ok(())
    }

    fn run(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        self.evaluate(context)
    }
}

impl BoundsExperiment {
    pub(super) fn kernel_index(&self, id: &str) -> Result<usize, EvaluationError> {
        let index = self.kernel.iter().position(|kernel| kernel.id == id);
        index.ok_or_else(|| EvaluationError::Value(format!("kernel `{id}` is not defined")))
    }
}

impl BoundsTechnique {
    /// The basis.
    pub fn basis(&self) -> Result<Basis, EvaluationError> {
        self.basis.parse().map_err(|error: moment_problem::BasisError| self.failure(error.into()))
    }

    pub(super) fn method(&self) -> Result<BoundMethod, EvaluationError> {
        method(&self.basis()?, self.interval, self.solver).map_err(|error| self.failure(error))
    }

    fn failure(&self, source: moment_problem::MomentError) -> EvaluationError {
        EvaluationError::Technique { technique: self.name.clone(), source }
    }
}
