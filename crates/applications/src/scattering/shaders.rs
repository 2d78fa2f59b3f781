//! WGSL twins of the methods as compute modules, for maps of a given size. Their bindings stand in the modules, all in group 0;
//! the uniform is [`scattering_uniform`].

use moment_problem::wgsl::ELEMENTARY;
use shaders::{constant, count, unroll};
use shadow_filtering::{Precision, Technique};

use super::{Blending, FilteredDepths, Rectification, SingleScattering, StoredPrefixes};
use crate::packed_values;

const RECTIFIED: &str = include_str!("rectified.wgsl");
const RESAMPLE: &str = include_str!("resample.wgsl");
const RESAMPLE_FILTERED: &str = include_str!("resample_filtered.wgsl");
const PREFIX_MAP: &str = include_str!("prefix_map.wgsl");
const LOOK_UP: &str = include_str!("look_up.wgsl");
const TWO_SPACINGS: &str = include_str!("two_spacings.wgsl");
const ONE_SPACING: &str = "
fn between_spacings(dark: f32, place: Place, sine: f32, depth: f32, cosine: f32) -> f32 {
    return dark;
}
";
const MARCH: &str = include_str!("march.wgsl");

/// Bytes of workgroup memory that every adapter has.
const WORKGROUP_BYTES: usize = 16_384;

/// Most threads of a row.
const MOST_THREADS: usize = 128;

/// What shaders read as `Scattering`.
pub fn scattering_uniform(view: &SingleScattering<'_>, rectification: &Rectification) -> [f32; 16] {
    let camera = view.axes.direction(view.camera);
    let light = &view.light;
    let origin = [0, 1].map(|k| (camera[k] - light.corner[k]) / light.texel[k]);
    let [least, most] = rectification.flipped;
    let rows = rectification.size[1] as f64;
    [
        origin[0],
        origin[1],
        1.0 / light.texel[0],
        1.0 / light.texel[1],
        light.near - camera[2],
        light.range,
        rectification.column_width(),
        rectification.r_max,
        rectification.phi_start,
        rows / rectification.phi_extent,
        least,
        1.0 / (most - least),
        view.medium.extinction(),
        f64::from(u8::from(rectification.wraps())),
        0.0,
        0.0,
    ]
    .map(|value| value as f32)
}

/// Words of 32 bits of a texel of the prefix map.
pub fn prefix_words(technique: &Technique) -> usize {
    packed_values::words(technique)
}

/// Resamples a shadow map of any size without a filter. Entry point `resample`, 64 texels a group.
pub fn resample_shader(size: [usize; 2]) -> String {
    joined(&of_size(size), &[ELEMENTARY, RECTIFIED, RESAMPLE])
}

/// Resamples the mip maps of a moment shadow map with a filter. Entry point `resample_filtered`, 64 texels a group.
pub fn resample_filtered_shader<P: Precision>(depths: &FilteredDepths<'_, P>, size: [usize; 2]) -> String {
    let levels = depths.levels.levels();
    let [start, end] = depths.ends;
    let counts = [
        ("CHANNELS", depths.technique.channels()),
        ("LEVELS", levels.len()),
        ("MAP_WIDTH", levels[0].width()),
        ("MAP_HEIGHT", levels[0].height()),
    ];
    let counts: String = counts.into_iter().map(|(name, value)| count(name, value)).collect();
    let ends = format!("const START: f32 = {:?}f;\nconst END: f32 = {:?}f;\n", start as f32, end as f32);
    let [_, dequantise] = depths.technique.transform_wgsl();
    joined(&(of_size(size) + &counts + &ends), &[ELEMENTARY, RECTIFIED, &dequantise, RESAMPLE_FILTERED])
}

/// Encodes and sums a rectified map. Entry point `prefix`, a group a row, and once more as many for a second spacing. `None` for what has no shader, and for formats that
/// it does not know.
pub fn prefix_map_shader(stored: &StoredPrefixes<'_>, size: [usize; 2]) -> Option<String> {
    let technique = stored.technique;
    let [quantise, _] = technique.transform_wgsl();
    // A power of two of rows of sums fits.
    let most = (WORKGROUP_BYTES / (4 * (technique.channels() + 1))).min(MOST_THREADS);
    let threads = 1usize << most.checked_ilog2()?;
    let constants = of_size(size) + &count("THREADS", threads);
    let functions = functions(stored)?;
    let store = packed_values::store_wgsl(technique, "stored")?;
    Some(joined(&constants, &[&functions, RECTIFIED, &quantise, PREFIX_MAP, &store]))
}

/// Looks rays up. Entry point `look_up`, 64 rays a group. `None` as for [`prefix_map_shader`].
pub fn look_up_shader(stored: &StoredPrefixes<'_>, size: [usize; 2]) -> Option<String> {
    looked_up(stored, size, ONE_SPACING)
}

/// The same between the two maps of [`super::Spacing::Two`], which lie one behind the other.
pub fn look_up_between_shader(stored: &StoredPrefixes<'_>, size: [usize; 2]) -> Option<String> {
    looked_up(stored, size, TWO_SPACINGS)
}

fn looked_up(stored: &StoredPrefixes<'_>, size: [usize; 2], spacings: &str) -> Option<String> {
    let technique = stored.technique;
    let [_, dequantise] = technique.transform_wgsl();
    let blended = "    let pair = biased_bounds(b, depth);\n    return pair.x + beta * (pair.y - pair.x);\n";
    let has_upper = technique.bound().has_upper();
    let (beta, answer) = match stored.blending {
        Blending::Adaptive if has_upper => ("let beta = clamp_unit(0.5 + 0.5 * cosine);".to_owned(), blended),
        Blending::Fixed(beta) if has_upper => (format!("let beta = {:?}f;", beta as f32), blended),
        Blending::Adaptive => return None,
        Blending::Fixed(_) => (String::new(), "    return shade(b, depth);\n"),
    };
    let shadowed = format!(
        "fn shadowed(b: array<f32, CHANNELS>, depth: f32, cosine: f32) -> f32 {{\n    {beta}\n{answer}}}\n"
    );
    let functions = functions(stored)?;
    let load = packed_values::load_wgsl(technique, "stored")?;
    Some(joined(&of_size(size), &[&functions, RECTIFIED, &dequantise, &shadowed, LOOK_UP, spacings, &load]))
}

/// Marches rays with so many steps. Entry point `march`, 64 rays a group.
pub fn march_shader(steps: usize) -> String {
    joined(&count("STEPS", steps), &[ELEMENTARY, RECTIFIED, MARCH])
}

fn joined(constants: &str, parts: &[&str]) -> String {
    unroll(&format!("{constants}\n{}", parts.join("\n")))
}

fn of_size([columns, rows]: [usize; 2]) -> String {
    count("COLUMNS", columns) + &count("ROWS", rows)
}

/// `encode`, the bound, and how depths are stored.
fn functions(stored: &StoredPrefixes<'_>) -> Option<String> {
    let margin = constant("MARGIN", stored.margin) + &constant("STORED_SPAN", 1.0 - 2.0 * stored.margin);
    let stored_depth = "fn stored_depth(depth: f32) -> f32 {\n    return MARGIN + STORED_SPAN * depth;\n}\n";
    Some(stored.technique.real_time()?.shader()? + &margin + stored_depth)
}
