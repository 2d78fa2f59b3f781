//! The TOML keys of the kind `quantization`.

use crate::experiment::Alphas;
use crate::fragments::SceneSettings;
use applications::BiasSetting;
use quantization::Structure;
use serde::{Deserialize, Serialize};
use shadow_filtering::{KernelSpec, Range, TechniqueSpec};

/// The TOML keys of this kind, beside `kind` and `scale`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct QuantizationExperiment {
    /// Scenes, shadow maps and filter; its keys stand beside the others.
    #[serde(skip)]
    pub scenery: SceneSettings,
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

impl QuantizationExperiment {
    /// The filter of a way to store moments.
    pub(crate) fn kernel_of(&self, store: &StoreSetting) -> KernelSpec {
        store.kernel.unwrap_or(self.scenery.kernel)
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
