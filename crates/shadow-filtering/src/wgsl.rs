//! WGSL twins put together: constants of a technique, then the files that its mathematics needs.

use crate::kernel::Kernel;
use moment_problem::MomentBound;
use moment_problem::wgsl::{CHEBYSHEV, ELEMENTARY};
use shaders::{array, constant, count, flag, unroll};

const MOMENTS: &str = include_str!("techniques/moments.wgsl");

fn joined(parts: &[&str]) -> Option<String> {
    Some(unroll(&parts.join("\n")))
}

pub(crate) fn variance() -> Option<String> {
    joined(&[ELEMENTARY, CHEBYSHEV, include_str!("techniques/variance.wgsl")])
}

pub(crate) fn exponential(exponent: f64) -> Option<String> {
    let constants = constant("EXPONENT", exponent);
    joined(&[&constants, ELEMENTARY, include_str!("techniques/exponential.wgsl")])
}

pub(crate) fn exponential_variance(positive: f64, negative: Option<f64>) -> Option<String> {
    let mut constants = constant("POSITIVE", positive) + &constant("NEGATIVE", negative.unwrap_or_default());
    constants += &count("CHANNELS", if negative.is_some() { 4 } else { 2 });
    joined(&[&constants, ELEMENTARY, CHEBYSHEV, include_str!("techniques/exponential_variance.wgsl")])
}

pub(crate) fn layered_variance(layers: usize) -> Option<String> {
    let constants = count("LAYERS", layers);
    joined(&[&constants, ELEMENTARY, CHEBYSHEV, include_str!("techniques/layered_variance.wgsl")])
}

pub(crate) fn convolution(
    frequency: f64,
    delta: f64,
    [low, high]: [f64; 2],
    amplitudes: &[f64],
) -> Option<String> {
    let mut constants = count("COEFFICIENTS", amplitudes.len());
    for (name, value) in [("FREQUENCY", frequency), ("DELTA", delta), ("LOW", low), ("SPAN", high - low)] {
        constants += &constant(name, value);
    }
    constants += &array("AMPLITUDES", amplitudes);
    joined(&[&constants, ELEMENTARY, include_str!("techniques/convolution.wgsl")])
}

/// `None` for eight moments, which no frame has been given yet.
pub(crate) fn moments(
    bound: MomentBound,
    signed: bool,
    alpha: f64,
    centre: &[f64],
    beta: f64,
) -> Option<String> {
    let order = bound.order();
    let mut constants = count("CHANNELS", order);
    for (name, value) in [("ALPHA", alpha), ("KEEP", 1.0 - alpha), ("BETA", beta)] {
        constants += &constant(name, value);
    }
    constants += &array("CENTRE", centre);
    constants += &flag("SIGNED", signed);
    let mut parts = vec![constants.as_str()];
    parts.extend(bound.wgsl()?);
    parts.push(MOMENTS);
    joined(&parts)
}

/// WGSL of [`Reference::intensity`](crate::Reference::intensity) without its bias, at any position in texels:
/// `fn percentage_closer(depths: texture_2d<f32>, at: vec2<f32>, z_f: f32, gradient: vec2<f32>) -> f32`. A plane limit of 0
/// compares every tap with z_f.
pub fn percentage_closer(kernel: &Kernel, plane_limit: f64) -> String {
    let constants = weights(kernel) + &constant("PLANE_LIMIT", plane_limit);
    unroll(&[&constants, ELEMENTARY, include_str!("percentage_closer.wgsl")].join("\n"))
}

/// `const SIZE` and `const WEIGHTS` of a kernel.
pub(crate) fn weights(kernel: &Kernel) -> String {
    count("SIZE", kernel.size()) + &array("WEIGHTS", kernel.weights())
}
