//! The passes of a shadowed frame as WGSL modules: resolve with transform, filter, mip maps, shading (MSM15 section 4.4,
//! GDC16).
//!
//! Textures hold four channels each, the last one possibly fewer.

use crate::compute_passes::{self, Axis};
use crate::encoding;
use crate::kernel::Kernel;
use crate::technique::Technique;
use crate::wgsl;
use quantization::NumberFormat;
use shaders::{ComputeShaders, FrameShaders, TexelFormat, count, unroll};
use std::fmt::Write as _;

const COVER: &str = include_str!("cover.wgsl");
const FRAME: &str = include_str!("frame.wgsl");
const RESOLVE: &str = include_str!("resolve.wgsl");
const PYRAMID: &str = include_str!("pyramid.wgsl");

/// A fragment shader `NAME` that puts an array of channels at each texel.
fn to_each(name: &str, function: &str) -> String {
    format!(
        "
@fragment
fn {name}(@builtin(position) at: vec4<f32>) -> Targets {{
    return to_targets({function}(vec2<i32>(at.xy)));
}}
"
    )
}

const PIXEL: &str = "
@fragment
fn pixel(@builtin(position) at: vec4<f32>) -> Pixel {
    return shaded(vec2<i32>(at.xy));
}
";

/// Most textures of a map: more would exceed what every adapter can render to at once.
const MAX_TEXTURES: usize = 2;

impl Technique {
    /// WGSL of `quantise` and `dequantise`, from `array<f32, CHANNELS>` to the same: the transform of
    /// [`Technique::encode`] before rounding, and [`Technique::restore`].
    pub fn transform_wgsl(&self) -> [String; 2] {
        encoding::wgsl(self.single_encoding())
    }

    /// The passes of a frame, from depth maps with so many samples; `None` where there is no shader, or where the map
    /// would need more than two textures.
    pub fn passes(&self, kernel: &Kernel, samples: u32) -> Option<FrameShaders> {
        let channels = self.channels();
        let technique = self.real_time()?.shader()?;
        let textures: Vec<usize> = (0..channels.div_ceil(4)).map(|i| (channels - 4 * i).min(4)).collect();
        let format = match self.encoding().format() {
            NumberFormat::Unorm16 => TexelFormat::Unorm16,
            NumberFormat::F16 => TexelFormat::F16,
            NumberFormat::F32 => TexelFormat::F32,
            NumberFormat::Unorm10 | NumberFormat::U32Fixed { .. } => return None,
        };
        if textures.len() > MAX_TEXTURES {
            return None;
        }
        let targets = targets(channels);
        let fetch = fetch(channels);
        let channel_count = count("CHANNELS", channels);
        let weights = wgsl::weights(kernel);
        let multisampled = if samples > 1 { "texture_depth_multisampled_2d" } else { "texture_depth_2d" };
        let sample = if samples > 1 { "s" } else { "0" };
        let depths = format!(
            "const SAMPLES: i32 = {samples};
@group(0) @binding(3) var depths: {multisampled};
fn sample_depth(texel: vec2<i32>, s: i32) -> f32 {{
    return textureLoad(depths, texel, {sample});
}}
"
        );
        let [quantise, dequantise] = self.transform_wgsl();
        let filter = |axis: &str| {
            let axis = format!("const AXIS = vec2<i32>({axis});\n");
            let own = include_str!("filter.wgsl");
            written(&[COVER, &channel_count, &weights, &fetch, &targets, &axis, own])
        };
        Some(FrameShaders::Prefiltered {
            resolve: written(&[
                COVER,
                &technique,
                &quantise,
                &depths,
                &targets,
                RESOLVE,
                &to_each("resolve", "resolved"),
            ]),
            rows: filter("1, 0"),
            columns: filter("0, 1"),
            halve: written(&[COVER, &channel_count, &fetch, &targets, PYRAMID, &to_each("halve", "halved")]),
            shade: written(&[COVER, &technique, &dequantise, &sampled(channels), FRAME, PIXEL]),
            compute: ComputeShaders {
                resolve: written(&[
                    &technique,
                    &quantise,
                    &depths,
                    RESOLVE,
                    &compute_passes::stores(&textures, format, 1),
                    compute_passes::RESOLVE,
                ]),
                rows: compute_passes::filter(&textures, format, kernel, Axis::X),
                columns: compute_passes::filter(&textures, format, kernel, Axis::Y),
                halve: (1..=compute_passes::most_levels(&textures))
                    .map(|levels| {
                        let parts = [
                            &channel_count,
                            &fetch,
                            PYRAMID,
                            &compute_passes::stores(&textures, format, levels),
                            compute_passes::PYRAMID,
                        ];
                        written(&parts)
                    })
                    .collect(),
                shade: written(&[
                    &technique,
                    &dequantise,
                    &compute_passes::sampled(channels),
                    FRAME,
                    compute_passes::FRAME,
                ]),
            },
            textures,
            format,
        })
    }
}

pub(crate) fn written(parts: &[&str]) -> String {
    unroll(&parts.join("\n"))
}

/// Shading by percentage-closer filtering around the nearest texel of a depth map with one sample; the receiver's plane
/// counts up to `plane_limit`.
pub fn comparison_shaders(kernel: &Kernel, plane_limit: f64) -> FrameShaders {
    let shadow_at = "
@group(0) @binding(3) var depths: texture_2d<f32>;
fn shadow_at(texel: vec2<f32>, z_f: f32, gradient: vec2<f32>) -> f32 {
    return percentage_closer(depths, texel, z_f, gradient);
}
";
    let closer = wgsl::percentage_closer(kernel, plane_limit);
    FrameShaders::Comparison {
        shade: [COVER, &closer, shadow_at, FRAME, PIXEL].join("\n"),
        compute_shade: [&closer, shadow_at, FRAME, compute_passes::DERIVATIVES, compute_passes::FRAME]
            .join("\n"),
    }
}

/// `Targets` and `to_targets`.
fn targets(channels: usize) -> String {
    let count = channels.div_ceil(4);
    let mut text = "struct Targets {\n".to_owned();
    for i in 0..count {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "    @location({i}) map{i}: vec4<f32>,");
    }
    let vector = |i: usize| {
        let value = |k: usize| if k < channels { format!("values[{k}]") } else { "0.0".to_owned() };
        format!("vec4<f32>({})", (4 * i..4 * i + 4).map(value).collect::<Vec<_>>().join(", "))
    };
    let vectors = (0..count).map(vector).collect::<Vec<_>>().join(", ");
    let _ = writeln!(
        text,
        "}}\n\nfn to_targets(values: array<f32, CHANNELS>) -> Targets {{\n    return Targets({vectors});\n}}"
    );
    text
}

pub(crate) fn maps(channels: usize) -> String {
    let binding = |i: usize| format!("@group(0) @binding({i}) var map{i}: texture_2d<f32>;\n");
    (0..channels.div_ceil(4)).map(binding).collect()
}

/// An array of all channels from expressions of vectors called `a0`, `a1`.
pub(crate) fn gathered(channels: usize) -> String {
    let value = |k: usize| format!("a{}.{}", k / 4, ["x", "y", "z", "w"][k % 4]);
    format!("array<f32, {channels}>({})", (0..channels).map(value).collect::<Vec<_>>().join(", "))
}

/// `map_size` and `fetch`.
pub(crate) fn fetch(channels: usize) -> String {
    let loads: String = (0..channels.div_ceil(4))
        .map(|i| format!("    let a{i} = textureLoad(map{i}, texel, 0);\n"))
        .collect();
    format!(
        "{}
fn map_size() -> vec2<i32> {{
    return vec2<i32>(textureDimensions(map0));
}}

fn fetch(texel: vec2<i32>) -> array<f32, CHANNELS> {{
{loads}    return {};
}}
",
        maps(channels),
        gathered(channels)
    )
}

/// `shadow_at` by a sample of the filtered map.
fn sampled(channels: usize) -> String {
    let samples: String = (0..channels.div_ceil(4))
        .map(|i| format!("    let a{i} = textureSample(map{i}, linear, uv);\n"))
        .collect();
    format!(
        "{}@group(0) @binding(2) var linear: sampler;

fn shadow_at(texel: vec2<f32>, z_f: f32, gradient: vec2<f32>) -> f32 {{
    let uv = texel / light.map.x;
{samples}    return shade(dequantise({}), z_f);
}}
",
        maps(channels),
        gathered(channels)
    )
}
