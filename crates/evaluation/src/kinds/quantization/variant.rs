//! One way to store moments: bound, transform, format, filter.

use super::settings::{BiasTarget, QuantizationExperiment, RangeName, StoreSetting};
use crate::error::EvaluationError;
use moment_problem::arithmetic::DoubleDouble;
use quantization::bias::{CIRCULATED, Circulated};
use quantization::published::Published;
use quantization::{
    AffineTransform, DepthInterval, NumberFormat, QuantizationError, Search, optimise, range,
};
use shadow_filtering::techniques::MomentBound;
use shadow_filtering::{Kernel, KernelSpec, StoredMoments};

/// A bound with the storage of its moments, and the names of both.
pub(crate) struct Variant {
    pub(crate) store: usize,
    pub(crate) transform: String,
    pub(crate) format: String,
    pub(crate) kernel_name: String,
    pub(crate) kernel: Kernel,
    pub(crate) storage: StoredMoments,
    pub(crate) targets: Vec<BiasTarget>,
    pub(crate) codes: bool,
}

/// Transforms that are not constants.
#[derive(Clone, Copy)]
enum Computed {
    Plain,
    Optimal,
}

type Compute<'a> =
    &'a dyn Fn(Computed, MomentBound, DepthInterval) -> Result<AffineTransform, QuantizationError>;

impl Variant {
    /// All combinations in the order of the file.
    pub(crate) fn all(experiment: &QuantizationExperiment) -> Result<Vec<Self>, EvaluationError> {
        Self::build(experiment, &|name, bound, interval| match name {
            Computed::Plain => plain(bound, interval),
            Computed::Optimal => {
                let search = Search { seed: experiment.seed, ..Search::default() };
                optimise(&bound.basis(), interval, &search).map(|optimum| optimum.transform)
            }
        })
    }

    /// Rejects names that are unknown and combinations that do not work, without computing any transform.
    pub(crate) fn check(experiment: &QuantizationExperiment) -> Result<(), EvaluationError> {
        Self::build(experiment, &|_, bound, _| Ok(AffineTransform::identity(bound.order()))).map(|_| ())
    }

    fn build(
        experiment: &QuantizationExperiment,
        compute: Compute<'_>,
    ) -> Result<Vec<Self>, EvaluationError> {
        let mut variants = Vec::new();
        for (i, store) in experiment.store.iter().enumerate() {
            let key = |name: &str, j: usize| format!("store[{i}].{name}[{j}]");
            let fail = |key: String, value: &str, reason: String| EvaluationError::Key {
                reason: format!("{key} = \"{value}\": {reason}"),
                key,
            };
            let spec = experiment.kernel_of(store);
            let kernel = spec.build().map_err(|error| EvaluationError::Value(error.to_string()))?;
            for (j, name) in store.transforms.iter().enumerate() {
                let at_transform = |reason: String| fail(key("transforms", j), name, reason);
                let (transform, interval) = transform(store, name, compute).map_err(at_transform)?;
                for (k, format_name) in store.formats.iter().enumerate() {
                    let at_format = |reason: String| fail(key("formats", k), format_name, reason);
                    let format: NumberFormat = format_name
                        .parse()
                        .map_err(|error: QuantizationError| at_format(error.to_string()))?;
                    let storage = StoredMoments::new(store.bound, interval, transform.clone(), format)
                        .map_err(|error| at_transform(error.to_string()))?;
                    storage.check_kernel(&kernel).map_err(|error| at_format(error.to_string()))?;
                    variants.push(Self {
                        store: i,
                        transform: name.clone(),
                        format: format_name.clone(),
                        kernel_name: kernel_name(&spec),
                        kernel: kernel.clone(),
                        storage,
                        targets: store.targets.clone(),
                        codes: store.codes,
                    });
                }
            }
        }
        Ok(variants)
    }

    pub(crate) fn bound_name(&self) -> &'static str {
        self.storage.bound().name()
    }

    /// The bias in circulation for its basis, range and format.
    pub(crate) fn circulated(&self) -> Option<&'static Circulated> {
        let basis = self.storage.bound().basis_name();
        let signed = self.storage.interval() == DepthInterval::SIGNED;
        // Every fixed-point format of a summed-area table stands for the one that was published.
        let format = if self.format.starts_with("u32/") { "u32/" } else { &self.format };
        CIRCULATED.iter().find(|c| c.basis == basis && c.signed == signed && c.format.starts_with(format))
    }

    pub(crate) fn range_name(&self) -> String {
        RangeName::of(self.storage.interval())
    }
}

fn kernel_name(spec: &KernelSpec) -> String {
    match spec {
        KernelSpec::Gaussian { size, .. } => format!("gaussian {size}"),
        KernelSpec::Box { size } => format!("box {size}"),
        KernelSpec::Binomial { size } => format!("binomial {size}"),
    }
}

fn transform(
    store: &StoreSetting,
    name: &str,
    compute: Compute<'_>,
) -> Result<(AffineTransform, DepthInterval), String> {
    let (bound, interval) = (store.bound, store.range.interval());
    let text = |error: QuantizationError| error.to_string();
    match name {
        "identity" => Ok((AffineTransform::identity(bound.order()), interval)),
        "plain" => Ok((compute(Computed::Plain, bound, interval).map_err(text)?, interval)),
        "optimal" => Ok((compute(Computed::Optimal, bound, interval).map_err(text)?, interval)),
        _ => published(name, bound, &["identity", "plain", "optimal"]),
    }
}

/// A published transform with its depths, or why there is none; `others` are known besides.
pub(crate) fn published(
    name: &str,
    bound: MomentBound,
    others: &[&str],
) -> Result<(AffineTransform, DepthInterval), String> {
    let Some(published) = Published::named(name) else {
        let all = quantization::published::ALL;
        let known: Vec<&str> = others.iter().copied().chain(all.iter().map(|p| p.name)).collect();
        return Err(format!("unknown transform (known: {})", known.join(", ")));
    };
    if bound.is_trigonometric() {
        return Err("is a transform of power moments".to_owned());
    }
    Ok((published.transform().map_err(|error| error.to_string())?, published.interval()))
}

/// Each function stretched to \[0, 1\] by itself.
fn plain(bound: MomentBound, interval: DepthInterval) -> Result<AffineTransform, QuantizationError> {
    let basis = bound.basis();
    let m = basis.len();
    let (mut matrix, mut offset) = (vec![0.0; m * m], vec![0.0; m]);
    for i in 0..m {
        let mut coefficients = vec![DoubleDouble::from(0.0); m + 1];
        coefficients[i + 1] = DoubleDouble::from(1.0);
        let range = range(&basis, &coefficients, interval);
        let (min, max) = (range.min, range.max);
        matrix[i * m + i] = 1.0 / (max - min);
        offset[i] = -min / (max - min);
    }
    AffineTransform::new(matrix, offset)
}
