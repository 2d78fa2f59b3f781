//! The TOML keys of the kind `stochastic-shadows`.

use super::method::{Choice, StochasticTechnique};
use super::shading::{LitFrame, Named};
use crate::error::EvaluationError;
use crate::experiment::keys::{each, in_key, not_empty, place_of, refuse, unique};
use crate::experiment::kind::{Settings, evaluated_on_scenes};
use crate::fragments::{SceneSettings, TruthSetting};
use crate::lit_frames::{MAX_FRAME_SIDE, ScaledLight, Scenery, Sight, check_zoom};
use crate::pictures::{check_camera, check_picture, move_to};
use crate::role::{check_names, named};
use crate::timing::TimingSetting;
use scenes::LightView;
use serde::{Deserialize, Serialize};
use shadow_filtering::DepthBias;

/// The TOML keys of this kind, beside `kind` and `scale`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct StochasticShadowsExperiment {
    /// Scenes and maps; its keys stand beside the others. `fragments` are the pixels that are judged, the kernel is not used,
    /// the seed is that of rays, taps and pixels.
    #[serde(skip)]
    pub scenery: SceneSettings,
    /// Width and height of a frame in pixels.
    pub camera: [u32; 2],
    /// By how much narrower the field of view is than the scene's own.
    pub zoom: f64,
    /// Shadow rays.
    pub truth: TruthSetting,
    /// Depth bias of everything that has none of its own.
    pub bias: DepthBias,
    /// How near, in texels, the first blocker towards the light's middle must be for a contact.
    pub contact: f64,
    /// The lights.
    pub light: Vec<ScaledLight>,
    /// The methods.
    pub technique: Vec<StochasticTechnique>,
    /// What is timed: how often.
    pub timing: TimingSetting,
    /// A scene whose part turns (SSSM15 Figure 14).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modulation: Option<ModulationSetting>,
    /// Pictures.
    #[serde(default)]
    pub picture: Vec<StochasticPicture>,
}

/// How the light field changes as a part of a scene turns.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ModulationSetting {
    /// A procedural scene with a part that moves.
    pub scene: String,
    /// View with a light in space.
    pub view: String,
    /// Two frames of its movement.
    pub frames: [usize; 2],
    /// Names of techniques.
    pub techniques: Vec<String>,
}

/// A picture: the truth, then each technique; below, parts magnified.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct StochasticPicture {
    /// File name without extension.
    pub id: String,
    /// Scene, as in `scenes`, or that of the modulation.
    pub scene: String,
    /// View; the first without one.
    #[serde(default)]
    pub view: String,
    /// Name of a light.
    pub light: String,
    /// Names of techniques.
    pub techniques: Vec<String>,
    /// Width and height of one picture in pixels.
    pub output: [u32; 2],
    /// Field of view, as `zoom` of the experiment.
    pub zoom: f64,
    /// Left, top and side of squares to magnify, in pixels.
    #[serde(default)]
    pub insets: Vec<[u32; 3]>,
}

impl Settings for StochasticShadowsExperiment {
    const KIND: &'static str = "stochastic-shadows";
    const ON_SCENES: bool = true;
    const IS_DIVISIBLE: bool = true;

    fn check(&self) -> Result<(), EvaluationError> {
        self.scenery.check(true)?;
        not_empty([("light", self.light.is_empty()), ("technique", self.technique.is_empty())])?;
        check_camera(self.camera, MAX_FRAME_SIDE)?;
        check_zoom(self.zoom)?;
        if !(self.contact > 0.0 && self.contact <= 1e6) {
            return refuse("contact", format!("contact = {} does not lie in (0, 1e6]", self.contact));
        }
        self.truth.nets(self.scenery.seed)?;
        self.bias.check().map_err(in_key("bias"))?;
        ScaledLight::check_all(&self.light)?;
        check_names(&self.technique, "technique")?;
        each("technique", &self.technique, StochasticTechnique::check)?;
        if let Some(modulation) = &self.modulation {
            self.named(&modulation.techniques, "modulation.techniques")?;
        }
        unique(("picture", "id", "picture"), self.picture.iter().map(|p| p.id.as_str()))?;
        for (i, picture) in self.picture.iter().enumerate() {
            let place = format!("picture[{i}]");
            check_picture(&place, &picture.id, picture.output, &picture.insets)?;
            self.named(&picture.techniques, &format!("{place}.techniques"))?;
            check_zoom(picture.zoom)?;
            let lights = self.light.iter().map(|light| light.name.as_str());
            place_of(lights, ("light", &picture.light), &format!("{place}.light"))?;
        }
        Ok(())
    }

    evaluated_on_scenes!();

    fn scenes_replaced(&mut self) {
        // Every scene has a lamp, and views were cleared with the scenes.
        self.scenery.views = vec!["lamp".to_owned()];
        let scene = &self.scenery.scenes[0];
        self.picture.truncate(1);
        move_to(scene, self.picture.iter_mut().map(|p| (&mut p.scene, &mut p.view)));
    }
}

impl StochasticShadowsExperiment {
    /// Where techniques of these names stand.
    pub(super) fn named(&self, names: &[String], key: &str) -> Result<Vec<usize>, EvaluationError> {
        named(&self.technique, names, key)
    }

    /// Those of these techniques that filter a stochastic map.
    pub(super) fn filtered(&self, techniques: &[usize]) -> Vec<Named<'_>> {
        let of = |&index: &usize| match self.technique[index].choice() {
            Some(Choice::Stochastic(setting)) => Some((index, self.technique[index].name.as_str(), setting)),
            Some(Choice::Anew(_)) | None => None,
        };
        techniques.iter().filter_map(of).collect()
    }

    /// A frame of a scene that a camera sees.
    pub(super) fn lit_frame<'s>(
        &self,
        scenery: &'s Scenery<'_>,
        frame: usize,
        seen: (LightView, &Sight),
    ) -> Result<LitFrame<'s>, EvaluationError> {
        LitFrame::new((self.scenery.size, self.scenery.seed), scenery, frame, seen)
    }

    /// Depth bias of a technique, with the limit of slopes.
    pub(super) fn bias(&self, index: usize) -> (&DepthBias, f64) {
        (self.technique[index].bias.as_ref().unwrap_or(&self.bias), self.scenery.plane_limit)
    }
}
