//! The passes of a shadowed frame as compute shaders, from the same functions as the fragment shaders.

use std::fmt::Write as _;

use shaders::{TexelFormat, count};

use crate::kernel::Kernel;
use crate::passes::{fetch, gathered, maps, written};
use crate::wgsl;

pub(crate) const FRAME: &str = include_str!("compute_frame.wgsl");
pub(crate) const PYRAMID: &str = include_str!("compute_pyramid.wgsl");
const FILTER: &str = include_str!("compute_filter.wgsl");

pub(crate) const RESOLVE: &str = "
@compute @workgroup_size(8, 8)
fn resolve(@builtin(global_invocation_id) id: vec3<u32>) {
    let texel = vec2<i32>(id.xy);
    if all(texel < target_size()) {
        store0(texel, resolved(texel));
    }
}
";

/// Change of the position on the map from pixel to pixel, in texels.
pub(crate) const DERIVATIVES: &str = "
var<private> across: vec2<f32>;
var<private> down: vec2<f32>;
";

/// Storage textures that every adapter lets a pass write.
const MOST_TARGETS: usize = 4;

/// Bytes of workgroup memory that every adapter offers.
const WORKGROUP_BYTES: usize = 16_384;

/// Direction of a filter pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Axis {
    X,
    Y,
}

/// Levels of the pyramid that one pass writes.
pub(crate) fn most_levels(textures: &[usize]) -> usize {
    MOST_TARGETS / textures.len()
}

/// Name of a storage texture's format, by how many of four channels are in use.
fn storage_format(format: TexelFormat, channels: usize) -> &'static str {
    match (format, channels) {
        (TexelFormat::F32, 1) => "r32float",
        (TexelFormat::F32, 2) => "rg32float",
        (TexelFormat::F32, _) => "rgba32float",
        (TexelFormat::F16, 1) => "r16float",
        (TexelFormat::F16, 2) => "rg16float",
        (TexelFormat::F16, _) => "rgba16float",
        (TexelFormat::Unorm16, 1) => "r16unorm",
        (TexelFormat::Unorm16, 2) => "rg16unorm",
        (TexelFormat::Unorm16, _) => "rgba16unorm",
    }
}

/// WGSL type of so many channels, and how they are taken from four.
fn vector(channels: usize) -> (&'static str, &'static str) {
    match channels {
        1 => ("f32", ".x"),
        2 => ("vec2<f32>", ".xy"),
        3 => ("vec3<f32>", ".xyz"),
        _ => ("vec4<f32>", ""),
    }
}

/// The textures that are written, `out0_0` being the first of level 0; `target_size`, `store0` for level 0, and `LEVELS` and
/// `store_level` where there are more.
pub(crate) fn stores(textures: &[usize], format: TexelFormat, levels: usize) -> String {
    let mut text = count("LEVELS", levels);
    for level in 0..levels {
        for (i, &channels) in textures.iter().enumerate() {
            let binding = 20 + level * textures.len() + i;
            let format = storage_format(format, channels);
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "@group(0) @binding({binding}) var out{level}_{i}: texture_storage_2d<{format}, write>;"
            );
        }
    }
    text += "fn target_size() -> vec2<i32> {\n    return vec2<i32>(textureDimensions(out0_0));\n}\n";
    for level in 0..levels {
        let mut lines = String::new();
        for (i, &channels) in textures.iter().enumerate() {
            let value =
                |k: usize| if k < channels { format!("values[{}]", 4 * i + k) } else { "0.0".to_owned() };
            let values = (0..4).map(value).collect::<Vec<_>>().join(", ");
            let _ = writeln!(lines, "    textureStore(out{level}_{i}, texel, vec4<f32>({values}));");
        }
        let _ =
            writeln!(text, "fn store{level}(texel: vec2<i32>, values: array<f32, CHANNELS>) {{\n{lines}}}");
    }
    let cases: String = (1..levels)
        .map(|level| {
            format!(
                "    if level == {level}u && all(texel < vec2<i32>(textureDimensions(out{level}_0))) {{ store{level}(texel, values); }}\n"
            )
        })
        .collect();
    let _ = writeln!(
        text,
        "fn store_level(level: u32, texel: vec2<i32>, values: array<f32, CHANNELS>) {{\n{cases}}}"
    );
    text
}

/// One pass of a separable kernel, by tiles in workgroup memory.
pub(crate) fn filter(textures: &[usize], format: TexelFormat, kernel: &Kernel, axis: Axis) -> String {
    let channels = textures.iter().sum();
    // Alignment makes three floats four.
    let bytes: usize = textures.iter().map(|&channels| if channels == 3 { 16 } else { 4 * channels }).sum();
    let along = match axis {
        Axis::X => 64,
        Axis::Y => 32,
    };
    let mut across = 256 / along;
    while across > 1 && (along + kernel.size() - 1) * across * bytes > WORKGROUP_BYTES {
        across /= 2;
    }
    let ([x, y], direction) = match axis {
        Axis::X => ([along, across], "1, 0"),
        Axis::Y => ([across, along], "0, 1"),
    };
    let numbers =
        [("CHANNELS", channels), ("ALONG", along), ("ACROSS", across), ("GROUP_X", x), ("GROUP_Y", y)];
    let constants: String = numbers.into_iter().map(|(name, value)| count(name, value)).collect();
    let [place, slot] = match axis {
        Axis::X => ["i % TILE, i / TILE", "place.y * i32(TILE) + place.x"],
        Axis::Y => ["i % ACROSS, i / ACROSS", "place.y * i32(ACROSS) + place.x"],
    };
    let mut text = format!("const AXIS = vec2<i32>({direction});\n");
    let (mut reads, mut sums, mut taps, mut written_texels) = Default::default();
    let stride = if axis == Axis::X { "1u" } else { "ACROSS" };
    for (i, &channels) in textures.iter().enumerate() {
        let (kind, part) = vector(channels);
        let _ = writeln!(text, "var<workgroup> tile{i}: array<{kind}, TILE * ACROSS>;");
        let line: &mut String = &mut reads;
        let _ = writeln!(line, "    tile{i}[i] = textureLoad(map{i}, texel, 0){part};");
        let line: &mut String = &mut sums;
        let _ = writeln!(line, "    var sum{i} = {kind}();");
        let line: &mut String = &mut taps;
        let _ = writeln!(line, "        sum{i} = sum{i} + weights[k] * tile{i}[first + k * {stride}];");
        let rest = ", 0.0".repeat(4 - channels.min(4));
        let line: &mut String = &mut written_texels;
        let _ = writeln!(line, "    textureStore(out0_{i}, texel, vec4<f32>(sum{i}{rest}));");
    }
    let _ = writeln!(
        text,
        "
fn place_of(i: u32) -> vec2<i32> {{
    return vec2<i32>(vec2<u32>({place}));
}}

fn slot(place: vec2<i32>) -> u32 {{
    return u32({slot});
}}

fn read_into(i: u32, texel: vec2<i32>) {{
{reads}}}

fn store_sum(texel: vec2<i32>, first: u32) {{
    var weights = WEIGHTS;
{sums}    for (var k = 0u; k < SIZE; k++) {{
{taps}    }}
{written_texels}}}"
    );
    written(&[
        &constants,
        &wgsl::weights(kernel),
        &fetch(channels),
        &stores(textures, format, 1),
        FILTER,
        &text,
    ])
}

/// `shadow_at` by a sample of the filtered map with derivatives.
pub(crate) fn sampled(channels: usize) -> String {
    let samples: String = (0..channels.div_ceil(4))
        .map(|i| format!("    let a{i} = textureSampleGrad(map{i}, linear, uv, across / light.map.x, down / light.map.x);\n"))
        .collect();
    format!(
        "{}{DERIVATIVES}@group(0) @binding(2) var linear: sampler;

fn shadow_at(texel: vec2<f32>, z_f: f32, gradient: vec2<f32>) -> f32 {{
    let uv = texel / light.map.x;
{samples}    return shade(dequantise({}), z_f);
}}
",
        maps(channels),
        gathered(channels)
    )
}
