//! Keys of every experiment on scenes.

use crate::error::EvaluationError;
use crate::experiment::keys::{in_key, words};
use applications::BiasSetting;
use serde::{Deserialize, Serialize};
use shadow_filtering::{DepthBias, Kernel, KernelSpec, Reference};
use std::path::{Component, Path};

/// Largest accepted side of a shadow map.
pub(crate) const MAX_SIZE: u32 = 8192;

/// The keys that all experiments on scenes have; they stand beside the keys of the kind.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SceneSettings {
    /// Seed of the sample of fragments, and of all else that is random.
    pub seed: u64,
    /// Names of procedural scenes, or files.
    #[serde(default)]
    pub scenes: Vec<String>,
    /// Names of light views; empty for all of a scene whose light has no extent.
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
        let kernel = KernelSpec::Box { size: 1 };
        Self { seed: 0, scenes, views, size: 0, fragments: 0, kernel, plane_limit: 0.0 }
    }
}

impl SceneSettings {
    /// The keys.
    pub(crate) const KEYS: [&'static str; 7] =
        ["seed", "scenes", "views", "size", "fragments", "kernel", "plane_limit"];

    /// Rejects maps that are no maps, and kernels that do not fit them.
    pub(crate) fn check(&self, needs_scenes: bool) -> Result<(), EvaluationError> {
        if !(1..=MAX_SIZE).contains(&self.size) {
            let reason = format!("size = {} is not between 1 and {MAX_SIZE}", self.size);
            return Err(EvaluationError::key("size", reason));
        }
        if needs_scenes && self.scenes.is_empty() {
            return Err(EvaluationError::key("scenes", "scenes is empty"));
        }
        for (key, names) in [("scenes", &self.scenes), ("views", &self.views)] {
            if let Some((i, name)) = names.iter().enumerate().find(|(i, name)| names[..*i].contains(name)) {
                return Err(EvaluationError::key(
                    format!("{key}[{i}]"),
                    format!("{key}: `{name}` stands there twice"),
                ));
            }
        }
        let plane = Reference { bias: DepthBias::default(), plane_limit: self.plane_limit };
        plane.check().map_err(in_key(""))?;
        self.check_kernel(&self.kernel, "kernel")
    }

    /// The words of a scene's name or of its file's stem, with hyphens between them; where other scenes share it, those of as
    /// many folders above it as tell it apart.
    pub fn words(&self, scene: &str) -> String {
        let parts = |scene: &str| -> Vec<String> {
            let path = Path::new(scene).with_extension("");
            let parts = path.components().filter(|part| matches!(part, Component::Normal(_)));
            parts.map(|part| words(&part.as_os_str().to_string_lossy())).collect()
        };
        let tail = |parts: &[String], length: usize| parts[parts.len().saturating_sub(length)..].join("-");
        let own = parts(scene);
        let others: Vec<Vec<String>> =
            self.scenes.iter().filter(|other| *other != scene).map(|other| parts(other)).collect();
        let is_free = |length: &usize| {
            let taken = |other: &Vec<String>| (1..=*length).any(|n| tail(other, n) == tail(&own, *length));
            !others.iter().any(taken)
        };
        match (1..=own.len()).find(is_free) {
            Some(length) => tail(&own, length),
            None => {
                let number = self.scenes.iter().position(|other| other == scene).unwrap_or_default() + 1;
                format!("{}-{number}", own.join("-"))
            }
        }
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

#[cfg(test)]
mod tests {
    use super::SceneSettings;

    #[test]
    fn scenes_of_one_file_name_are_told_apart_by_their_folders() {
        let named = |scenes: &[&str]| SceneSettings {
            scenes: scenes.iter().map(|&scene| scene.to_owned()).collect(),
            ..SceneSettings::default()
        };
        let scenes = ["a/scene.gltf", "b/scene.gltf", "stairs", "x y/b.glb", "x/y/b.glb"];
        let settings = named(&scenes);
        let names = scenes.map(|scene| settings.words(scene));
        assert_eq!(names, ["a-scene", "b-scene", "stairs", "x-y-b", "y-b"]);
        let alike = ["a b/c.glb", "a-b/c.glb"];
        assert_eq!(alike.map(|scene| named(&alike).words(scene)), ["a-b-c-1", "a-b-c-2"]);
        assert_eq!(named(&scenes[..1]).words(scenes[0]), "scene");
        assert_eq!(settings.words("../my scenes/Tower.glb"), "tower");
    }
}
