//! Keys of every experiment on scenes.

use crate::error::EvaluationError;
use crate::experiment::keys::in_key;
use applications::BiasSetting;
use serde::{Deserialize, Serialize};
use shadow_filtering::{DepthBias, Kernel, KernelSpec, Reference};

/// Largest accepted side of a shadow map.
pub(crate) const MAX_SIZE: u32 = 8192;

/// The keys that all experiments on scenes have; they stand beside the keys of the kind.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SceneSettings {
    /// Names of procedural scenes, or files.
    #[serde(default)]
    pub scenes: Vec<String>,
    /// Names of light views; empty for all of a scene.
    #[serde(default)]
    pub views: Vec<String>,
    /// Side of the square shadow map in texels.
    pub size: u32,
    /// Fragments a view, spread evenly over all; 0 for all.
    pub fragments: usize,
    /// The filter.
    pub kernel: KernelSpec,
    /// Largest difference between the receiver's depth and its tangent plane at a tap, and largest slope that a bias takes
    /// into account.
    pub plane_limit: f64,
}

impl Default for SceneSettings {
    /// Nothing; stands in until the keys are read.
    fn default() -> Self {
        let (scenes, views) = (Vec::new(), Vec::new());
        Self { scenes, views, size: 0, fragments: 0, kernel: KernelSpec::Box { size: 1 }, plane_limit: 0.0 }
    }
}

impl SceneSettings {
    /// The keys.
    pub(crate) const KEYS: [&'static str; 6] =
        ["scenes", "views", "size", "fragments", "kernel", "plane_limit"];

    /// Rejects maps that are no maps, and kernels that do not fit them.
    pub(crate) fn check(&self, needs_scenes: bool) -> Result<(), EvaluationError> {
        if !(1..=MAX_SIZE).contains(&self.size) {
            let reason = format!("size = {} is not between 1 and {MAX_SIZE}", self.size);
            return Err(EvaluationError::key("size", reason));
        }
        if needs_scenes && self.scenes.is_empty() {
            return Err(EvaluationError::key("scenes", "scenes is empty"));
        }
        let plane = Reference { bias: DepthBias::default(), plane_limit: self.plane_limit };
        plane.check().map_err(in_key(""))?;
        self.check_kernel(&self.kernel, "kernel")
    }

    /// Rejects kernels that cannot be built, or are larger than the map.
    pub(crate) fn check_kernel(&self, kernel: &KernelSpec, place: &str) -> Result<(), EvaluationError> {
        let built = kernel.build().map_err(in_key(place))?;
        if built.size() > self.size as usize {
            let reason = format!("{place}.size = {} exceeds the map's size = {}", built.size(), self.size);
            return Err(EvaluationError::key(format!("{place}.size"), reason));
        }
        Ok(())
    }

    /// The filter.
    pub(crate) fn filter(&self) -> Result<Kernel, EvaluationError> {
        self.kernel.build().map_err(in_key("kernel"))
    }
}

/// Rejects biases that are negative or not finite.
pub(crate) fn check_bias(bias: &BiasSetting, place: &str) -> Result<(), EvaluationError> {
    bias.reference.check().map_err(in_key(&format!("{place}.reference")))?;
    bias.technique.check().map_err(in_key(&format!("{place}.technique")))
}
