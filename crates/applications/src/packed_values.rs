//! Values of texels as words of 32 bits, in WGSL.

use quantization::NumberFormat;
use shadow_filtering::Technique;

/// Words of a texel.
pub(crate) fn words(technique: &Technique) -> usize {
    technique.channels().div_ceil(values_a_word(technique.encoding().format()))
}

fn values_a_word(format: NumberFormat) -> usize {
    match format {
        NumberFormat::Unorm8 => 4,
        NumberFormat::Unorm10 => 3,
        NumberFormat::Unorm16 | NumberFormat::F16 => 2,
        NumberFormat::F32 | NumberFormat::U32Fixed { .. } => 1,
    }
}

/// `store(texel, values)` into an `array<u32>` of a name; `None` for fixed point, which belongs into tables.
pub(crate) fn store_wgsl(technique: &Technique, buffer: &str) -> Option<String> {
    let format = technique.encoding().format();
    let (channels, each, words) = (technique.channels(), values_a_word(format), words(technique));
    let value = |k: usize| if k < channels { format!("values[{k}]") } else { "0.0".to_owned() };
    let packed = |word: usize| {
        let of = |i: usize| value(each * word + i);
        Some(match format {
            NumberFormat::Unorm8 => {
                format!("pack4x8unorm(vec4<f32>({}, {}, {}, {}))", of(0), of(1), of(2), of(3))
            }
            NumberFormat::Unorm10 => format!("ten_bits({}, {}, {})", of(0), of(1), of(2)),
            NumberFormat::Unorm16 => format!("pack2x16unorm(vec2<f32>({}, {}))", of(0), of(1)),
            NumberFormat::F16 => format!("pack2x16float(vec2<f32>({}, {}))", of(0), of(1)),
            NumberFormat::F32 => format!("bitcast<u32>({})", of(0)),
            NumberFormat::U32Fixed { .. } => return None,
        })
    };
    let ten = "fn ten_bits(a: f32, b: f32, c: f32) -> u32 {
    let codes = vec3<u32>(floor(clamp(vec3<f32>(a, b, c), vec3<f32>(0.0), vec3<f32>(1.0)) * 1023.0 + 0.5));
    return codes.x | (codes.y << 10u) | (codes.z << 20u);
}
";
    let line = |word: usize| Some(format!("    {buffer}[texel * {words}u + {word}u] = {};\n", packed(word)?));
    let lines = (0..words).map(line).collect::<Option<String>>()?;
    Some(format!("{ten}fn store(texel: u32, values: array<f32, CHANNELS>) {{\n{lines}}}\n"))
}

/// `load(texel) -> values`; `None` as for [`store_wgsl`].
pub(crate) fn load_wgsl(technique: &Technique, buffer: &str) -> Option<String> {
    let format = technique.encoding().format();
    let (channels, each, words) = (technique.channels(), values_a_word(format), words(technique));
    let unpacked = |k: usize| {
        let (word, i) = (format!("w{}", k / each), k % each);
        let part = ["x", "y", "z", "w"][i];
        Some(match format {
            NumberFormat::Unorm8 => format!("unpack4x8unorm({word}).{part}"),
            NumberFormat::Unorm10 => format!("f32(({word} >> {}u) & 1023u) / 1023.0", 10 * i),
            NumberFormat::Unorm16 => format!("unpack2x16unorm({word}).{part}"),
            NumberFormat::F16 => format!("unpack2x16float({word}).{part}"),
            NumberFormat::F32 => format!("bitcast<f32>({word})"),
            NumberFormat::U32Fixed { .. } => return None,
        })
    };
    let loads: String =
        (0..words).map(|word| format!("    let w{word} = {buffer}[texel * {words}u + {word}u];\n")).collect();
    let values = (0..channels).map(unpacked).collect::<Option<Vec<_>>>()?.join(", ");
    Some(format!(
        "fn load(texel: u32) -> array<f32, CHANNELS> {{\n{loads}    return array<f32, CHANNELS>({values});\n}}\n"
    ))
}
