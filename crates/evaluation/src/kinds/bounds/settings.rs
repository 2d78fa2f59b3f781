//! The keys of an experiment of kind `bounds`.

use crate::error::EvaluationError;
use crate::experiment::kind::{RunContext, Settings};
use crate::kernel::Kernel;
use crate::run::Recorded;
use moment_problem::Basis;
use moment_problem::{Interval, Method, Solver, method};
use serde::{Deserialize, Serialize};

/// Largest accepted number of fragment depths.
const MAX_DEPTHS: usize = 100_001;

/// The TOML keys of this kind, beside `kind` and `scale`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BoundsExperiment {
    /// What is asked.
    pub question: String,
    /// What is expected, written before the first run.
    pub expectation: String,
    /// Seed of rough and scattered surfaces.
    pub seed: u64,
    /// Number of fragment depths, evenly spaced from 0 to 1.
    pub depths: usize,
    /// What is timed after all errors are known.
    pub timing: Timing,
    /// The kernels.
    pub kernel: Vec<Kernel>,
    /// The figures.
    pub figure: Vec<Figure>,
}

/// Timed bounds per kernel and technique.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Timing {
    /// Fragment depths, spread over the recorded ones.
    pub depths: usize,
    /// How often each is timed.
    pub repetitions: usize,
}

/// One figure: techniques on kernels.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// File name without extension, and its name in the records.
    pub id: String,
    /// Title.
    pub title: String,
    /// Number of fragment depths in place of the experiment's.
    pub depths: Option<usize>,
    /// Kernels, one column of charts each.
    pub kernels: Vec<String>,
    /// Techniques.
    pub technique: Vec<Technique>,
    /// Arrows at fragment depths.
    #[serde(default)]
    pub mark: Vec<Mark>,
}

/// A basis, its interval and the method.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Technique {
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
pub struct Mark {
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
        let fail = |reason: String| Err(EvaluationError::Value(reason));
        for depths in [self.depths].into_iter().chain(self.figure.iter().filter_map(|figure| figure.depths)) {
            if !(2..=MAX_DEPTHS).contains(&depths) {
                return fail(format!("depths = {depths} is not between 2 and {MAX_DEPTHS}"));
            }
        }
        for (i, kernel) in self.kernel.iter().enumerate() {
            if self.kernel[..i].iter().any(|other| other.id == kernel.id) {
                return fail(format!("kernel `{}` appears twice", kernel.id));
            }
            kernel.depths(self.seed, i)?;
        }
        for (i, figure) in self.figure.iter().enumerate() {
            if self.figure[..i].iter().any(|other| other.id == figure.id) {
                return fail(format!("figure `{}` appears twice", figure.id));
            }
            let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
            if figure.id.is_empty() || !figure.id.chars().all(plain) {
                return fail(format!("figure id `{}` is no file name of letters, digits and -", figure.id));
            }
            for id in &figure.kernels {
                self.kernel_index(id)?;
            }
            for (j, technique) in figure.technique.iter().enumerate() {
                if figure.technique[..j].iter().any(|other| other.name == technique.name) {
                    return fail(format!("technique `{}` appears twice in one figure", technique.name));
                }
                technique.basis()?;
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

impl Technique {
    /// The basis.
    pub fn basis(&self) -> Result<Basis, EvaluationError> {
        self.basis.parse().map_err(|error: moment_problem::BasisError| self.failure(error.into()))
    }

    pub(super) fn method(&self) -> Result<Method, EvaluationError> {
        method(&self.basis()?, self.interval, self.solver).map_err(|error| self.failure(error))
    }

    fn failure(&self, source: moment_problem::MomentError) -> EvaluationError {
        EvaluationError::Technique { technique: self.name.clone(), source }
    }
}
