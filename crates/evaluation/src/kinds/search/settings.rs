//! The TOML keys of a candidate search.

use super::run::Prediction;
use crate::error::EvaluationError;
use crate::experiment::kind::{RunContext, Settings};
use crate::kinds::filterable::{BiasSetting, FilterableTechnique};
use crate::run::Recorded;
use moment_problem::fast_simplex::MAX_ROWS;
use moment_problem::{Basis, BasisFunction};
use serde::{Deserialize, Serialize};
use shadow_filtering::{FilteringError, KernelSpec, Reference};

/// Largest accepted side of a shadow map.
const MAX_SIZE: u32 = 8192;

/// Cells of the support; the upper limit keeps one program in the second-level cache.
const CELLS: std::ops::RangeInclusive<usize> = 16..=4096;

/// More candidates of one order than this do not fit in memory.
const MAX_CANDIDATES: usize = 20_000_000;

/// Blocks into which the sample is divided.
const MAX_BLOCKS: usize = 12;

/// The keys, beside `kind` and `scale`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SearchExperiment {
    /// What is asked.
    pub question: String,
    /// What is expected, written before the first run.
    pub expectation: String,
    /// Seed of the sample of fragments.
    pub seed: u64,
    /// Side of the square shadow map in texels.
    pub size: u32,
    /// Names of procedural scenes, or files.
    pub scenes: Vec<String>,
    /// Names of light views; empty for all of a scene.
    #[serde(default)]
    pub views: Vec<String>,
    /// The filter.
    pub kernel: KernelSpec,
    /// Largest difference between the receiver's depth and its tangent plane at a tap.
    pub plane_limit: f64,
    /// Biases of the compared depth and, where the reference is `plane`, of F.
    pub bias: BiasSetting,
    /// What G is compared with.
    #[serde(default)]
    pub reference: SearchReference,
    /// The functions that candidates are made of: formulas, the whole default family when empty.
    #[serde(default)]
    pub family: Vec<String>,
    /// Sizes m of the subsets.
    pub orders: Vec<usize>,
    /// Fragments a view in the first block, which every candidate is judged on.
    pub fragments: usize,
    /// Number of blocks; from the second on each holds as many fragments as all before it.
    pub blocks: usize,
    /// How many of the best candidates the later blocks are for.
    pub best: usize,
    /// Cells of the uniform support to whose ends depths are moved.
    pub cells: usize,
    /// Largest distance between a bound and what is proved, as intensity.
    pub tolerance: f64,
    /// Closed-form techniques on the same fragments, for the chart and for what moving depths changes.
    #[serde(default)]
    pub mark: Vec<FilterableTechnique>,
    /// Comparison with an independent solution of the same programs.
    pub agreement: SearchAgreement,
    /// Timing against good_lp.
    pub timing: SearchTiming,
}

/// F of a fragment.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SearchReference {
    /// F_Z at the depth that is compared: the error is what the bound loses, and that of percentage-closer filtering
    /// without a receiver plane is 0.
    #[default]
    Plain,
    /// Percentage-closer filtering with the receiver plane, as in experiments of kind `filterable`.
    Plane,
}

/// Bases drawn at random from the candidates and compared fragment by fragment.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SearchAgreement {
    /// Number of bases.
    pub bases: usize,
    /// Fragments of each.
    pub fragments: usize,
}

/// What is timed once the records are complete, alone on one thread.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SearchTiming {
    /// Repetitions.
    pub repetitions: usize,
    /// Bases of four functions, spread over the candidates.
    pub bases: usize,
    /// Fragments for good_lp with microlp, which is slow.
    pub microlp_fragments: usize,
}

impl Settings for SearchExperiment {
    const KIND: &'static str = "search";
    const IS_RESUMABLE: bool = true;

    fn seed(&self) -> u64 {
        self.seed
    }

    fn check(&self) -> Result<(), EvaluationError> {
        let fail = |reason: String| Err(EvaluationError::Value(reason));
        let within = |key: &str, value: usize, range: std::ops::RangeInclusive<usize>| {
            if range.contains(&value) {
                return Ok(());
            }
            let reason = format!("{key} = {value} is not between {} and {}", range.start(), range.end());
            Err(EvaluationError::Value(reason))
        };
        within("size", self.size as usize, 1..=MAX_SIZE as usize)?;
        within("cells", self.cells, CELLS)?;
        within("fragments", self.fragments, 1..=1 << 24)?;
        within("blocks", self.blocks, 1..=MAX_BLOCKS)?;
        within("best", self.best, 1..=10_000)?;
        within("timing.repetitions", self.timing.repetitions, 1..=1000)?;
        if self.scenes.is_empty() {
            return fail("scenes is empty".to_owned());
        }
        if !(1e-9..=1e-2).contains(&self.tolerance) {
            return fail(format!("tolerance = {} is not between 1e-9 and 1e-2", self.tolerance));
        }
        let in_key = |key: &'static str| {
            move |error: FilteringError| EvaluationError::Value(format!("{key}: {error}"))
        };
        self.kernel.build().map_err(in_key("kernel"))?;
        self.reference().check().map_err(in_key("bias.reference"))?;
        self.bias.technique.check().map_err(in_key("bias.technique"))?;
        let family = self.functions()?;
        if self.orders.is_empty() {
            return fail("orders is empty".to_owned());
        }
        for (i, &order) in self.orders.iter().enumerate() {
            within("orders: m", order, 1..=MAX_ROWS - 1)?;
            if order > family.len() {
                return fail(format!(
                    "orders: m = {order} is larger than the family, which has {} functions",
                    family.len()
                ));
            }
            if self.orders[..i].contains(&order) {
                return fail(format!("orders: m = {order} appears twice"));
            }
            let count = super::candidates::binomial(family.len(), order);
            if count > MAX_CANDIDATES as u64 {
                return fail(format!(
                    "orders: {count} subsets of {order} of {} functions are more than {MAX_CANDIDATES}",
                    family.len()
                ));
            }
        }
        for (i, mark) in self.mark.iter().enumerate() {
            if self.mark[..i].iter().any(|other| other.name == mark.name) {
                return fail(format!("mark `{}` appears twice", mark.name));
            }
            if mark.method.is_none() || mark.is_certified() {
                return fail(format!("mark `{}` needs a `method` in closed form", mark.name));
            }
            if let Some(method) = &mark.method {
                method.build().map_err(|error| mark.failure(error))?;
            }
        }
        Ok(())
    }

    fn scenes(&self) -> Option<&[String]> {
        Some(&self.scenes)
    }

    fn replace_scenes(&mut self, scenes: &[String]) {
        self.scenes = scenes.to_vec();
        self.views.clear();
    }

    fn run(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        self.evaluate(context)
    }

    fn predict(&self, threads: usize) -> Option<Result<Prediction, EvaluationError>> {
        Some(self.predict(threads))
    }
}

impl SearchExperiment {
    /// The family.
    ///
    /// # Errors
    /// [`EvaluationError::Value`] naming a formula that is no function on \[0, 1\] or appears twice.
    pub fn functions(&self) -> Result<Vec<BasisFunction>, EvaluationError> {
        if self.family.is_empty() {
            return Ok(Basis::default_family());
        }
        let mut functions: Vec<BasisFunction> = Vec::new();
        for formula in &self.family {
            let function: BasisFunction =
                formula.parse().map_err(|error| EvaluationError::Value(format!("family: {error}")))?;
            if let Some(other) = functions.iter().find(|other| **other == function) {
                let reason =
                    format!("family: basis function `{formula}` appears twice, as `{}`", other.name());
                return Err(EvaluationError::Value(reason));
            }
            functions.push(function);
        }
        Ok(functions)
    }

    /// How F is computed with a receiver plane.
    pub(crate) fn reference(&self) -> Reference {
        Reference { bias: self.bias.reference, plane_limit: self.plane_limit }
    }

    /// Fragments a view over all blocks.
    pub fn sampled(&self) -> usize {
        self.fragments << (self.blocks - 1)
    }
}
