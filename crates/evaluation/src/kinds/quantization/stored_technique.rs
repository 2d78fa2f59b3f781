//! One way to store moments: bound, transform, format, filter.

use super::settings::{BiasTarget, QuantizationExperiment};
use crate::error::EvaluationError;
use crate::experiment::keys::in_key;
use moment_problem::MomentBound;
use quantization::Search;
use quantization::bias::{CIRCULATED, Circulated};
use shadow_filtering::{BiasedMoments, FilteringError, Kernel, KernelSpec, Range, Technique, TechniqueSpec};

/// A technique with its filter, and the names of both.
pub(crate) struct StoredTechnique {
    pub(crate) store: usize,
    pub(crate) transform: String,
    pub(crate) format: String,
    pub(crate) kernel_name: String,
    pub(crate) kernel: Kernel,
    pub(crate) range: Range,
    pub(crate) technique: Technique,
    /// Its bound.
    pub(crate) biased: BiasedMoments,
    pub(crate) targets: Vec<BiasTarget>,
    pub(crate) codes: bool,
}

impl StoredTechnique {
    /// All combinations in the order of the file.
    pub(crate) fn all(experiment: &QuantizationExperiment) -> Result<Vec<Self>, EvaluationError> {
        let search = Search { seed: experiment.scenery.seed, ..Search::default() };
        Self::build(experiment, &|spec| spec.build_with(&search))
    }

    /// Rejects names that are unknown and combinations that do not work, without computing any transform.
    pub(crate) fn check(experiment: &QuantizationExperiment) -> Result<(), EvaluationError> {
        Self::build(experiment, &TechniqueSpec::draft).map(|_| ())
    }

    fn build(
        experiment: &QuantizationExperiment,
        technique: &dyn Fn(&TechniqueSpec) -> Result<Technique, FilteringError>,
    ) -> Result<Vec<Self>, EvaluationError> {
        let mut variants = Vec::new();
        for (i, store) in experiment.technique.iter().enumerate() {
            let place = format!("technique[{i}].method");
            let kernel_spec = experiment.kernel_of(store);
            let kernel = kernel_spec.build().map_err(|error| EvaluationError::Value(error.to_string()))?;
            store.method.check_storage(&["transforms", "formats"]).map_err(in_key(&place))?;
            for spec in store.method.sweep() {
                let built = technique(&spec).and_then(|technique| {
                    technique.check_kernel(&kernel)?;
                    Ok((technique, spec.biased_moments()?, spec.stored_range()?))
                });
                let (technique, biased, range) = built.map_err(in_key(&place))?;
                let biased = biased.ok_or_else(|| {
                    let key = format!("{place}.bound");
                    EvaluationError::Key { reason: format!("{key}: only moments are biased"), key }
                })?;
                variants.push(Self {
                    store: i,
                    transform: spec.transform().to_owned(),
                    format: spec.format().name(),
                    kernel_name: kernel_name(&kernel_spec),
                    kernel: kernel.clone(),
                    range,
                    technique,
                    biased,
                    targets: store.targets.clone(),
                    codes: store.codes,
                });
            }
        }
        Ok(variants)
    }

    pub(crate) fn bound(&self) -> MomentBound {
        self.biased.bound()
    }

    /// What evaluating it costs beside others: moment matrices are inverted.
    pub(crate) fn cost(&self) -> u64 {
        let moments = self.bound().order() as u64;
        moments * moments * self.targets.len().max(1) as u64
    }

    pub(crate) fn bound_name(&self) -> &'static str {
        self.bound().name()
    }

    /// The bias in circulation for its basis, range and format.
    pub(crate) fn circulated(&self) -> Option<&'static Circulated> {
        let (basis, signed) = (self.bound().basis_name(), self.range == Range::Signed);
        // Every fixed-point format of a summed-area table stands for the one that was published.
        let format = if self.format.starts_with("u32/") { "u32/" } else { &self.format };
        CIRCULATED.iter().find(|c| c.basis == basis && c.signed == signed && c.format.starts_with(format))
    }
}

fn kernel_name(spec: &KernelSpec) -> String {
    match spec {
        KernelSpec::Gaussian { size, .. } => format!("gaussian {size}"),
        KernelSpec::Box { size } => format!("box {size}"),
        KernelSpec::Binomial { size } => format!("binomial {size}"),
    }
}
