//! The TOML keys of the kind `speed-accuracy`.

use super::candidate::Candidate;
use super::records::FrameRoute;
use crate::error::EvaluationError;
use crate::experiment::keys::{each, file_name, in_key, not_empty, words};
use crate::experiment::kind::{Settings, evaluated_on_scenes};
use crate::fragments::{SceneSettings, is_stack};
use crate::pictures::{check_output, move_to};
use crate::role::{check_roles, plays_a_role};
use serde::{Deserialize, Serialize};
use shadow_filtering::{DepthBias, KernelSpec, TechniqueSpec};

/// The TOML keys of this kind, beside `kind` and `scale`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedAccuracyExperiment {
    /// Scenes, shadow maps and filter; its keys stand beside the others.
    #[serde(skip)]
    pub scenery: SceneSettings,
    /// Techniques use maps of this size divided by these, with kernels of the same extent in the scene.
    pub divisors: Vec<u32>,
    /// Bias of the reference, on top of the receiver plane.
    pub reference: DepthBias,
    /// Biases to try for every technique, in texels of its own map; each technique has its own best one.
    pub biases: Vec<DepthBias>,
    /// What may be done to the bounds; each technique has its own best one.
    pub blends: Vec<Blend>,
    /// The frame whose cost is modelled.
    pub frame: FrameSetting,
    /// How many moments kernels need.
    pub orders: OrderSetting,
    /// What is timed after all errors are known.
    pub timing: SpeedTiming,
    /// What is timed on a graphics processor; without it nothing is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<FrameTiming>,
    /// Pictures of techniques side by side.
    #[serde(default)]
    pub picture: Vec<PictureSetting>,
    /// Pictures from every view, for readers who compare.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every_view: Option<EveryViewSetting>,
    /// Techniques with their storage.
    pub technique: Vec<CandidateSetting>,
    /// Percentage-closer filtering without a receiver plane, for comparison.
    #[serde(default)]
    pub comparison: Vec<ComparisonSetting>,
}

/// From bounds to a shadow: lower + beta (upper - lower), divided by 1 - leak_reduction.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Blend {
    /// 0 for the lower bound, 1 for the upper (BHS16 section 2.4); techniques without an upper bound leave out all but 0.
    #[serde(default)]
    pub beta: f64,
    /// Shadows of this much less than 1 are made full, as light-bleeding reduction of variance shadow maps does (Lauritzen,
    /// GPU Gems 3, chapter 8) and GDC16 with 0.02.
    #[serde(default)]
    pub leak_reduction: f64,
}

impl Blend {
    /// The shadow.
    #[inline]
    pub(crate) fn apply(self, [lower, upper]: [f32; 2]) -> f32 {
        let blended = lower + self.beta as f32 * (upper - lower);
        (blended / (1.0 - self.leak_reduction) as f32).min(1.0)
    }
}

/// Pixels that are shaded once each.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FrameSetting {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

/// How many moments the kernels of fragments need.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct OrderSetting {
    /// Fragments a view, at most those of the sample.
    pub fragments: usize,
    /// Eigenvalues of the moment matrix up to this share of the largest one count as zero.
    pub rank_tolerance: f64,
    /// A kernel needs the smallest order whose upper bound exceeds the lower one by less than this.
    pub gap_tolerances: Vec<f64>,
}

/// Timings on one thread.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedTiming {
    /// How often everything is timed, technique after technique in each round.
    pub repetitions: usize,
    /// Fragments of the first view that are shaded.
    pub fragments: usize,
}

fn fragment_route() -> Vec<FrameRoute> {
    vec![FrameRoute::Fragment]
}

/// Frames on a graphics processor: one setting for all, and what is varied on its own.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FrameTiming {
    /// Side of the shadow map in texels.
    pub map_size: u32,
    /// Output width and height in pixels.
    pub output: [u32; 2],
    /// Size of the Gaussian in texels.
    pub kernel: usize,
    /// Other map sizes.
    #[serde(default)]
    pub map_sizes: Vec<u32>,
    /// Other outputs.
    #[serde(default)]
    pub outputs: Vec<[u32; 2]>,
    /// Other kernel sizes.
    #[serde(default)]
    pub kernels: Vec<usize>,
    /// Other numbers of depth samples a texel of the shadow map: 1, beside the 4 of all others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub samples: Vec<u32>,
    /// `NAME, FORMAT` of the techniques that are timed; all that have a shader without.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub techniques: Vec<String>,
    /// Which shaders; fragment shaders without.
    #[serde(default = "fragment_route")]
    pub routes: Vec<FrameRoute>,
    /// Timed frames for each, in each round.
    pub frames: usize,
    /// Rounds over all techniques at each size, every other one backwards: clocks that drift favour nobody.
    #[serde(default = "one_round")]
    pub rounds: usize,
    /// Milliseconds of frames before those that are timed: an idle processor runs at a lower clock.
    #[serde(default)]
    pub warm_up_ms: u64,
    /// Times software drivers too. They are no GPU times; for tests of the way there.
    #[serde(default)]
    pub software: bool,
}

/// What is drawn from every view of every scene that has a camera.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct EveryViewSetting {
    /// `NAME, FORMAT` of candidates, with the first moment bias and no blend.
    pub techniques: Vec<String>,
    /// Depth bias of the techniques.
    pub bias: DepthBias,
    /// Width and height of one picture in pixels.
    pub output: [u32; 2],
}

fn one_round() -> usize {
    1
}

/// The scene from its camera with percentage-closer filtering, then with each technique.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PictureSetting {
    /// File name without extension.
    pub id: String,
    /// Procedural scene or file.
    pub scene: String,
    /// View.
    pub view: String,
    /// `NAME, FORMAT` of candidates, with the first moment bias and no blend.
    pub techniques: Vec<String>,
    /// Depth bias of the techniques.
    pub bias: DepthBias,
    /// Width and height of one picture in pixels.
    pub output: [u32; 2],
    /// Left, top and side of squares to magnify, in pixels.
    #[serde(default)]
    pub insets: Vec<[u32; 3]>,
}

/// A technique with its storage.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct CandidateSetting {
    /// Name in records and legends, the same for all formats of a technique.
    pub name: String,
    /// Part in what papers claim, unique among its like.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<String>,
    /// The technique with its storage; `alphas` are moment biases to try.
    pub method: TechniqueSpec,
}

impl CandidateSetting {
    /// Name of the number format.
    pub fn format(&self) -> String {
        self.method.format().name()
    }
}

/// Percentage-closer filtering with a kernel of its own.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ComparisonSetting {
    /// Name in records and legends.
    pub name: String,
    /// The kernel at the reference's size; size 1 is the plain shadow map.
    pub kernel: KernelSpec,
}

plays_a_role!(CandidateSetting);

impl Settings for SpeedAccuracyExperiment {
    const KIND: &'static str = "speed-accuracy";
    const ON_SCENES: bool = true;

    fn check(&self) -> Result<(), EvaluationError> {
        let fail = |key: &str, reason: String| Err(EvaluationError::Key { key: key.to_owned(), reason });
        self.scenery.check(true)?;
        not_empty([
            ("divisors", self.divisors.is_empty()),
            ("biases", self.biases.is_empty()),
            ("blends", self.blends.is_empty()),
            ("technique", self.technique.is_empty()),
            ("orders.gap_tolerances", self.orders.gap_tolerances.is_empty()),
        ])?;
        let kernel = self.scenery.filter()?;
        for (i, &divisor) in self.divisors.iter().enumerate() {
            let key = format!("divisors[{i}]");
            if divisor == 0 || !self.scenery.size.is_multiple_of(divisor) {
                return fail(&key, format!("{key} = {divisor} does not divide size = {}", self.scenery.size));
            }
            let (map, kernel) = (self.scenery.size / divisor, kernel.size().div_ceil(divisor as usize));
            if map as usize <= kernel {
                return fail(&key, format!("{key} = {divisor} leaves {map} texels, no more than the kernel"));
            }
        }
        self.reference.check().map_err(in_key("reference"))?;
        each("biases", &self.biases, |bias, place| bias.check().map_err(in_key(place)))?;
        for (i, blend) in self.blends.iter().enumerate() {
            for (key, value) in [("beta", blend.beta), ("leak_reduction", blend.leak_reduction)] {
                if !(0.0..1.0).contains(&value) {
                    let key = format!("blends[{i}].{key}");
                    return fail(&key, format!("{key} = {value} is not in [0, 1)"));
                }
            }
        }
        if self.blends.iter().all(|blend| blend.beta > 0.0) {
            return fail(
                "blends",
                "blends: one needs beta = 0, for techniques without an upper bound".to_owned(),
            );
        }
        if self.frame.width == 0 || self.frame.height == 0 {
            return fail("frame", format!("frame = {}x{} has no pixel", self.frame.width, self.frame.height));
        }
        let tolerances = self.orders.gap_tolerances.iter().chain([&self.orders.rank_tolerance]);
        for &tolerance in tolerances {
            if !(tolerance > 0.0 && tolerance < 1.0) {
                return fail("orders", format!("orders: tolerance {tolerance} is not between 0 and 1"));
            }
        }
        check_roles(&self.technique, "technique")?;
        for (i, setting) in self.technique.iter().enumerate() {
            let twin =
                |other: &CandidateSetting| other.name == setting.name && other.format() == setting.format();
            if self.technique[..i].iter().any(twin) {
                let reason = format!("technique `{}` in {} appears twice", setting.name, setting.format());
                return fail(&format!("technique[{i}]"), reason);
            }
            Candidate::new((&setting.name, &setting.method), self.scenery.seed, &format!("technique[{i}]"))?;
        }
        self.check_frames()?;
        each("picture", &self.picture, |picture, place| {
            file_name(&format!("{place}.id"), "picture", &picture.id)?;
            self.check_picture(picture, place)
        })?;
        for mut picture in self.pictures_of_views(std::iter::once(("scene", "view"))) {
            "every_view".clone_into(&mut picture.id);
            self.check_picture(&picture, "every_view")?;
        }
        each("comparison", &self.comparison, |comparison, place| {
            comparison.kernel.build().map(|_| ()).map_err(in_key(&format!("{place}.kernel")))
        })
    }

    evaluated_on_scenes!();

    fn scenes_replaced(&mut self) {
        // A stack has no camera.
        self.picture.truncate(usize::from(!is_stack(&self.scenery.scenes[0])));
        move_to(&self.scenery.scenes[0], self.picture.iter_mut().map(|p| (&mut p.scene, &mut p.view)));
    }
}

impl SpeedAccuracyExperiment {
    /// The pictures of `every_view` for those of these scenes and views that have a camera.
    pub fn pictures_of_views<'a>(
        &self,
        views: impl Iterator<Item = (&'a str, &'a str)>,
    ) -> Vec<PictureSetting> {
        let Some(every) = &self.every_view else { return Vec::new() };
        let picture = |(scene, view): (&str, &str)| PictureSetting {
            id: format!("view-{}-{}", self.scenery.words(scene), words(view)),
            scene: scene.to_owned(),
            view: view.to_owned(),
            techniques: every.techniques.clone(),
            bias: every.bias,
            output: every.output,
            insets: Vec::new(),
        };
        // A stack has no camera.
        views.filter(|(scene, _)| !is_stack(scene)).map(picture).collect()
    }

    /// Whether a candidate is called `NAME, FORMAT`.
    pub(super) fn is_candidate(&self, label: &str) -> bool {
        let is_called =
            |candidate: &CandidateSetting| format!("{}, {}", candidate.name, candidate.format()) == label;
        self.technique.iter().any(is_called)
    }

    fn check_picture(&self, picture: &PictureSetting, place: &str) -> Result<(), EvaluationError> {
        let fail = |reason: String| {
            let reason = format!("picture `{}`: {reason}", picture.id);
            Err(EvaluationError::Key { key: place.to_owned(), reason })
        };
        if let Err(reason) = check_output(picture.output, &picture.insets) {
            return fail(reason);
        }
        for name in &picture.techniques {
            if !self.is_candidate(name) {
                return fail(format!("technique `{name}` is not a candidate (`NAME, FORMAT`)"));
            }
        }
        picture.bias.check().map_err(in_key(place))
    }

    /// A kernel of the same extent in the scene on a map whose side is divided.
    pub(crate) fn divided(kernel: KernelSpec, divisor: u32) -> KernelSpec {
        let size = |size: usize| 2 * (size / 2).div_ceil(divisor as usize) + 1;
        match kernel {
            KernelSpec::Gaussian { size: s, sigma } => {
                KernelSpec::Gaussian { size: size(s), sigma: sigma / f64::from(divisor) }
            }
            KernelSpec::Box { size: s } => KernelSpec::Box { size: size(s) },
            KernelSpec::Binomial { size: s } => KernelSpec::Binomial { size: size(s) },
        }
    }
}
