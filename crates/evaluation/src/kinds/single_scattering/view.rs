//! Scenes and lights: shadow maps in light space, triangles for shadow rays, the medium.

use super::settings::SingleScatteringExperiment;
use super::standpoint::{Extent, travel};
use crate::error::EvaluationError;
use crate::fragments::{Lit, LoadedScene, Source};
use applications::rays::Triangles;
use applications::scattering::{LightAxes, LightMap, Medium};
use scenes::{LightView, Scene};
use shadow_filtering::{ChannelMap, DepthMap, Kernel, Technique};

/// A scene with what is the same under all its lights.
pub(super) struct ScatteringScene<'a> {
    pub(super) label: &'a str,
    pub(super) scene: &'a Scene,
    pub(super) lights: &'a [LightView],
    pub(super) triangles: Triangles,
    pub(super) extent: Extent,
    pub(super) medium: Medium,
}

/// A scene under a light.
pub(super) struct LitScene<'a> {
    pub(super) label: &'a str,
    pub(super) scene: &'a Scene,
    pub(super) light: &'a LightView,
    pub(super) medium: Medium,
    pub(super) axes: LightAxes,
    /// The moment shadow map that is resampled with a filter.
    pub(super) stored: ChannelMap<f64>,
    map: DepthMap,
    corner: [f64; 2],
    texel: [f64; 2],
    near: f64,
    range: f64,
}

impl<'a> ScatteringScene<'a> {
    pub(super) fn new(
        experiment: &SingleScatteringExperiment,
        index: usize,
        loaded: &'a LoadedScene<'a>,
    ) -> Result<Self, EvaluationError> {
        let key = format!("scenes[{index}]");
        let label = loaded.label;
        let fail = |reason: String| EvaluationError::key(key.as_str(), format!("scene `{label}`: {reason}"));
        let Source::Scene(scene) = &loaded.source else {
            return Err(fail("is a stack: cameras and shadow rays need triangles".to_owned()));
        };
        if let Some(light) = loaded.lights.iter().find(|light| travel(light).is_none()) {
            let reason = format!(
                "scene `{label}`: view `{}` has the light {}: rectified maps need a camera outside of the light's plane and \
                 parallel light, a sun without extent",
                light.name, light.light
            );
            return Err(EvaluationError::key("views", reason));
        }
        let triangles = Triangles::of_scene(scene).map_err(|error| fail(error.to_string()))?;
        let extent = Extent::of(scene);
        let medium = experiment.medium.of_radius(extent.radius).map_err(|error| fail(error.to_string()))?;
        Ok(Self { label, scene, lights: &loaded.lights, triangles, extent, medium })
    }
}

impl<'a> LitScene<'a> {
    /// Renders the shadow map.
    pub(super) fn new(
        loaded: &LoadedScene<'_>,
        of: &'a ScatteringScene<'a>,
        light: &'a LightView,
        (size, kernel, source): (u32, &Kernel, &Technique),
    ) -> Result<Self, EvaluationError> {
        let fail = |error: String| {
            EvaluationError::Value(format!("scene `{}`, view `{}`: {error}", of.label, light.name))
        };
        let Lit { map, frame, .. } = loaded.lit(light, size, kernel)?;
        let frame = frame.ok_or_else(|| fail("a stack has no frame".to_owned()))?;
        let stored = source.filtered(&map, kernel).map_err(|error| fail(error.to_string()))?;
        let texel = frame.texels_per_unit.map(|texels| 1.0 / texels);
        Ok(Self {
            label: of.label,
            scene: of.scene,
            light,
            medium: of.medium,
            axes: LightAxes { x: frame.right, y: frame.down, light: frame.forward },
            stored,
            corner: [0, 1].map(|k| -frame.origin_texel[k] * texel[k]),
            texel,
            near: frame.near,
            range: frame.depth_range,
            map,
        })
    }

    pub(super) fn light_map(&self) -> LightMap<'_> {
        let Self { ref map, corner, texel, near, range, .. } = *self;
        LightMap { map, corner, texel, near, range }
    }

    /// For messages.
    pub(super) fn words(&self) -> String {
        format!("scene `{}`, view `{}`", self.label, self.light.name)
    }
}
