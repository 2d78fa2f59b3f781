//! WGSL twins of the methods as compute modules, for maps of a given size.
//!
//! Bindings of a pass in which fragments are shaded, all in group 0: 0 the prefix sums `table: array<u32>`, or the depths of
//! percentage-closer soft shadows as a texture; 1 the fragments, `vec4<f32>(x, y, depth, bias)` in texels and depths; 2
//! the shadows, `array<f32>`; 3 the uniform of [`penumbra_uniform`]; with dithered corners 4 the noise, two numbers a fragment.
//! Entry point `shade`, 64 threads a group.

use moment_problem::wgsl::ELEMENTARY;
use quantization::NumberFormat;
use shaders::{array, constant, count, flag, unroll, whole_numbers};

use super::{BlockerSearch, Filter, LEAST_BIAS_SHARE, Penumbra, Reconstruction, Storage, Warp};
use crate::field::Fit;

const REGION: &str = include_str!("../region.wgsl");
const FIELD: &str = include_str!("../field.wgsl");
const PREFIX_SUMS: &str = include_str!("../prefix_sums.wgsl");
const WARP: &str = include_str!("warp.wgsl");
const SOFT_SHADOW: &str = include_str!("soft_shadow.wgsl");
const FILTERED_HARD: &str = include_str!("filtered_hard.wgsl");
const FILTERABLE: &str = include_str!("filterable.wgsl");
const FIXED_SIZE: &str = include_str!("fixed_size.wgsl");
const PERCENTAGE_CLOSER: &str = include_str!("percentage_closer.wgsl");
const STORED_POWERS: &str = include_str!("../stored_powers.wgsl");
const NOISE: &str = include_str!("noise.wgsl");
const NO_NOISE: &str = "fn noise_of(fragment: u32) -> vec2<f32> { return vec2<f32>(0.0); }";
const SHADE: &str = include_str!("shade.wgsl");

/// Stands for no limit of widths, as shaders have no infinite constant.
const UNLIMITED: f64 = 1e30;

const TABLE: &str = "@group(0) @binding(0) var<storage, read> table: array<u32>;";
const DEPTHS: &str = "@group(0) @binding(0) var depths: texture_2d<f32>;";

/// What a shader reads as `Penumbra`: the light's full widths in texels, the near distance (0 for a light at infinity) and
/// the depth range, see [`Penumbra`].
pub fn penumbra_uniform(penumbra: &Penumbra<f64>) -> [f32; 4] {
    let light = [0, 1].map(|k| (2.0 * penumbra.half_size[k] * penumbra.texels_per_unit[k]) as f32);
    [light[0], light[1], penumbra.near.unwrap_or(0.0) as f32, penumbra.depth_range as f32]
}

/// How a method finds the size of its filter.
#[derive(Clone, Copy, Debug)]
pub enum FilterSize<'a> {
    /// From blockers.
    Searched(&'a BlockerSearch<f64>),
    /// Full widths in texels.
    Fixed([f64; 2]),
}

/// Shades fragments by two queries to a field of moments, or by one of fixed size; regions may have `texels` texels.
/// `None` for bounds without a shader.
pub fn filterable_shader(
    technique: &Reconstruction<f64>,
    size: [usize; 2],
    texels: u32,
    filter_size: FilterSize<'_>,
    filter: &Filter<f64>,
) -> Option<String> {
    let mut constants = of_technique(technique, size, texels) + &of_filter(filter);
    let bound = technique.bound();
    let alpha = technique.moment_bias();
    for (name, value) in [("ALPHA", alpha), ("KEEP", 1.0 - alpha)] {
        constants += &constant(name, value);
    }
    constants += &array("CENTRE", technique.centre());
    let mut parts = vec![TABLE];
    parts.extend(bound.wgsl()?);
    parts.extend(bound.wgsl_in_front()?);
    parts.extend([REGION, FIELD, WARP, STORED_POWERS, noise_of(filter), FILTERED_HARD]);
    match filter_size {
        FilterSize::Searched(search) => {
            constants += &of_search(search);
            parts.extend([SOFT_SHADOW, FILTERABLE]);
        }
        FilterSize::Fixed(widths) => {
            constants += &(array("FIXED_WIDTHS", &widths) + &of_search(&BlockerSearch::published()));
            parts.extend([SOFT_SHADOW, FIXED_SIZE]);
        }
    }
    parts.push(SHADE);
    Some(joined(&constants, &parts))
}

/// Shades fragments by percentage-closer soft shadows.
pub fn percentage_closer_shader(
    size: [usize; 2],
    search: &BlockerSearch<f64>,
    filter: &Filter<f64>,
) -> String {
    let constants = of_size(size) + &of_filter(filter) + &of_search(search);
    joined(&constants, &[DEPTHS, ELEMENTARY, REGION, noise_of(filter), SOFT_SHADOW, PERCENTAGE_CLOSER, SHADE])
}

/// Makes the table of a depth map: binding 0 the depths as a texture, binding 1 the table. Entry point `rows` with a group a
/// row, then `columns` with a group for 16 columns and channels.
pub fn prefix_sums_shader(technique: &Reconstruction<f64>, size: [usize; 2], texels: u32) -> String {
    joined(&of_technique(technique, size, texels), &[ELEMENTARY, WARP, PREFIX_SUMS])
}

fn noise_of(filter: &Filter<f64>) -> &'static str {
    if filter.dithered { NOISE } else { NO_NOISE }
}

fn joined(constants: &str, parts: &[&str]) -> String {
    unroll(&format!("{constants}\n{}", parts.join("\n")))
}

fn of_size(size: [usize; 2]) -> String {
    count("WIDTH", size[0]) + &count("HEIGHT", size[1])
}

fn of_technique(technique: &Reconstruction<f64>, size: [usize; 2], texels: u32) -> String {
    let exponent = match technique.warp() {
        Warp::None => 0.0,
        Warp::Exponential(c) => c,
    };
    let scale = NumberFormat::fixed_point_scale(texels);
    let [matrix, inverse, offset] = technique.affine();
    let in_units = |values: &[f64]| -> Vec<i32> {
        values.iter().map(|value| (value * f64::from(1 << 28)).round() as i32).collect()
    };
    of_size(size)
        + &flag("SIGNED", technique.storage() != Storage::Unit)
        + &array("INVERSE", &inverse)
        + &array("OFFSET", &offset)
        + &whole_numbers("MATRIX_28", &in_units(&matrix))
        + &whole_numbers("OFFSET_28", &in_units(&offset))
        + &count("CHANNELS", technique.channels())
        + &count("SCALE", scale as usize)
        + &constant("WARP", exponent)
        + &constant("WARP_SPAN", exponent.exp() - 1.0)
}

fn of_filter(filter: &Filter<f64>) -> String {
    of_fits()
        + &flag("DITHERED", filter.dithered)
        + &constant("LEAST_WIDTH", filter.least_width)
        + &constant("FULL_BIAS_WIDTH", filter.full_bias_width)
        + &constant("LEAST_BIAS_SHARE", LEAST_BIAS_SHARE)
        + &format!("const FILTER_FIT: u32 = {};\n", fit_name(filter.fit))
}

fn of_search(search: &BlockerSearch<f64>) -> String {
    constant("SEARCH_EPSILON", search.epsilon)
        + &constant("SEARCH_BIAS_SHARE", search.bias_share)
        + &constant("MOST_WIDTH", search.most_width.min(UNLIMITED))
        + &constant("UMBRA", search.umbra)
        + &format!("const SEARCH_FIT: u32 = {};\n", fit_name(search.fit))
}

/// The name that region.wgsl knows a fit by.
fn fit_name(fit: Fit) -> &'static str {
    match fit {
        Fit::Covered => "COVERED",
        Fit::Outwards => "OUTWARDS",
        Fit::Nearest => "NEAREST",
    }
}

fn of_fits() -> String {
    let fits = [Fit::Covered, Fit::Outwards, Fit::Nearest].into_iter().enumerate();
    fits.map(|(code, fit)| count(fit_name(fit), code)).collect()
}
