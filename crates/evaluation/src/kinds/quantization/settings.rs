//! The TOML keys of the kind `quantization`.

use super::variant::Variant;
use crate::error::EvaluationError;
use crate::experiment::keys::in_key;
use crate::experiment::kind::{RunContext, Settings};
use crate::fragments::{SceneSettings, check_bias};
use crate::run::Recorded;
use applications::BiasSetting;
use moment_problem::Basis;
use quantization::Structure;
use serde::{Deserialize, Serialize};
use shadow_filtering::{KernelSpec, Range, TechniqueSpec};

/// The TOML keys of this kind, beside `kind` and `scale`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct QuantizationExperiment {
    /// What is asked.
    pub question: String,
    /// What is expected, written before the first run.
    pub expectation: String,
    /// Scenes, shadow maps and filter; its keys stand beside the others.
    #[serde(skip)]
    pub scenery: SceneSettings,
    /// Seed of the sample of fragments and of the starts of the optimiser.
    pub seed: u64,
    /// Kernels, spread evenly over all fragments, for which b* is to raise det B fastest.
    pub workload: usize,
    /// Depth biases of F and of all techniques.
    pub bias: BiasSetting,
    /// Moment biases that are tried.
    pub alphas: Alphas,
    /// Points of the curves whose hulls are drawn (MSM15 Figure 5).
    pub hull_points: usize,
    /// Bins of the histograms of stored codes.
    pub code_bins: usize,
    /// Transforms that are optimised.
    #[serde(default)]
    pub gain: Vec<GainSetting>,
    /// Ways to store moments.
    #[serde(default)]
    pub technique: Vec<StoreSetting>,
}

/// Moment biases, the same number in every power of ten.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Alphas {
    /// Least.
    pub from: f64,
    /// Largest, below 1.
    pub to: f64,
    /// Steps in a power of ten.
    pub per_decade: usize,
}

/// One transform to be optimised.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct GainSetting {
    /// The basis as on the command line.
    pub basis: String,
    /// Dense or even and odd rows.
    #[serde(default)]
    pub structure: StructureName,
    /// Depths.
    #[serde(default)]
    pub range: Range,
    /// Random starts; without it as many as the order needs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub starts: Option<usize>,
}

/// Structure of a transform.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum StructureName {
    /// Any matrix.
    #[default]
    Dense,
    /// Rows even or odd about the middle.
    Parity,
}

/// Where b* comes from.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BiasTarget {
    /// Raises det B fastest on the workload.
    Fastest,
    /// Half of the mass at each end of the depth range (MSM15 section 4.2).
    Ends,
    /// The values in circulation for this basis, range and format; nothing where there are none.
    Circulated,
}

/// A bound in all combinations of the listed transforms and formats.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct StoreSetting {
    /// Bound, transforms and formats.
    pub method: TechniqueSpec,
    /// Biases that are compared.
    pub targets: Vec<BiasTarget>,
    /// Another filter than the experiment's, for F as well; not larger.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kernel: Option<KernelSpec>,
    /// The transform with which the others are compared, each at its own best bias.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline: Option<String>,
    /// Whether stored codes are counted.
    #[serde(default)]
    pub codes: bool,
}

impl Settings for QuantizationExperiment {
    const KIND: &'static str = "quantization";
    const ON_SCENES: bool = true;

    fn seed(&self) -> u64 {
        self.seed
    }

    fn check(&self) -> Result<(), EvaluationError> {
        let fail = |key: &str, reason: String| Err(EvaluationError::Key { key: key.to_owned(), reason });
        self.scenery.check(!self.technique.is_empty())?;
        for (key, value, least) in [
            ("workload", self.workload, 1),
            ("hull_points", self.hull_points, 2),
            ("code_bins", self.code_bins, 2),
        ] {
            if value < least {
                return fail(key, format!("{key}: {value} is less than {least}"));
            }
        }
        self.alphas.check()?;
        let kernel = self.scenery.filter()?;
        check_bias(&self.bias, "bias")?;
        for (i, gain) in self.gain.iter().enumerate() {
            let key = format!("gain[{i}].basis");
            if let Err(error) = gain.basis.parse::<Basis>() {
                return fail(&key, format!("basis = `{}`: {error}", gain.basis));
            }
            if gain.starts == Some(0) {
                let key = format!("gain[{i}].starts");
                return fail(&key, format!("{key} = 0 finds nothing"));
            }
        }
        for (i, store) in self.technique.iter().enumerate() {
            let place = format!("technique[{i}]");
            for (key, empty) in [
                ("method.transforms", store.method.transforms.is_empty()),
                ("method.formats", store.method.formats.is_empty()),
                ("targets", store.targets.is_empty()),
            ] {
                if empty {
                    let key = format!("{place}.{key}");
                    return fail(&key, format!("{key} is empty"));
                }
            }
            if let Some(baseline) =
                store.baseline.as_ref().filter(|name| !store.method.transforms.contains(name))
            {
                let key = format!("{place}.baseline");
                return fail(&key, format!("{key} = \"{baseline}\" is none of the transforms"));
            }
            let own = self.kernel_of(store).build().map_err(in_key(&format!("{place}.kernel")))?;
            if own.size() > kernel.size() {
                let key = format!("{place}.kernel.size");
                let reason = format!("{key} = {} exceeds kernel.size = {}", own.size(), kernel.size());
                return fail(&key, reason);
            }
        }
        Variant::check(self)
    }

    fn scenery(&self) -> Option<&SceneSettings> {
        Some(&self.scenery)
    }

    fn scenery_mut(&mut self) -> Option<&mut SceneSettings> {
        Some(&mut self.scenery)
    }

    fn run(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        self.evaluate(context)
    }
}

impl QuantizationExperiment {
    /// The filter of a way to store moments.
    pub(crate) fn kernel_of(&self, store: &StoreSetting) -> KernelSpec {
        store.kernel.unwrap_or(self.scenery.kernel)
    }
}

impl Alphas {
    /// Rejects what is no scale between 0 and 1.
    pub(crate) fn check(&self) -> Result<(), EvaluationError> {
        let Self { from, to, per_decade } = *self;
        if from > 0.0 && from <= to && to < 1.0 && per_decade > 0 {
            return Ok(());
        }
        let reason = format!(
            "alphas: from = {from}, to = {to}, per_decade = {per_decade} are no steps between 0 and 1"
        );
        Err(EvaluationError::Key { key: "alphas".to_owned(), reason })
    }

    /// All of them, ascending; the last is `to`.
    pub fn values(&self) -> Vec<f64> {
        let decades = (self.to / self.from).log10();
        let steps = (decades * self.per_decade as f64).round() as usize;
        let at = |i: usize| self.from * 10f64.powf(decades * i as f64 / steps.max(1) as f64);
        (0..=steps).map(at).collect()
    }
}

impl From<StructureName> for Structure {
    fn from(name: StructureName) -> Self {
        match name {
            StructureName::Dense => Self::Dense,
            StructureName::Parity => Self::Parity,
        }
    }
}

impl BiasTarget {
    /// Name in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fastest => "fastest",
            Self::Ends => "ends",
            Self::Circulated => "circulated",
        }
    }
}
