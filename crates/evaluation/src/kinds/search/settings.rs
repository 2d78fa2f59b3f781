//! The TOML keys of a candidate search.

use crate::error::EvaluationError;
use crate::experiment::Prediction;
use crate::experiment::keys::{in_key, not_empty, unique};
use crate::experiment::kind::{Settings, evaluated_on_scenes};
use crate::fragments::{SceneSettings, check_bias};
use crate::kinds::filterable::FilterableTechnique;
use crate::run::Backend;
use applications::BiasSetting;
use moment_problem::fast_simplex::MAX_ROWS;
use moment_problem::{Basis, BasisFunction};
use serde::{Deserialize, Serialize};

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
    /// Scenes, shadow maps and filter; its keys stand beside the others.
    #[serde(skip)]
    pub scenery: SceneSettings,
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
    /// Number of blocks; from the second on each holds as many fragments as all before it.
    pub blocks: usize,
    /// How many of the best candidates the later blocks are for.
    pub best: usize,
    /// Rows of records.csv for each size: the best so many, and as many spread evenly over the ranks of the others; all
    /// candidates where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recorded: Option<usize>,
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
    const ON_SCENES: bool = true;
    const IS_RESUMABLE: bool = true;

    fn check(&self) -> Result<(), EvaluationError> {
        let within = |key: &str, value: usize, range: std::ops::RangeInclusive<usize>| {
            if range.contains(&value) {
                return Ok(());
            }
            let reason = format!("{key} = {value} is not between {} and {}", range.start(), range.end());
            Err(EvaluationError::key(key, reason))
        };
        self.scenery.check(true)?;
        within("cells", self.cells, CELLS)?;
        within("fragments", self.scenery.fragments, 1..=1 << 24)?;
        within("blocks", self.blocks, 1..=MAX_BLOCKS)?;
        within("best", self.best, 1..=10_000)?;
        if let Some(recorded) = self.recorded {
            within("recorded", recorded, self.best..=MAX_CANDIDATES)?;
        }
        within("timing.repetitions", self.timing.repetitions, 1..=1000)?;
        if !(1e-9..=1e-2).contains(&self.tolerance) {
            let reason = format!("tolerance = {} is not between 1e-9 and 1e-2", self.tolerance);
            return Err(EvaluationError::key("tolerance", reason));
        }
        check_bias(&self.bias, "bias")?;
        let family = self.functions()?;
        not_empty([("orders", self.orders.is_empty())])?;
        for (i, &order) in self.orders.iter().enumerate() {
            let key = format!("orders[{i}]");
            let fail = |reason: String| Err(EvaluationError::key(&key, format!("orders: {reason}")));
            let size = family.len();
            if !(1..MAX_ROWS).contains(&order) {
                return fail(format!("m = {order} is not between 1 and {}", MAX_ROWS - 1));
            }
            if order > size {
                return fail(format!("m = {order} is larger than the family, which has {size} functions"));
            }
            if self.orders[..i].contains(&order) {
                return fail(format!("m = {order} appears twice"));
            }
            let count = super::candidates::binomial(size, order);
            if count > MAX_CANDIDATES as u64 {
                let most = MAX_CANDIDATES;
                return fail(format!("{count} subsets of {order} of {size} functions are more than {most}"));
            }
        }
        unique(("mark", "name", "mark"), self.mark.iter().map(|mark| mark.name.as_str()))?;
        for (i, mark) in self.mark.iter().enumerate() {
            match &mark.method {
                Some(method) if !mark.is_certified() => {
                    method.build().map_err(in_key(&format!("mark[{i}].method")))?;
                }
                Some(_) | None => {
                    let reason = format!("mark `{}` needs a `method` in closed form", mark.name);
                    return Err(EvaluationError::key(format!("mark[{i}]"), reason));
                }
            }
        }
        Ok(())
    }

    evaluated_on_scenes!();

    fn make_exhaustive(&mut self, scenery: &mut SceneSettings) -> bool {
        // One block of all fragments: nobody leaves before its end.
        scenery.fragments = self.sampled();
        self.blocks = 1;
        true
    }

    fn rounds(&self) -> usize {
        self.blocks
    }

    fn predict(&self, threads: usize, backend: Backend) -> Option<Result<Prediction, EvaluationError>> {
        Some(self.predict(threads, backend))
    }
}

impl SearchExperiment {
    /// The family.
    ///
    /// # Errors
    /// [`EvaluationError::Key`] naming a formula that is no function on \[0, 1\] or appears twice.
    pub fn functions(&self) -> Result<Vec<BasisFunction>, EvaluationError> {
        if self.family.is_empty() {
            return Ok(Basis::default_family());
        }
        let mut functions: Vec<BasisFunction> = Vec::new();
        for (i, formula) in self.family.iter().enumerate() {
            let fail =
                |reason: String| EvaluationError::key(format!("family[{i}]"), format!("family: {reason}"));
            let function: BasisFunction =
                formula.parse().map_err(|error: moment_problem::BasisError| fail(error.to_string()))?;
            if let Some(other) = functions.iter().find(|other| **other == function) {
                return Err(fail(format!("basis function `{formula}` appears twice, as `{}`", other.name())));
            }
            functions.push(function);
        }
        Ok(functions)
    }

    /// Fragments a view over all blocks.
    pub fn sampled(&self) -> usize {
        self.scenery.fragments << (self.blocks - 1)
    }
}
