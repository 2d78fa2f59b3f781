//! WGSL twins put together: constants of a technique, then the files that its mathematics needs.

use crate::kernel::Kernel;
use crate::unroll::unroll;
use moment_problem::{Interval, MomentBound};
use std::fmt::Write as _;

const ELEMENTARY: &str = include_str!("techniques/elementary.wgsl");
const CHEBYSHEV: &str = include_str!("techniques/chebyshev.wgsl");
const ROOTS: &str = include_str!("techniques/roots.wgsl");
const BIAS: &str = include_str!("techniques/bias.wgsl");
const MOMENTS: &str = include_str!("techniques/moments.wgsl");
const POWERS: &str = include_str!("techniques/powers.wgsl");
const HAMBURGER_4: &str = include_str!("techniques/hamburger4.wgsl");

/// A number as WGSL reads it back exactly.
fn number(value: f64) -> String {
    format!("{:?}f", value as f32)
}

fn numbers(values: impl IntoIterator<Item = f64>) -> String {
    values.into_iter().map(number).collect::<Vec<_>>().join(", ")
}

fn constant(name: &str, value: f64) -> String {
    format!("const {name}: f32 = {};\n", number(value))
}

fn array(name: &str, values: &[f64]) -> String {
    let count = values.len();
    let values = numbers(values.iter().copied());
    format!("const {name}: array<f32, {count}> = array<f32, {count}>({values});\n")
}

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
    // Writing to a string cannot fail.
    let _ = writeln!(constants, "const CHANNELS: u32 = {}u;", if negative.is_some() { 4 } else { 2 });
    joined(&[&constants, ELEMENTARY, CHEBYSHEV, include_str!("techniques/exponential_variance.wgsl")])
}

pub(crate) fn layered_variance(layers: usize) -> Option<String> {
    let constants = format!("const LAYERS: u32 = {layers}u;\n");
    joined(&[&constants, ELEMENTARY, CHEBYSHEV, include_str!("techniques/layered_variance.wgsl")])
}

pub(crate) fn convolution(
    frequency: f64,
    delta: f64,
    [low, high]: [f64; 2],
    amplitudes: &[f64],
) -> Option<String> {
    let mut constants = format!("const COEFFICIENTS: u32 = {}u;\n", amplitudes.len());
    for (name, value) in [("FREQUENCY", frequency), ("DELTA", delta), ("LOW", low), ("SPAN", high - low)] {
        constants += &constant(name, value);
    }
    constants += &array("AMPLITUDES", amplitudes);
    joined(&[&constants, ELEMENTARY, include_str!("techniques/convolution.wgsl")])
}

/// `None` for eight moments, which no frame has been given yet.
pub(crate) fn moments(bound: MomentBound, alpha: f64, beta: f64) -> Option<String> {
    let order = bound.order();
    let mut constants = format!("const CHANNELS: u32 = {order}u;\n");
    for (name, value) in [("ALPHA", alpha), ("KEEP", 1.0 - alpha), ("BETA", beta)] {
        constants += &constant(name, value);
    }
    constants += &array("CENTRE", bound.centre());
    let _ = writeln!(constants, "const SIGNED: bool = {};", bound.interval() == Interval::Real);
    let own: &[&str] = match bound {
        MomentBound::Hamburger2 => {
            &[CHEBYSHEV, POWERS, include_str!("techniques/hamburger2_bounds.wgsl"), BIAS]
        }
        MomentBound::Hamburger4 => {
            &[CHEBYSHEV, POWERS, HAMBURGER_4, include_str!("techniques/hamburger4_bounds.wgsl"), BIAS]
        }
        MomentBound::Hamburger6 => &[CHEBYSHEV, POWERS, include_str!("techniques/canonical.wgsl"), BIAS],
        MomentBound::Hausdorff4 => {
            &[CHEBYSHEV, POWERS, HAMBURGER_4, include_str!("techniques/hausdorff4.wgsl")]
        }
        MomentBound::Trigonometric4 => &[CHEBYSHEV, include_str!("techniques/trigonometric4.wgsl"), BIAS],
        MomentBound::Hamburger8 => return None,
    };
    let mut parts = vec![constants.as_str(), ELEMENTARY, ROOTS];
    parts.extend(own);
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
pub fn weights(kernel: &Kernel) -> String {
    format!("const SIZE: u32 = {}u;\n", kernel.size()) + &array("WEIGHTS", kernel.weights())
}
