//! What an implementation needs beside a technique's name.

use crate::kinds::speed_accuracy::SceneView;
use serde::Serialize;
use shadow_filtering::{DepthBias, Kernel, Technique, TechniqueSpec};

/// Everything that is stored, filtered and biased, in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shipping {
    /// What a texel stores of the depth z in \[0, 1\], 0 at the light, before the transform.
    pub functions: String,
    /// Rows of the matrix T: a texel holds T b(z) + offset, and the filtered texel is restored by the inverse.
    pub matrix: Vec<Vec<f64>>,
    /// Added to it.
    pub offset: Vec<f64>,
    /// b*: the restored b becomes (1 - alpha) b + alpha b*. Empty for techniques without moment bias.
    pub centre: Vec<f64>,
    /// Weights of the separable filter along each axis.
    pub kernel: Vec<f64>,
    /// The depth bias in each view.
    pub depth_bias: Vec<BiasInView>,
}

/// A depth bias in the units of a view.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BiasInView {
    /// The view.
    pub view: String,
    /// Side of a texel of the chosen map in world units; for local lights in the middle of the depth range.
    pub texel_side: Option<f64>,
    /// World units from depth 0 to depth 1.
    pub depth_range: Option<f64>,
    /// The bias without its slopes, as a depth in \[0, 1\].
    pub depth: f64,
    /// The same in world units.
    pub world: Option<f64>,
}

impl Shipping {
    /// `bias` is in texels of a map whose side is the views' divided by the number beside it.
    pub(super) fn of(
        spec: &TechniqueSpec,
        technique: &Technique,
        kernel: &Kernel,
        (bias, divisor): (DepthBias, u32),
        views: &[SceneView],
    ) -> Self {
        let transform = technique.encoding().transform();
        let biased = spec.biased_moments().ok().flatten();
        Self {
            functions: functions(spec),
            matrix: transform.matrix().chunks(transform.order()).map(<[f64]>::to_vec).collect(),
            offset: transform.offset().to_vec(),
            centre: biased.map(|biased| biased.centre().to_vec()).unwrap_or_default(),
            kernel: kernel.weights().to_vec(),
            depth_bias: views.iter().map(|view| BiasInView::new(bias, divisor, view)).collect(),
        }
    }
}

impl BiasInView {
    /// See [`Shipping::of`].
    pub(super) fn new(bias: DepthBias, divisor: u32, view: &SceneView) -> Self {
        let texel_depth = f64::from(divisor) * view.texel_depth;
        let depth_range = view.frame.as_ref().map(|frame| frame.depth_range);
        let depth = bias.texels * texel_depth;
        Self {
            view: view.view.clone(),
            texel_side: depth_range.map(|range| range * texel_depth),
            depth_range,
            depth,
            world: depth_range.map(|range| range * depth),
        }
    }
}

/// b(z) in words of mathematics.
fn functions(spec: &TechniqueSpec) -> String {
    let powers = |variable: &str, order: usize| {
        let power = |k: usize| if k == 1 { variable.to_owned() } else { format!("{variable}^{k}") };
        (1..=order).map(power).collect::<Vec<_>>().join(", ")
    };
    if let Some(bound) = spec.moment_bound() {
        if bound.is_trigonometric() {
            return "sin(2 pi z), cos(2 pi z), sin(4 pi z), cos(4 pi z)".to_owned();
        }
        let signed = spec.stored_range().is_ok_and(|range| range == shadow_filtering::Range::Signed);
        let variable = if signed { "s" } else { "z" };
        let meaning = if signed { " with s = 2 z - 1" } else { "" };
        return format!("{}{meaning}", powers(variable, bound.order()));
    }
    let exponent = spec.exponent.unwrap_or_default();
    match spec.bound.map_or("certified", |bound| bound.as_str()) {
        "vsm" => powers("z", 2),
        "esm" => format!("exp({exponent} z)"),
        "evsm" => {
            let first = format!("u, u^2 with u = exp({exponent} s), s = 2 z - 1");
            match spec.negative_exponent {
                Some(negative) => format!("{first}; v, v^2 with v = -exp(-{negative} s)"),
                None => first,
            }
        }
        "lvsm" => {
            let layers = spec.layers.unwrap_or_default();
            format!("u, u^2 with u = clamp({layers} z - i, 0, 1) for i = 0 to {}", layers.saturating_sub(1))
        }
        "csm" | "fourier" => {
            let pairs = spec.coefficients.unwrap_or_default();
            format!("cos(c z), sin(c z) for {pairs} odd multiples c of one frequency")
        }
        _ => spec.basis.clone().unwrap_or_default(),
    }
}

/// What words in the answer mean.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Definitions {
    /// Of errors of hard shadows.
    pub error: &'static str,
    /// Of errors of soft shadows.
    pub soft_error: &'static str,
    /// Of the constant depth bias.
    pub bias_texels: &'static str,
    /// Of the one that grows.
    pub bias_slopes: &'static str,
    /// Of the moment bias.
    pub alpha: &'static str,
    /// Of beta and leak reduction.
    pub shadow: &'static str,
    /// Of costs.
    pub cost: &'static str,
}

/// The same for all answers.
pub const DEFINITIONS: Definitions = Definitions {
    error: "mean of |G - F| over all light-facing surfaces of all views, seen or not: G the technique's shadow, F \
            percentage-closer filtering with the same kernel at full size, each tap compared with the receiver's plane",
    soft_error: "mean of |G - F| over light-facing surfaces of all views: G the technique's shadow, F the share of the light \
                 that shadow rays find occluded",
    bias_texels: "1 is the depth by which a plane at 45 degrees to the light changes from one texel to the next: the side of a \
                  texel in world units over the depth range; the compared depth is moved by it towards the light",
    bias_slopes: "added to it: so many times |dz/dx| + |dz/dy| of the receiver per texel",
    alpha: "restored moments b become (1 - alpha) b + alpha b*",
    shadow: "min(1, (lower + beta (upper - lower)) / (1 - leak_reduction))",
    cost: "modelled memory traffic and arithmetic of a frame of 1920x1080 pixels, 16 operations counting as a byte; 1 is VSM in \
           f32 at full size",
};
