//! The TOML keys of the kind `soft-shadows`.

use super::method::MethodSetting;
use super::sweep::Sweep;
use crate::error::EvaluationError;
use crate::experiment::keys::{each, in_key, not_empty, place_of, refuse, unique};
use crate::experiment::kind::{Settings, evaluated_on_scenes};
use crate::fragments::{MAX_SIZE, SceneSettings, TruthSetting};
use crate::lit_frames::MAX_TAPS;
use crate::pictures::{check_camera, check_output, check_picture, move_to};
use crate::role::{check_names, named, plays_a_role};
use crate::timing::TimingSetting;
use applications::field::Table;
use scenes::{AreaLight, LightView};
use serde::{Deserialize, Serialize};
use shadow_filtering::DepthBias;

/// The TOML keys of this kind, beside `kind` and `scale`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SoftShadowsExperiment {
    /// Scenes and shadow maps; its keys stand beside the others. The kernel is what receivers keep from the map's
    /// border; the seed is that of rays and noise, too.
    #[serde(skip)]
    pub scenery: SceneSettings,
    /// Width and height in pixels of what the camera sees.
    pub camera: [u32; 2],
    /// Pixels a view of those that show a surface which faces the light, spread evenly; 0 for all.
    pub pixels: usize,
    /// Shadow rays.
    pub truth: TruthSetting,
    /// Depth biases; every method is told with the best of them for each light; sweeps take the first.
    pub bias: Vec<DepthBias>,
    /// The lights, each for the views that it is meant for.
    pub light: Vec<LightSetting>,
    /// What is timed.
    pub timing: TimingSetting,
    /// Passes on a graphics processor; none without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub passes: Option<PassTiming>,
    /// The methods; the first is the one that the others imitate.
    pub technique: Vec<SoftTechnique>,
    /// What is varied on its own.
    #[serde(default)]
    pub sweep: Vec<Sweep>,
    /// Receivers a view and light for sweeps.
    #[serde(default)]
    pub sweep_fragments: usize,
    /// The scene from its camera with the truth, then with each technique; below, parts magnified; error maps.
    #[serde(default)]
    pub picture: Vec<SoftPicture>,
    /// What `msm advise` races; every technique as it is without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub advice: Option<SoftAdvice>,
    /// What techniques make of the receiver where the first of them errs most, in a wide penumbra if there is one.
    #[serde(default)]
    pub receiver: Vec<SoftPicture>,
}

/// What `msm advise` races.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SoftAdvice {
    /// Names of techniques; all without.
    #[serde(default)]
    pub techniques: Vec<String>,
    /// How the tables of those with moments hold their sums, each in place of the technique's own.
    #[serde(default)]
    pub tables: Vec<Table>,
    /// Numbers of taps of percentage-closer soft shadows, for search and filter each.
    #[serde(default)]
    pub taps: Vec<usize>,
}

/// A light.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LightSetting {
    /// Name in records.
    pub name: String,
    /// As for `--light`: `sun:DEGREES` or `sun:AxB`, for all views whose light has no extent. Without it: the lights that
    /// views have themselves, such as lamps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<String>,
}

/// Compute passes on a graphics processor, of the first scene under its first light at infinity: one setting for all, and
/// what is varied on its own (BHS16 Figure 14).
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PassTiming {
    /// Names of techniques.
    pub techniques: Vec<String>,
    /// Side of the shadow map in texels.
    pub map_size: u32,
    /// Output width and height in pixels.
    pub output: [u32; 2],
    /// Full width in texels of the largest search region, which makes the light as wide as that.
    pub region: f64,
    /// Other map sizes.
    #[serde(default)]
    pub map_sizes: Vec<u32>,
    /// Other outputs.
    #[serde(default)]
    pub outputs: Vec<[u32; 2]>,
    /// Other regions.
    #[serde(default)]
    pub regions: Vec<f64>,
    /// Timed frames for each, in each round.
    pub frames: usize,
    /// Rounds over all techniques at each size, every other one backwards: clocks that drift favour nobody.
    pub rounds: usize,
    /// Milliseconds of frames before those that are timed: an idle processor runs at a lower clock.
    #[serde(default)]
    pub warm_up_ms: u64,
    /// Times software drivers too. They are no GPU times; for tests of the way there.
    #[serde(default)]
    pub software: bool,
}

/// A method with its names.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SoftTechnique {
    /// Name in records and legends.
    pub name: String,
    /// Part in what papers claim, unique among its like.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<String>,
    /// What it does.
    pub method: MethodSetting,
}

/// Where a picture is taken, and what it shows.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SoftPicture {
    /// File name without extension.
    pub id: String,
    /// Scene, as in `scenes`.
    pub scene: String,
    /// View; the first without one.
    #[serde(default)]
    pub view: String,
    /// Name of a light.
    pub light: String,
    /// Names of techniques.
    pub techniques: Vec<String>,
    /// Width and height in pixels of one picture from the camera; 320 x 320 without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output: Option<[u32; 2]>,
    /// Left, top and side of squares to magnify, in pixels.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub insets: Vec<[u32; 3]>,
}

impl SoftPicture {
    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.output.unwrap_or([320, 320])
    }
}

plays_a_role!(SoftTechnique);

impl Settings for SoftShadowsExperiment {
    const KIND: &'static str = "soft-shadows";
    const ON_SCENES: bool = true;
    const IS_DIVISIBLE: bool = true;

    fn check(&self) -> Result<(), EvaluationError> {
        self.scenery.check(true)?;
        not_empty([
            ("bias", self.bias.is_empty()),
            ("light", self.light.is_empty()),
            ("technique", self.technique.is_empty()),
        ])?;
        check_camera(self.camera, MAX_SIZE)?;
        self.truth.nets(self.scenery.seed)?;
        each("bias", &self.bias, |bias, place| bias.check().map_err(in_key(place)))?;
        unique(("light", "name", "light"), self.light.iter().map(|light| light.name.as_str()))?;
        each("light", &self.light, |light, place| light.sun(place).map(|_| ()))?;
        check_names(&self.technique, "technique")?;
        each("technique", &self.technique, |technique, place| {
            technique.method.check(&technique.name, &format!("{place}.method"))
        })?;
        if !self.technique[0].method.is_percentage_closer() {
            return refuse("technique[0].method", "technique[0] is no percentage-closer method".to_owned());
        }
        unique(("sweep", "id", "sweep"), self.sweep.iter().map(|sweep| sweep.id.as_str()))?;
        for (i, sweep) in self.sweep.iter().enumerate() {
            let place = format!("sweep[{i}]");
            self.named(&sweep.techniques, &format!("{place}.techniques"))?;
            self.lit_by(&sweep.light, &format!("{place}.light"))?;
            sweep.check(&self.technique, &place)?;
        }
        let pictures = self.picture.iter().map(|p| p.id.as_str());
        let ids = pictures.chain(self.receiver.iter().map(|p| p.id.as_str()));
        unique(("picture", "id", "picture"), ids)?;
        each("picture", &self.picture, |picture, place| self.check_place(picture, place))?;
        if let Some(passes) = &self.passes {
            self.named(&passes.techniques, "passes.techniques")?;
            for &output in passes.outputs.iter().chain([&passes.output]) {
                check_output(output, &[]).or_else(|reason| refuse("passes.outputs", reason))?;
            }
            for &size in passes.map_sizes.iter().chain([&passes.map_size]) {
                if !(1..=MAX_SIZE).contains(&size) {
                    let reason = format!("map size {size} is not between 1 and {MAX_SIZE}");
                    return refuse("passes.map_sizes", reason);
                }
                for &region in passes.regions.iter().chain([&passes.region]) {
                    if !(region > 0.0 && region + 1.0 <= f64::from(size)) {
                        let reason = format!("a region of {region} texels does not fit a map of {size}");
                        return refuse("passes.regions", reason);
                    }
                }
            }
        }
        if let Some(advice) = &self.advice {
            if !advice.techniques.is_empty() {
                self.named(&advice.techniques, "advice.techniques")?;
            }
            for (i, taps) in advice.taps.iter().enumerate() {
                if !(1..=MAX_TAPS).contains(taps) {
                    let key = format!("advice.taps[{i}]");
                    return refuse(key, format!("advice.taps: {taps} is not between 1 and {MAX_TAPS}"));
                }
            }
        }
        for (i, picture) in self.receiver.iter().enumerate() {
            let place = format!("receiver[{i}]");
            self.check_place(picture, &place)?;
            if picture.output.is_some() || !picture.insets.is_empty() {
                let reason = format!("receiver `{}` is drawn as a chart: no output, no insets", picture.id);
                return refuse(place, reason);
            }
        }
        Ok(())
    }

    evaluated_on_scenes!();

    fn scenes_replaced(&mut self) {
        for pictures in [&mut self.picture, &mut self.receiver] {
            pictures.truncate(1);
            move_to(&self.scenery.scenes[0], pictures.iter_mut().map(|p| (&mut p.scene, &mut p.view)));
        }
    }
}

impl SoftShadowsExperiment {
    /// Whether a picture's file, techniques and light exist.
    fn check_place(&self, picture: &SoftPicture, place: &str) -> Result<(), EvaluationError> {
        check_picture(place, &picture.id, picture.size(), &picture.insets)?;
        self.named(&picture.techniques, &format!("{place}.techniques"))?;
        self.lit_by(&picture.light, &format!("{place}.light"))?;
        Ok(())
    }

    /// Where techniques of these names stand.
    pub(super) fn named(&self, names: &[String], key: &str) -> Result<Vec<usize>, EvaluationError> {
        named(&self.technique, names, key)
    }

    /// Where the light of a name stands.
    pub(super) fn lit_by(&self, name: &str, key: &str) -> Result<usize, EvaluationError> {
        place_of(self.light.iter().map(|light| light.name.as_str()), ("light", name), key)
    }
}

impl LightSetting {
    /// Whether a view is evaluated under it.
    pub(super) fn shines_on(&self, view: &LightView) -> bool {
        view.light.has_extent() == self.shape.is_none()
    }

    /// The light that a view has under it; `place` is its key.
    pub(super) fn of(&self, view: &LightView, place: &str) -> Result<AreaLight, EvaluationError> {
        Ok(self.sun(place)?.unwrap_or(view.light))
    }

    /// The shape, where there is one.
    fn sun(&self, place: &str) -> Result<Option<AreaLight>, EvaluationError> {
        let Some(shape) = &self.shape else { return Ok(None) };
        let key = format!("{place}.shape");
        match shape.parse() {
            Ok(light @ AreaLight::Sun { .. }) => Ok(Some(light)),
            Ok(AreaLight::Local { .. }) => {
                let reason = format!(
                    "light `{}`: {shape} is a place in one scene; views bring such lights",
                    self.name
                );
                refuse(key, reason)
            }
            Err(error) => refuse(key, format!("light `{}`: {error}", self.name)),
        }
    }
}
