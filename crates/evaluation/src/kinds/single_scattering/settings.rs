//! The TOML keys of the kind `single-scattering`.

use super::method::ScatteringMethod;
use super::standpoint::StandpointSetting;
use crate::error::EvaluationError;
use crate::experiment::Alphas;
use crate::experiment::keys::{at_least, each, in_key, not_empty, place_of, refuse, unique};
use crate::experiment::kind::{Settings, evaluated_on_scenes};
use crate::fragments::{MAX_SIZE, SceneSettings, TruthSetting};
use crate::pictures::{check_camera, check_output, check_picture, move_to};
use crate::role::{check_names, named, plays_a_role};
use applications::scattering::{Medium, MediumError};
use moment_problem::MomentBound;
use quantization::NumberFormat;
use serde::{Deserialize, Serialize};
use shadow_filtering::{Technique, TechniqueSpec};

/// The TOML keys of this kind, beside `kind` and `scale`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SingleScatteringExperiment {
    /// Scenes and shadow maps; its keys stand beside the others. `fragments` are view rays, evenly spread over the pixels of
    /// each camera, and `kernel` is the filter of the moment shadow map that is resampled with a filter.
    #[serde(skip)]
    pub scenery: SceneSettings,
    /// Width and height of the cameras in pixels.
    pub camera: [u32; 2],
    /// Columns and rows of the rectified map.
    pub rectified: [usize; 2],
    /// Share of the extent of theta that is added at both of its ends.
    pub guard_band: f64,
    /// What scatters.
    pub medium: MediumSetting,
    /// Shadow rays of the truth of the geometry.
    pub truth: TruthSetting,
    /// How the moment shadow map is stored that is resampled with a filter.
    pub source: TechniqueSpec,
    /// Where cameras stand.
    pub standpoint: Vec<StandpointSetting>,
    /// The methods.
    pub technique: Vec<ScatteringTechnique>,
    /// Errors of pictures, as means over a scene, for which the cheapest technique is sought.
    pub tolerances: Vec<f64>,
    /// A frame for the model of cost: output width and height in pixels, and the side of square maps.
    pub frame: [u32; 3],
    /// Cameras that move by parts of a pixel.
    #[serde(default)]
    pub aliasing: Option<AliasingSetting>,
    /// Moment biases by bound and format.
    #[serde(default)]
    pub stability: Option<ScatteringStability>,
    /// What is timed.
    pub timing: ScatteringTiming,
    /// Passes that are timed where there is a graphics processor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub passes: Option<ScatteringPasses>,
    /// Pictures with error maps.
    #[serde(default)]
    pub picture: Vec<ScatteringPicture>,
}

/// A homogeneous medium.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct MediumSetting {
    /// sigma_t times half the diagonal of the scene, so that scenes of all sizes are alike.
    pub extinction: f64,
    /// Scattered share of what is lost.
    pub albedo: f64,
    /// g of Henyey and Greenstein.
    pub anisotropy: f64,
}

/// A method with its names.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ScatteringTechnique {
    /// Name in records and legends.
    pub name: String,
    /// Part in what papers claim, unique among its like.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<String>,
    /// What it does.
    pub method: ScatteringMethod,
}

/// Cameras that move; on the first standpoint of every view.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct AliasingSetting {
    /// Names of techniques.
    pub techniques: Vec<String>,
    /// Parts of a pixel.
    pub shifts: Vec<f64>,
    /// Pixels a view.
    pub rays: usize,
}

/// Moment biases by bound and format, and what lies at the edge.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ScatteringStability {
    /// Bounds of moments.
    pub bounds: Vec<MomentBound>,
    /// Number formats by their names.
    pub formats: Vec<String>,
    /// Moment biases.
    pub alphas: Alphas,
    /// Blend of the bounds.
    pub beta: f64,
    /// Rays a view, on its first standpoint.
    pub rays: usize,
}

/// Timings on one thread.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ScatteringTiming {
    /// How often every method is prepared and asked on the first view.
    pub repetitions: usize,
}

/// Passes on a graphics processor, by sizes of map and output.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ScatteringPasses {
    /// Names of techniques.
    pub techniques: Vec<String>,
    /// Side of the shadow map and of the rectified map.
    pub map_size: u32,
    /// Width and height of the output.
    pub output: [u32; 2],
    /// Other sides.
    #[serde(default)]
    pub map_sizes: Vec<u32>,
    /// Other outputs.
    #[serde(default)]
    pub outputs: Vec<[u32; 2]>,
    /// Frames a technique and size.
    pub frames: usize,
    /// Milliseconds of frames before these.
    #[serde(default)]
    pub warm_up_ms: u64,
    /// Whether a software driver is timed, too.
    #[serde(default)]
    pub software: bool,
}

/// What a camera sees of a scene in a medium: the truth, then each technique; below, parts magnified.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ScatteringPicture {
    /// File name without extension.
    pub id: String,
    /// Scene, as in `scenes`.
    pub scene: String,
    /// Light view; the first without one.
    #[serde(default)]
    pub view: String,
    /// Name of a standpoint.
    pub standpoint: String,
    /// Names of techniques.
    pub techniques: Vec<String>,
    /// Width and height of one picture in pixels.
    pub output: [u32; 2],
    /// Left, top and side of squares to magnify, in pixels.
    #[serde(default)]
    pub insets: Vec<[u32; 3]>,
    /// By how much contrasts are stretched in these.
    #[serde(default = "unstretched")]
    pub stretch: f32,
}

fn unstretched() -> f32 {
    1.0
}

plays_a_role!(ScatteringTechnique);

/// Rows of fewer texels hold nothing that could be summed.
const LEAST_COLUMNS: usize = 2;

/// Rows for azimuths, with one more on either side.
const LEAST_ROWS: usize = 3;

impl Settings for SingleScatteringExperiment {
    const KIND: &'static str = "single-scattering";
    const ON_SCENES: bool = true;
    const IS_DIVISIBLE: bool = true;

    fn check(&self) -> Result<(), EvaluationError> {
        self.scenery.check(true)?;
        not_empty([
            ("standpoint", self.standpoint.is_empty()),
            ("technique", self.technique.is_empty()),
            ("tolerances", self.tolerances.is_empty()),
        ])?;
        at_least([("timing.repetitions", self.timing.repetitions, 1)])?;
        check_camera(self.camera, MAX_SIZE)?;
        self.check_map()?;
        self.medium.of_radius(1.0).map_err(|error| {
            EvaluationError::key(format!("medium.{}", error.key), format!("medium: {error}"))
        })?;
        self.truth.nets(self.scenery.seed)?;
        self.source.draft().map_err(in_key("source"))?;
        for (i, tolerance) in self.tolerances.iter().enumerate() {
            if !(*tolerance > 0.0 && *tolerance < 1.0) {
                return refuse(
                    format!("tolerances[{i}]"),
                    format!("tolerance {tolerance} is not between 0 and 1"),
                );
            }
        }
        if self.frame.contains(&0) {
            return refuse("frame", format!("frame = {:?} has no pixel or no texel", self.frame));
        }
        unique(("standpoint", "name", "standpoint"), self.standpoint.iter().map(|s| s.name.as_str()))?;
        each("standpoint", &self.standpoint, StandpointSetting::check)?;
        check_names(&self.technique, "technique")?;
        each("technique", &self.technique, |technique, place| {
            technique.method.check(&technique.name, &format!("{place}.method"))
        })?;
        self.check_aliasing()?;
        self.check_stability()?;
        self.check_passes()?;
        self.check_pictures()
    }

    evaluated_on_scenes!();

    fn scenes_replaced(&mut self) {
        // Places of one scene are none of another.
        self.standpoint.retain(|standpoint| standpoint.scene.is_none());
        let names: Vec<String> = self.standpoint.iter().map(|s| s.name.clone()).collect();
        self.picture.retain(|picture| names.contains(&picture.standpoint));
        self.picture.truncate(1);
        move_to(&self.scenery.scenes[0], self.picture.iter_mut().map(|p| (&mut p.scene, &mut p.view)));
    }
}

impl SingleScatteringExperiment {
    fn check_map(&self) -> Result<(), EvaluationError> {
        let [columns, rows] = self.rectified;
        if columns < LEAST_COLUMNS || rows < LEAST_ROWS || columns.max(rows) > MAX_SIZE as usize {
            let reason = format!(
                "rectified = {columns}x{rows}: a map needs {LEAST_COLUMNS} to {MAX_SIZE} columns and {LEAST_ROWS} to \
                 {MAX_SIZE} rows"
            );
            return refuse("rectified", reason);
        }
        if !(0.0..=1.0).contains(&self.guard_band) {
            let reason = format!("guard_band = {} is not in [0, 1]", self.guard_band);
            return refuse("guard_band", reason);
        }
        Ok(())
    }

    fn check_aliasing(&self) -> Result<(), EvaluationError> {
        let Some(aliasing) = &self.aliasing else { return Ok(()) };
        self.named(&aliasing.techniques, "aliasing.techniques")?;
        not_empty([("aliasing.shifts", aliasing.shifts.is_empty())])?;
        match aliasing.shifts.iter().position(|shift| !(*shift > 0.0 && *shift <= 1.0)) {
            Some(i) => {
                let reason =
                    format!("shift {} is not a part of a pixel, above 0 and at most 1", aliasing.shifts[i]);
                refuse(format!("aliasing.shifts[{i}]"), reason)
            }
            None => Ok(()),
        }
    }

    fn check_stability(&self) -> Result<(), EvaluationError> {
        let Some(stability) = &self.stability else { return Ok(()) };
        not_empty([
            ("stability.bounds", stability.bounds.is_empty()),
            ("stability.formats", stability.formats.is_empty()),
        ])?;
        stability.alphas.check()?;
        if !(0.0..=1.0).contains(&stability.beta) {
            return refuse("stability.beta", format!("beta = {} is not in [0, 1]", stability.beta));
        }
        for (i, format) in stability.formats.iter().enumerate() {
            format.parse::<NumberFormat>().map_err(|error| {
                EvaluationError::key(format!("stability.formats[{i}]"), error.to_string())
            })?;
        }
        Ok(())
    }

    fn check_passes(&self) -> Result<(), EvaluationError> {
        let Some(passes) = &self.passes else { return Ok(()) };
        self.named(&passes.techniques, "passes.techniques")?;
        at_least([("passes.frames", passes.frames, 1)])?;
        for (key, side) in [passes.map_size].iter().chain(&passes.map_sizes).map(|side| ("map_size", *side)) {
            if !(LEAST_ROWS as u32..=MAX_SIZE).contains(&side) {
                let reason = format!("passes: {key} = {side} is not between {LEAST_ROWS} and {MAX_SIZE}");
                return refuse(format!("passes.{key}"), reason);
            }
        }
        for output in [passes.output].iter().chain(&passes.outputs) {
            check_output(*output, &[])
                .or_else(|reason| refuse("passes.output", format!("passes: {reason}")))?;
        }
        Ok(())
    }

    fn check_pictures(&self) -> Result<(), EvaluationError> {
        unique(("picture", "id", "picture"), self.picture.iter().map(|p| p.id.as_str()))?;
        for (i, picture) in self.picture.iter().enumerate() {
            let place = format!("picture[{i}]");
            check_picture(&place, &picture.id, picture.output, &picture.insets)?;
            self.named(&picture.techniques, &format!("{place}.techniques"))?;
            self.stands(&picture.standpoint, &format!("{place}.standpoint"))?;
            if !(picture.stretch >= 1.0 && picture.stretch.is_finite()) {
                let reason =
                    format!("picture `{}`: stretch = {} is less than 1", picture.id, picture.stretch);
                return refuse(format!("{place}.stretch"), reason);
            }
        }
        Ok(())
    }

    /// Where techniques of these names stand.
    pub(super) fn named(&self, names: &[String], key: &str) -> Result<Vec<usize>, EvaluationError> {
        named(&self.technique, names, key)
    }

    /// Where the standpoint of a name stands.
    pub(super) fn stands(&self, name: &str, key: &str) -> Result<usize, EvaluationError> {
        place_of(self.standpoint.iter().map(|point| point.name.as_str()), ("standpoint", name), key)
    }

    /// What methods look moments up with; `None` for those that do not.
    pub(super) fn built(&self) -> Result<Vec<Option<Technique>>, EvaluationError> {
        let built = self.technique.iter().enumerate().map(|(i, technique)| {
            let stored = technique.method.stored.as_ref();
            stored
                .map(|spec| spec.build().map_err(in_key(&format!("technique[{i}].method.stored"))))
                .transpose()
        });
        built.collect()
    }
}

impl MediumSetting {
    /// The medium of a scene of so many world units from its middle to a corner of its bounds.
    pub(super) fn of_radius(&self, radius: f64) -> Result<Medium, MediumError> {
        // What is no number stays none for the message.
        Medium::new(self.extinction, self.albedo, self.anisotropy)?;
        Medium::new(self.extinction / radius, self.albedo, self.anisotropy)
    }
}
