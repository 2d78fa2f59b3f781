//! The TOML keys of the kind `temporal-shadows`.

use super::animation::TemporalAnimation;
use super::method::{MethodChoice, TemporalTechnique};
use crate::error::EvaluationError;
use crate::experiment::keys::{each, in_key, not_empty, place_of, refuse, unique};
use crate::experiment::kind::{Settings, evaluated_on_scenes};
use crate::fragments::{SceneSettings, TruthSetting};
use crate::lit_frames::{MAX_FRAME_SIDE, ScaledLight, Stage, Window, check_zoom};
use crate::pictures::{check_camera, check_picture, move_to};
use crate::role::{check_names, named};
use crate::timing::TimingSetting;
use scenes::{CameraPath, Movement};
use serde::{Deserialize, Serialize};
use shadow_filtering::DepthBias;

/// The TOML keys of this kind, beside `kind` and `scale`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TemporalShadowsExperiment {
    /// Scenes and shadow maps; its keys stand beside the others. `fragments` are the pixels of a frame that are judged, the
    /// kernel is not used, the seed is that of rays, taps and pixels.
    #[serde(skip)]
    pub scenery: SceneSettings,
    /// Width and height of a frame in pixels.
    pub camera: [u32; 2],
    /// By how much the shadow buffer is larger than the frame, a share of its sides (TC09: 0.05).
    pub overscan: f64,
    /// By how much narrower the field of view is than the scene's own.
    pub zoom: f64,
    /// Shadow rays.
    pub truth: TruthSetting,
    /// Depth bias of everything that has none of its own.
    pub bias: DepthBias,
    /// The lights.
    pub light: Vec<ScaledLight>,
    /// The ways of camera and scene.
    pub path: Vec<PathSetting>,
    /// The methods.
    pub technique: Vec<TemporalTechnique>,
    /// How long the formats of the buffer count.
    pub counting: CountingSetting,
    /// What is timed: how often each method makes a frame.
    pub timing: TimingSetting,
    /// Pictures.
    #[serde(default)]
    pub picture: Vec<TemporalPicture>,
    /// Frames that a page can play.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub animation: Vec<TemporalAnimation>,
}

/// A way through frames.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PathSetting {
    /// Name in records.
    pub name: String,
    /// How the camera moves.
    pub movement: Movement,
    /// Degrees a frame, or of the jump of a cut.
    #[serde(default)]
    pub degrees: f64,
    /// Number of frames.
    pub frames: usize,
    /// Whether the scene's part moves.
    #[serde(default)]
    pub moving: bool,
    /// Frames that are judged, counted from 1.
    pub judged: Vec<usize>,
}

/// A simulation of single pixels: how long a format counts.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct CountingSetting {
    /// Shares of shadow, spread evenly.
    pub pixels: usize,
    /// Frames after which n and psi are told.
    pub frames: Vec<usize>,
}

/// A picture: the truth in the last of its frames, then each technique in each frame; below, parts magnified.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TemporalPicture {
    /// File name without extension.
    pub id: String,
    /// Scene, as in `scenes`.
    pub scene: String,
    /// View; the first without one.
    #[serde(default)]
    pub view: String,
    /// Name of a light.
    pub light: String,
    /// Name of a path.
    pub path: String,
    /// Names of techniques.
    pub techniques: Vec<String>,
    /// Frames, counted from 1.
    pub frames: Vec<usize>,
    /// Left, top and side of squares to magnify, in pixels of the frame.
    #[serde(default)]
    pub insets: Vec<[u32; 3]>,
}

/// Most frames of an animation: they lie in one picture.
const MAX_SHOWN: usize = 64;

/// Most frames of a path.
const MAX_FRAMES: usize = 1 << 16;

impl PathSetting {
    /// Whether neither camera nor scene moves.
    pub fn is_still(&self) -> bool {
        self.movement == Movement::Still && !self.moving
    }

    /// Whether the camera jumps.
    pub fn is_cut(&self) -> bool {
        self.movement == Movement::Cut
    }

    /// The camera's way.
    pub(super) fn camera(&self, zoom: f64) -> CameraPath {
        CameraPath { movement: self.movement, degrees: self.degrees, zoom, frames: self.frames }
    }

    /// Whether all frames show the same.
    pub(super) fn is_constant(&self, has_motion: bool) -> bool {
        self.movement == Movement::Still && !(self.moving && has_motion)
    }

    fn check(&self, place: &str) -> Result<(), EvaluationError> {
        let Self { name, frames, .. } = self;
        if !(2..=MAX_FRAMES).contains(frames) {
            let reason = format!(
                "path `{name}`: frames = {frames} is not between 2 and {MAX_FRAMES}: shadows are gathered over time"
            );
            return refuse(format!("{place}.frames"), reason);
        }
        if self.degrees.is_nan() || self.degrees.abs() > 180.0 {
            let reason = format!("path `{name}`: degrees = {} is not between -180 and 180", self.degrees);
            return refuse(format!("{place}.degrees"), reason);
        }
        if self.judged.is_empty() {
            return refuse(format!("{place}.judged"), format!("path `{name}`: judged is empty"));
        }
        let ascends = self.judged.windows(2).all(|pair| pair[0] < pair[1]);
        if let Some(frame) = self.judged.iter().find(|frame| !(1..=*frames).contains(frame)) {
            let reason = format!("path `{name}`: judged frame {frame} is none of its 1 to {frames}");
            return refuse(format!("{place}.judged"), reason);
        }
        if !ascends {
            let reason = format!("path `{name}`: judged = {:?} does not ascend", self.judged);
            return refuse(format!("{place}.judged"), reason);
        }
        Ok(())
    }
}

impl Settings for TemporalShadowsExperiment {
    const KIND: &'static str = "temporal-shadows";
    const ON_SCENES: bool = true;
    const IS_DIVISIBLE: bool = true;

    fn check(&self) -> Result<(), EvaluationError> {
        self.scenery.check(true)?;
        not_empty([
            ("light", self.light.is_empty()),
            ("path", self.path.is_empty()),
            ("technique", self.technique.is_empty()),
            ("counting.frames", self.counting.frames.is_empty()),
        ])?;
        check_camera(self.camera, MAX_FRAME_SIDE)?;
        if !(0.0..=1.0).contains(&self.overscan) {
            return refuse("overscan", format!("overscan = {} does not lie in [0, 1]", self.overscan));
        }
        check_zoom(self.zoom)?;
        self.truth.nets(self.scenery.seed)?;
        self.bias.check().map_err(in_key("bias"))?;
        ScaledLight::check_all(&self.light)?;
        unique(("path", "name", "path"), self.path.iter().map(|path| path.name.as_str()))?;
        each("path", &self.path, PathSetting::check)?;
        check_names(&self.technique, "technique")?;
        each("technique", &self.technique, TemporalTechnique::check)?;
        if !(1..=4096).contains(&self.counting.pixels) {
            return refuse(
                "counting.pixels",
                format!("pixels = {} is not between 1 and 4096", self.counting.pixels),
            );
        }
        if let Some(frames) = self.counting.frames.iter().find(|frames| !(1..=1 << 20).contains(*frames)) {
            return refuse("counting.frames", format!("frames = {frames} is not between 1 and 2^20"));
        }
        unique(("picture", "id", "picture"), self.picture.iter().map(|p| p.id.as_str()))?;
        each("picture", &self.picture, |picture, place| self.check_picture(picture, place))?;
        unique(("animation", "id", "animation"), self.animation.iter().map(|a| a.id.as_str()))?;
        each("animation", &self.animation, |animation, place| self.check_animation(animation, place))
    }

    evaluated_on_scenes!();

    fn scenes_replaced(&mut self) {
        // Every scene has a lamp, and views were cleared with the scenes.
        self.scenery.views = vec!["lamp".to_owned()];
        let scene = &self.scenery.scenes[0];
        move_to(scene, self.picture.iter_mut().map(|p| (&mut p.scene, &mut p.view)));
        move_to(scene, self.animation.iter_mut().map(|a| (&mut a.scene, &mut a.view)));
    }
}

impl TemporalShadowsExperiment {
    /// The pixels of a frame.
    pub(super) fn window(&self) -> Window {
        Window { camera: self.camera, overscan: self.overscan }
    }

    /// Techniques that keep a buffer, with their methods.
    pub(super) fn gathering(&self) -> impl Iterator<Item = (usize, &applications::temporal::TemporalMethod)> {
        self.technique.iter().enumerate().filter_map(|(i, technique)| match &technique.choice {
            MethodChoice::Temporal(method) => Some((i, method)),
            MethodChoice::Taps(_) | MethodChoice::Soft(_) | MethodChoice::Stochastic(_) => None,
        })
    }

    /// The name of a scene's view: that of `view`, or the first of those that are evaluated. `item` is a kind of picture with its
    /// id and key.
    pub(super) fn view_of(
        &self,
        stages: &[Stage],
        item: (&str, &str, &str),
        (scene, view): (&str, &str),
    ) -> Result<String, EvaluationError> {
        let (kind, id, place) = item;
        let refused = |key: &str, what: String| {
            EvaluationError::key(format!("{place}.{key}"), format!("{kind} `{id}`: {what} is not evaluated"))
        };
        let stage = stages.iter().find(|stage| stage.label == scene);
        let stage = stage.ok_or_else(|| refused("scene", format!("scene `{scene}`")))?;
        let views = stage.views(&self.scenery.views)?;
        let found = views.iter().find(|known| view.is_empty() || view == known.name);
        Ok(found.ok_or_else(|| refused("view", format!("view `{view}`")))?.name.clone())
    }

    fn check_animation(&self, animation: &TemporalAnimation, place: &str) -> Result<(), EvaluationError> {
        check_picture(place, &animation.id, self.camera, &[])?;
        if self.picture.iter().any(|picture| picture.id == animation.id) {
            return refuse(format!("{place}.id"), format!("animation `{}` has a picture's id", animation.id));
        }
        let lights = self.light.iter().map(|light| light.name.as_str());
        place_of(lights, ("light", &animation.light), &format!("{place}.light"))?;
        let paths = self.path.iter().map(|path| path.name.as_str());
        let path = &self.path[place_of(paths, ("path", &animation.path), &format!("{place}.path"))?];
        let key = format!("{place}.techniques");
        let shown = named(&self.technique, &animation.techniques, &key)?;
        if shown.is_empty() {
            return refuse(key, format!("animation `{}` shows no technique", animation.id));
        }
        for index in shown {
            let name = &self.technique[index].name;
            if !self.gathering().any(|(gathering, method)| gathering == index && !method.exact) {
                return refuse(key, format!("technique `{name}` does not gather in every frame"));
            }
        }
        let every = animation.every;
        if !(1..=path.frames).contains(&every) || animation.shown(path.frames) > MAX_SHOWN {
            let reason = format!(
                "animation `{}`: every = {every} does not leave 1 to {MAX_SHOWN} frames of path `{}`",
                animation.id, path.name
            );
            return refuse(format!("{place}.every"), reason);
        }
        Ok(())
    }

    fn check_picture(&self, picture: &TemporalPicture, place: &str) -> Result<(), EvaluationError> {
        check_picture(place, &picture.id, self.camera, &picture.insets)?;
        let lights = self.light.iter().map(|light| light.name.as_str());
        place_of(lights, ("light", &picture.light), &format!("{place}.light"))?;
        let paths = self.path.iter().map(|path| path.name.as_str());
        let path = &self.path[place_of(paths, ("path", &picture.path), &format!("{place}.path"))?];
        let key = format!("{place}.techniques");
        for index in named(&self.technique, &picture.techniques, &key)? {
            if matches!(self.technique[index].choice, MethodChoice::Stochastic(_)) {
                let name = &self.technique[index].name;
                return refuse(
                    key,
                    format!("technique `{name}`: stochastic maps are drawn by their own kind"),
                );
            }
        }
        let frames = format!("{place}.frames");
        if picture.frames.is_empty() {
            return refuse(frames, format!("picture `{}` shows no frame", picture.id));
        }
        if let Some(frame) = picture.frames.iter().find(|frame| !path.judged.contains(frame)) {
            let reason =
                format!("picture `{}`: frame {frame} is not judged on path `{}`", picture.id, path.name);
            return refuse(frames, reason);
        }
        Ok(())
    }
}
