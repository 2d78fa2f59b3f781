//! The TOML keys of the kind `stability`.

use super::method::Prepared;
use crate::error::EvaluationError;
use crate::experiment::kind::{RunContext, Settings};
use crate::kinds::filterable::settings::{MAX_SIZE, in_key};
use crate::kinds::quantization::Alphas;
use crate::role::{Role, check_roles};
use crate::run::Recorded;
use moment_problem::MomentBound;
use serde::{Deserialize, Serialize};
use shadow_filtering::{DepthBias, KernelSpec, TechniqueSpec};

/// The TOML keys of this kind, beside `kind` and `scale`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct StabilityExperiment {
    /// What is asked.
    pub question: String,
    /// What is expected, written before the first run.
    pub expectation: String,
    /// Seed of all inputs.
    pub seed: u64,
    /// Cells along each knob of a family.
    pub cells: usize,
    /// Inputs a cell on which every method is compared with the exact bound, at every moment bias.
    pub draws: usize,
    /// Further inputs a cell on which our forms in `f32` and `f64` are held to F and to \[0, 1\].
    pub checked: usize,
    /// Moment biases that are tried, besides 0 and each method's own.
    pub alphas: Alphas,
    /// What is timed after all errors are known.
    pub timing: Timed,
    /// Names of procedural scenes, or files, for families of shape `scenes`.
    #[serde(default)]
    pub scenes: Vec<String>,
    /// Names of light views; empty for all of a scene.
    #[serde(default)]
    pub views: Vec<String>,
    /// Side of the square shadow maps in texels.
    pub size: u32,
    /// Fragments a view, spread evenly over all; 0 for all.
    pub fragments: usize,
    /// The filter.
    pub kernel: KernelSpec,
    /// Bias of the depth that is compared.
    pub bias: DepthBias,
    /// Largest slope that the bias takes into account.
    pub plane_limit: f64,
    /// The families of inputs.
    pub family: Vec<StabilityFamily>,
    /// The methods.
    pub technique: Vec<StabilityMethod>,
}

/// Timed bounds per method.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Timed {
    /// Inputs in a row.
    pub inputs: usize,
    /// How often.
    pub repetitions: usize,
}

/// Inputs with two knobs.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct StabilityFamily {
    /// Name in records and figures.
    pub name: String,
    /// What the inputs are.
    pub shape: Shape,
    /// First knob.
    pub x: Span,
    /// Second knob.
    pub y: Span,
}

/// Values of a knob, every power of ten as often.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Span {
    /// Least.
    pub from: f64,
    /// Largest.
    pub to: f64,
}

/// What the inputs of a family are; the knobs are named x and y.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// One surface of thickness x, its middle at a distance y from z_f.
    OneSurface,
    /// Two surfaces of thickness x at a distance y from each other.
    TwoSurfaces,
    /// A second surface of weight x at a distance y from the first.
    LightSurface,
    /// z_f at a distance x from a depth of one of two surfaces of thickness y.
    AtSurface,
    /// Three equal surfaces at distances y, z_f at a distance x from the one in the middle.
    ThreeSurfaces,
    /// z_f at a distance x from a depth where c_n vanishes; surfaces of thickness y.
    Pole,
    /// All depths within a range of width x whose middle is at a distance y from 0 or 1.
    SqueezedRange,
    /// Fragments of scenes: x is the range of depths in the kernel, y the distance of z_f from the nearest of them.
    Scenes,
}

/// How a bound is computed.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Route {
    /// As this project does.
    #[default]
    Ours,
    /// As published.
    Textbook,
}

/// Numbers that a bound is computed in.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Arithmetic {
    /// Single precision.
    F32,
    /// Double precision.
    F64,
    /// Unevaluated sums of two `f32`.
    Pairs,
}

/// One way to compute a bound.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct StabilityMethod {
    /// Name in records and figures.
    pub name: String,
    /// Part in what papers claim, unique among its like.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<String>,
    /// Bound of moments with its alpha and b*; without format and transform moments are rounded to the arithmetic only.
    pub method: TechniqueSpec,
    /// The algorithm.
    #[serde(default)]
    pub route: Route,
    /// The numbers.
    pub arithmetic: Arithmetic,
    /// Whether heat maps are recorded and drawn.
    #[serde(default)]
    pub atlas: bool,
}

impl StabilityMethod {
    /// The bound of moments; `check` has made sure that there is one.
    pub fn bound(&self) -> Option<MomentBound> {
        self.method.moment_bound()
    }

    /// Recommended moment bias; `check` has made sure that it is given.
    pub fn alpha(&self) -> f64 {
        self.method.alpha.unwrap_or_default()
    }
}

/// Most cells along a knob.
const MAX_CELLS: usize = 64;

impl Role for StabilityMethod {
    fn role(&self) -> Option<&str> {
        self.role.as_deref()
    }
}

impl Settings for StabilityExperiment {
    const KIND: &'static str = "stability";

    fn seed(&self) -> u64 {
        self.seed
    }

    fn check(&self) -> Result<(), EvaluationError> {
        let fail = |key: &str, reason: String| Err(EvaluationError::Key { key: key.to_owned(), reason });
        if !(1..=MAX_CELLS).contains(&self.cells) {
            return fail("cells", format!("cells = {} is not between 1 and {MAX_CELLS}", self.cells));
        }
        if !(1..=MAX_SIZE).contains(&self.size) {
            return fail("size", format!("size = {} is not between 1 and {MAX_SIZE}", self.size));
        }
        let has_scenes = self.family.iter().any(|family| family.shape == Shape::Scenes);
        for (key, value, least) in [
            ("draws", self.draws, 1),
            ("family", self.family.len(), 1),
            ("technique", self.technique.len(), 1),
            ("scenes", self.scenes.len(), usize::from(has_scenes)),
            ("timing.inputs", self.timing.inputs, 1),
            ("timing.repetitions", self.timing.repetitions, 1),
        ] {
            if value < least {
                return fail(key, format!("{key}: {value} is less than {least}"));
            }
        }
        self.alphas.check()?;
        self.bias.check().map_err(in_key("bias"))?;
        let kernel = self.kernel.build().map_err(in_key("kernel"))?;
        if kernel.size() > self.size as usize {
            let reason = format!("kernel.size = {} exceeds the map's size = {}", kernel.size(), self.size);
            return fail("kernel.size", reason);
        }
        for (i, family) in self.family.iter().enumerate() {
            if self.family[..i].iter().any(|other| other.name == family.name) {
                let key = format!("family[{i}].name");
                return fail(&key, format!("family `{}` appears twice", family.name));
            }
            for (knob, Span { from, to }) in [("x", family.x), ("y", family.y)] {
                if !(from > 0.0 && from < to && to <= 1.0) {
                    let key = format!("family[{i}].{knob}");
                    return fail(&key, format!("{key}: from = {from}, to = {to} are no part of (0, 1]"));
                }
            }
        }
        check_roles(&self.technique, "technique")?;
        for (i, method) in self.technique.iter().enumerate() {
            if self.technique[..i].iter().any(|other| other.name == method.name) {
                let key = format!("technique[{i}].name");
                return fail(&key, format!("technique `{}` appears twice", method.name));
            }
            Prepared::new(method, &format!("technique[{i}]"))?;
        }
        Ok(())
    }

    fn scenes(&self) -> Option<&[String]> {
        Some(&self.scenes)
    }

    fn replace_scenes(&mut self, scenes: &[String]) {
        self.scenes = scenes.to_vec();
        self.views.clear();
    }

    fn run(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        self.evaluate(context)
    }
}

impl Span {
    /// The value at a fraction of the way, in logarithms.
    pub(crate) fn at(self, fraction: f64) -> f64 {
        self.from * (self.to / self.from).powf(fraction)
    }

    /// The cell of a value among so many; values outside are in the nearest one.
    pub(crate) fn cell(self, value: f64, cells: usize) -> usize {
        let fraction = (value / self.from).ln() / (self.to / self.from).ln();
        // A saturating cast: what lies below the span is in its first cell.
        ((fraction * cells as f64) as usize).min(cells - 1)
    }
}

impl Shape {
    /// What x and y are, for axes.
    pub fn knobs(self) -> [&'static str; 2] {
        match self {
            Self::OneSurface => ["thickness", "distance to z_f"],
            Self::TwoSurfaces => ["thickness", "distance"],
            Self::LightSurface => ["weight of the second", "distance"],
            Self::AtSurface => ["distance of z_f", "thickness"],
            Self::ThreeSurfaces => ["z_f to the middle", "spacing"],
            Self::Pole => ["z_f to the pole", "thickness"],
            Self::SqueezedRange => ["width of the range", "middle to the end"],
            Self::Scenes => ["depths in the kernel", "z_f to the nearest"],
        }
    }
}
