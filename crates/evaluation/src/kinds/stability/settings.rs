//! The TOML keys of the kind `stability`.

use crate::experiment::Alphas;
use crate::fragments::SceneSettings;
use crate::role::plays_a_role;
use moment_problem::MomentBound;
use serde::{Deserialize, Serialize};
use shadow_filtering::{DepthBias, TechniqueSpec};

/// The TOML keys of this kind, beside `kind` and `scale`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct StabilityExperiment {
    /// Scenes, shadow maps and filter; its keys stand beside the others.
    #[serde(skip)]
    pub scenery: SceneSettings,
    /// Cells along each knob of a family.
    pub cells: usize,
    /// Inputs a cell on which every method is compared with the exact bound, at every moment bias.
    pub draws: usize,
    /// Further inputs a cell on which our forms in `f32` and `f64` are held to F and to \[0, 1\].
    pub checked: usize,
    /// Moment biases that are tried, besides 0 and each method's own.
    pub alphas: Alphas,
    /// What is timed after all errors are known.
    pub timing: StabilityTiming,
    /// Bias of the depth that is compared.
    pub bias: DepthBias,
    /// The families of inputs.
    pub family: Vec<StabilityFamily>,
    /// The methods.
    pub technique: Vec<StabilityMethod>,
}

/// Timed bounds per method.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct StabilityTiming {
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
    /// Half precision.
    F16,
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

plays_a_role!(StabilityMethod);

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
