//! A technique as one WGSL module to take home: functions without resources, and fragment shaders around them.

use shaders::{array, constant, count, laid_out, reachable, unroll};
use std::fmt::Write as _;

use crate::kernel::Kernel;
use crate::technique::Technique;

/// Most textures that a pass may render to everywhere.
const MOST_TEXTURES: usize = 8;

/// A step from depths to shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShadowPass {
    /// From a depth to a texel.
    Encode,
    /// From the depth samples of a pixel to a texel.
    Resolve,
    /// From texels to their weighted mean, along rows and then along columns.
    Filter,
    /// From a filtered texel and the depth of a fragment to its shadow.
    Shade,
}

impl ShadowPass {
    /// All of them, in order.
    pub const ALL: [Self; 4] = [Self::Encode, Self::Resolve, Self::Filter, Self::Shade];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Encode => "encode",
            Self::Resolve => "resolve",
            Self::Filter => "filter",
            Self::Shade => "shade",
        }
    }

    /// The functions that belong to it, without resources.
    pub fn functions(self) -> &'static [&'static str] {
        match self {
            Self::Encode => &["encode"],
            Self::Resolve => &["resolve"],
            Self::Filter => &["filter_taps"],
            Self::Shade => &["decode", "shade", "shadow"],
        }
    }

    /// Its fragment shaders.
    pub fn entry_points(self) -> &'static [&'static str] {
        match self {
            Self::Encode => &["encode_pixel"],
            Self::Resolve => &["resolve_pixel"],
            Self::Filter => &["filter_row", "filter_column"],
            Self::Shade => &["shade_pixel"],
        }
    }
}

/// What a module to take home has beside its technique.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings<'a> {
    /// The filter.
    pub kernel: &'a Kernel,
    /// Depth samples of a pixel.
    pub samples: usize,
    /// Shadows are divided by 1 less this, in \[0, 1), and cut off at 1.
    pub leak_reduction: f64,
}

impl Technique {
    /// WGSL of some passes with everything that they need: `encode(depth) -> Texel`, `resolve(depths) -> Texel`,
    /// `filter_taps(taps) -> Texel`, `decode(texel) -> array<f32, CHANNELS>`, `shade(filtered, z_f) -> f32`, `shadow(texel,
    /// z_f) -> f32`, and the fragment shaders of [`ShadowPass::entry_points`]. `Texel` is `f32` or a vector, or a structure of
    /// several where there are more than four channels.
    ///
    /// `None` without a shader, and for more channels than eight textures hold.
    pub fn standalone(&self, passes: &[ShadowPass], around: &Surroundings<'_>) -> Option<String> {
        let channels = self.channels();
        if channels.div_ceil(4) > MOST_TEXTURES {
            return None;
        }
        // `encode` makes a whole texel here.
        let technique = self.real_time()?.shader()?.replace("fn encode(", "fn basis(");
        let [quantise, dequantise] = self.transform_wgsl();
        let has_transform = self.single_encoding().is_some();
        let mut text = count("SAMPLES", around.samples);
        text += &array("SAMPLE_WEIGHTS", &vec![1.0 / around.samples as f64; around.samples]);
        text += &count("TAPS", around.kernel.size());
        text += &array("TAP_WEIGHTS", around.kernel.weights());
        text += &constant("LIGHTEN", 1.0 / (1.0 - around.leak_reduction));
        text += &technique;
        if has_transform {
            text +=
                &quantise.replace("fn quantise", "// The affine transform of what is stored.\nfn quantise");
            text += &dequantise.replace("fn dequantise", "// Its inverse.\nfn dequantise");
        }
        text += &texel(channels);
        text += &functions(has_transform, around.leak_reduction);
        text += &entry_points(channels);
        let roots: Vec<&str> = passes
            .iter()
            .flat_map(|pass| pass.functions().iter().chain(pass.entry_points()))
            .copied()
            .collect();
        Some(laid_out(&reachable(&unroll(&text), &roots)))
    }
}

/// Channels of each texture.
fn textures(channels: usize) -> Vec<usize> {
    (0..channels.div_ceil(4)).map(|i| (channels - 4 * i).min(4)).collect()
}

fn vector(channels: usize) -> &'static str {
    ["f32", "vec2<f32>", "vec3<f32>", "vec4<f32>"][channels - 1]
}

fn part(channels: usize) -> &'static str {
    [".x", ".xy", ".xyz", ""][channels - 1]
}

/// `Texel`, to and from arrays, and sums of them.
fn texel(channels: usize) -> String {
    const COMPONENTS: [&str; 4] = [".x", ".y", ".z", ".w"];
    let textures = textures(channels);
    let mut text = "// What a texel of the shadow map holds.\n".to_owned();
    let listed = |parts: Vec<String>| parts.join(", ");
    let (made, taken, sum);
    if let [only] = textures[..] {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "alias Texel = {};", vector(only));
        made = format!("Texel({})", listed((0..only).map(|k| format!("values[{k}]")).collect()));
        taken = if only == 1 {
            "texel".to_owned()
        } else {
            listed((0..only).map(|k| format!("texel{}", COMPONENTS[k])).collect())
        };
        sum = "sum + weight * value".to_owned();
    } else {
        let maps = || textures.iter().enumerate();
        let fields = maps().map(|(i, &n)| format!("    @location({i}) map{i}: {},\n", vector(n)));
        let _ = writeln!(text, "struct Texel {{\n{}}}", fields.collect::<String>());
        let of = |(i, &n): (usize, &usize)| {
            let values = listed((0..n).map(|k| format!("values[{}]", 4 * i + k)).collect());
            if n == 1 { values } else { format!("{}({values})", vector(n)) }
        };
        made = format!("Texel({})", listed(maps().map(of).collect()));
        let of = |k: usize| {
            let component = if textures[k / 4] == 1 { "" } else { COMPONENTS[k % 4] };
            format!("texel.map{}{component}", k / 4)
        };
        taken = listed((0..channels).map(of).collect());
        let added = maps().map(|(i, _)| format!("sum.map{i} + weight * value.map{i}"));
        sum = format!("Texel({})", listed(added.collect()));
    }
    let _ = write!(
        text,
        "
fn texel_of(values: array<f32, CHANNELS>) -> Texel {{
    return {made};
}}

fn values_of(texel: Texel) -> array<f32, CHANNELS> {{
    return array<f32, CHANNELS>({taken});
}}

fn added(sum: Texel, weight: f32, value: Texel) -> Texel {{
    return {sum};
}}
"
    );
    text
}

fn functions(has_transform: bool, leak_reduction: f64) -> String {
    let [to, from] = if has_transform {
        ["quantise(basis(depth))", "dequantise(values_of(texel))"]
    } else {
        ["basis(depth)", "values_of(texel)"]
    };
    let shadow = if leak_reduction == 0.0 {
        "shade(decode(texel), z_f)"
    } else {
        // A little more shadow everywhere hides light that leaks through occluders.
        "smaller(LIGHTEN * shade(decode(texel), z_f), 1.0)"
    };
    format!(
        "
// What is stored for a depth from 0 at the light to 1 at the far plane.
fn encode(depth: f32) -> Texel {{
    return texel_of({to});
}}

// What is stored for a pixel with several depth samples: means of texels are texels.
fn resolve(depths: array<f32, SAMPLES>) -> Texel {{
    var samples = depths;
    var weights = SAMPLE_WEIGHTS;
    var sum = Texel();
    for (var i = 0u; i < SAMPLES; i++) {{
        sum = added(sum, weights[i], encode(samples[i]));
    }}
    return sum;
}}

// One pass of the separable filter; taps in the order of their places.
fn filter_taps(taps: array<Texel, TAPS>) -> Texel {{
    var texels = taps;
    var weights = TAP_WEIGHTS;
    var sum = Texel();
    for (var i = 0u; i < TAPS; i++) {{
        sum = added(sum, weights[i], texels[i]);
    }}
    return sum;
}}

// The filtered functions of depth from a filtered texel.
fn decode(texel: Texel) -> array<f32, CHANNELS> {{
    return {from};
}}

// The shadow of a fragment at depth z_f, its bias already subtracted: 0 is lit, 1 in shadow.
fn shadow(texel: Texel, z_f: f32) -> f32 {{
    return {shadow};
}}
"
    )
}

/// Fragment shaders: maps at bindings from 0 on, depths at 20, samples of depth at 21, the sampler at 22.
fn entry_points(channels: usize) -> String {
    let textures = textures(channels);
    let mut text = String::new();
    for i in 0..textures.len() {
        let _ = writeln!(text, "@group(0) @binding({i}) var map{i}: texture_2d<f32>;");
    }
    let result = if textures.len() == 1 { "@location(0) Texel" } else { "Texel" };
    let each = |of: &dyn Fn(usize) -> String| {
        let all: Vec<String> = textures.iter().enumerate().map(|(i, &n)| of(i) + part(n)).collect();
        if all.len() == 1 { all.concat() } else { format!("Texel({})", all.join(", ")) }
    };
    let loaded = each(&|i| format!("textureLoad(map{i}, clamp(place, vec2<i32>(0), last), 0)"));
    let sampled = each(&|i| format!("textureSample(map{i}, linear_sampler, receiver.xy)"));
    let _ = write!(
        text,
        "@group(0) @binding(20) var depth_map: texture_2d<f32>;
@group(0) @binding(21) var depth_samples: texture_multisampled_2d<f32>;
@group(0) @binding(22) var linear_sampler: sampler;

// From a depth map to the shadow map.
@fragment
fn encode_pixel(@builtin(position) at: vec4<f32>) -> {result} {{
    return encode(textureLoad(depth_map, vec2<i32>(at.xy), 0).x);
}}

// From a multisampled depth map to the shadow map.
@fragment
fn resolve_pixel(@builtin(position) at: vec4<f32>) -> {result} {{
    var depths: array<f32, SAMPLES>;
    for (var i = 0u; i < SAMPLES; i++) {{
        depths[i] = textureLoad(depth_samples, vec2<i32>(at.xy), i).x;
    }}
    return resolve(depths);
}}

// Borders are clamped to the edge.
fn fetch(place: vec2<i32>) -> Texel {{
    let last = vec2<i32>(textureDimensions(map0)) - 1;
    return {loaded};
}}

fn filtered_along(axis: vec2<i32>, place: vec2<i32>) -> Texel {{
    var taps: array<Texel, TAPS>;
    for (var i = 0u; i < TAPS; i++) {{
        taps[i] = fetch(place + axis * (i32(i) - i32(TAPS / 2u)));
    }}
    return filter_taps(taps);
}}

// The first pass of the filter.
@fragment
fn filter_row(@builtin(position) at: vec4<f32>) -> {result} {{
    return filtered_along(vec2<i32>(1, 0), vec2<i32>(at.xy));
}}

// The second one, on the result of the first.
@fragment
fn filter_column(@builtin(position) at: vec4<f32>) -> {result} {{
    return filtered_along(vec2<i32>(0, 1), vec2<i32>(at.xy));
}}

// The shadow of a receiver: its place on the map from 0 to 1, and its depth.
@fragment
fn shade_pixel(@location(0) receiver: vec3<f32>) -> @location(0) f32 {{
    return shadow({sampled}, receiver.z);
}}
"
    );
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TechniqueSpec;
    use shaders::Module;

    #[test]
    fn every_pass_stands_alone() {
        let kernel = Kernel::gaussian(9, 2.4).unwrap();
        let around = Surroundings { kernel: &kernel, samples: 4, leak_reduction: 0.1 };
        for bound in ["vsm", "hamburger2", "hamburger4", "hamburger6", "hausdorff4", "trigonometric4"] {
            let technique = TechniqueSpec::named(bound).unwrap().build().unwrap();
            for passes in ShadowPass::ALL.iter().map(std::slice::from_ref).chain([&ShadowPass::ALL[..]]) {
                let text = technique.standalone(passes, &around).unwrap();
                let module = Module::new(&text).unwrap_or_else(|error| panic!("{bound}: {error}\n{text}"));
                for entry in passes.iter().flat_map(|pass| pass.entry_points()) {
                    module.entry_point(entry).unwrap();
                }
                let shades = passes.contains(&ShadowPass::Shade);
                assert_eq!(text.contains("fn shade("), shades, "{text}");
                let functions: Vec<&str> = passes.iter().flat_map(|pass| pass.functions()).copied().collect();
                Module::new(&reachable(&text, &functions)).unwrap().rust().unwrap();
            }
        }
        let eight = TechniqueSpec::named("hamburger8").unwrap().build().unwrap();
        assert_eq!(eight.standalone(&ShadowPass::ALL, &around), None);
    }
}
