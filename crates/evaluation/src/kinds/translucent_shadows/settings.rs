//! The TOML keys of the kind `translucent-shadows`.

use super::method::TranslucentTechnique;
use crate::error::EvaluationError;
use crate::experiment::Alphas;
use crate::experiment::keys::{at_least, each, in_key, not_empty, refuse, unique};
use crate::experiment::kind::{Settings, evaluated_on_scenes};
use crate::fragments::{SceneSettings, check_bias};
use crate::lit_frames::check_zoom;
use crate::pictures::{check_picture, move_to};
use crate::role::{check_names, named};
use crate::timing::TimingSetting;
use applications::BiasSetting;
use moment_problem::MomentBound;
use quantization::NumberFormat;
use serde::{Deserialize, Serialize};
use shadow_filtering::DepthBias;

/// The TOML keys of this kind, beside `kind` and `scale`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TranslucentShadowsExperiment {
    /// Scenes, maps and filter; its keys stand beside the others. `fragments` are those of each class and view.
    #[serde(skip)]
    pub scenery: SceneSettings,
    /// Depth biases of the truth and of all techniques.
    pub bias: BiasSetting,
    /// The methods.
    pub technique: Vec<TranslucentTechnique>,
    /// What is timed: how often, on the first view.
    pub timing: TimingSetting,
    /// Coloured light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colour: Option<ColourSetting>,
    /// What rounding does to blended layers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stability: Option<TranslucentStability>,
    /// Pictures.
    #[serde(default)]
    pub picture: Vec<TranslucentPicture>,
    /// What `msm advise` races; every technique as it is without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub advice: Option<TranslucentAdvice>,
}

/// What `msm advise` races.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TranslucentAdvice {
    /// Names of techniques.
    pub techniques: Vec<String>,
    /// Depth biases of each of them, of which the best is taken.
    pub bias: Vec<DepthBias>,
}

/// Maps by colour channel on the first view of every scene.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ColourSetting {
    /// Names of techniques.
    pub techniques: Vec<String>,
}

/// Texels of layers of one opacity, by all of these.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TranslucentStability {
    /// Bounds.
    pub bounds: Vec<MomentBound>,
    /// Number formats.
    pub formats: Vec<String>,
    /// Opacities of a layer in \[0, 1\].
    pub opacities: Vec<f64>,
    /// Numbers of layers.
    pub layers: Vec<usize>,
    /// Texels of each kind.
    pub trials: usize,
    /// Moment bias at which invalid texels are counted.
    pub alpha: f64,
    /// Moment biases that are tried, ascending.
    pub alphas: Alphas,
}

/// A picture: the truth, then each technique; below, parts magnified.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TranslucentPicture {
    /// File name without extension.
    pub id: String,
    /// Scene, as in `scenes`.
    pub scene: String,
    /// View; the first without one.
    #[serde(default)]
    pub view: String,
    /// Names of techniques.
    pub techniques: Vec<String>,
    /// Width and height of one picture in pixels.
    pub output: [u32; 2],
    /// By how much narrower the field of view is than the scene's own.
    pub zoom: f64,
    /// Left, top and side of squares to magnify, in pixels.
    #[serde(default)]
    pub insets: Vec<[u32; 3]>,
}

/// Most layers that are blended into a texel.
const MOST_LAYERS: usize = 4096;

impl TranslucentStability {
    /// The formats, whose names were checked.
    pub(super) fn number_formats(&self) -> Vec<NumberFormat> {
        self.formats.iter().filter_map(|format| format.parse().ok()).collect()
    }

    fn check(&self) -> Result<(), EvaluationError> {
        not_empty([
            ("stability.bounds", self.bounds.is_empty()),
            ("stability.formats", self.formats.is_empty()),
            ("stability.opacities", self.opacities.is_empty()),
            ("stability.layers", self.layers.is_empty()),
        ])?;
        at_least([("stability.trials", self.trials, 1)])?;
        if let Some(opacity) = self.opacities.iter().find(|opacity| !(0.0..=1.0).contains(*opacity)) {
            return refuse(
                "stability.opacities",
                format!("stability.opacities: {opacity} lies outside of [0, 1]"),
            );
        }
        if let Some(layers) = self.layers.iter().find(|layers| !(1..=MOST_LAYERS).contains(*layers)) {
            let reason = format!("stability.layers: {layers} is not between 1 and {MOST_LAYERS}");
            return refuse("stability.layers", reason);
        }
        for format in &self.formats {
            if let Err(error) = format.parse::<NumberFormat>() {
                return refuse("stability.formats", format!("stability.formats: {error}"));
            }
        }
        if !(0.0..1.0).contains(&self.alpha) {
            return refuse("stability.alpha", format!("stability.alpha = {} is not in [0, 1)", self.alpha));
        }
        self.alphas.check()
    }
}

impl Settings for TranslucentShadowsExperiment {
    const KIND: &'static str = "translucent-shadows";
    const ON_SCENES: bool = true;
    const IS_DIVISIBLE: bool = true;

    fn check(&self) -> Result<(), EvaluationError> {
        self.scenery.check(true)?;
        not_empty([("technique", self.technique.is_empty())])?;
        check_bias(&self.bias, "bias")?;
        check_names(&self.technique, "technique")?;
        each("technique", &self.technique, TranslucentTechnique::check)?;
        if let Some(colour) = &self.colour {
            self.named(&colour.techniques, "colour.techniques")?;
        }
        self.stability.iter().try_for_each(TranslucentStability::check)?;
        if let Some(advice) = &self.advice {
            self.named(&advice.techniques, "advice.techniques")?;
            not_empty([("advice.bias", advice.bias.is_empty())])?;
            each("advice.bias", &advice.bias, |bias, place| bias.check().map_err(in_key(place)))?;
        }
        unique(("picture", "id", "picture"), self.picture.iter().map(|p| p.id.as_str()))?;
        for (i, picture) in self.picture.iter().enumerate() {
            let place = format!("picture[{i}]");
            check_picture(&place, &picture.id, picture.output, &picture.insets)?;
            self.named(&picture.techniques, &format!("{place}.techniques"))?;
            check_zoom(picture.zoom)?;
        }
        Ok(())
    }

    evaluated_on_scenes!();

    fn scenes_replaced(&mut self) {
        let scene = &self.scenery.scenes[0];
        self.picture.truncate(1);
        // A stack has no camera.
        if crate::fragments::is_stack(scene) {
            self.picture.clear();
        }
        move_to(scene, self.picture.iter_mut().map(|p| (&mut p.scene, &mut p.view)));
    }
}

impl TranslucentShadowsExperiment {
    /// Where techniques of these names stand.
    pub(crate) fn named(&self, names: &[String], key: &str) -> Result<Vec<usize>, EvaluationError> {
        named(&self.technique, names, key)
    }
}
