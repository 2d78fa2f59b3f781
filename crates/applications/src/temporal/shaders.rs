//! WGSL twins of a frame as two compute passes: [`update_shader`], then [`smooth_shader`]. Bindings stand in the modules, all in
//! group 0; the uniform is [`screen_uniform`], and buffers hold [`buffer_words`] words of 32 bits a pixel.
//!
//! Where a surface was in the last frame comes with its pixel, as a vertex shader hands it over, and so does what the frame's
//! shadow map says of it.

use moment_problem::wgsl::ELEMENTARY;
use quantization::NumberFormat;
use shaders::{array, constant, count, flag, unroll};

use super::frame::{LEAST_BLOCKER, LEAST_SHARE};
use super::{FilterSource, FramePixel, MovingCasters, Screen, Start, TemporalMethod};
use crate::samples::PoissonTaps;

const HISTORY: &str = include_str!("history.wgsl");
const UPDATE: &str = include_str!("update.wgsl");
const SMOOTH: &str = include_str!("smooth.wgsl");

/// Stands for a count without end, as shaders have no infinite constant.
const UNLIMITED: f64 = 1e30;

/// A history that is stored in half floats.
const HALF: &str = "
fn packed(history: History) -> array<u32, WORDS> {
    let first = pack2x16float(vec2<f32>(history.tests, history.shadowed));
    return array<u32, WORDS>(first, pack2x16float(vec2<f32>(history.depth, history.blocker)));
}

fn unpacked(words: array<u32, WORDS>) -> History {
    let first = unpack2x16float(words[0]);
    let second = unpack2x16float(words[1]);
    return History(first.x, first.y, second.x, second.y);
}
";

/// A history that is stored in single floats.
const SINGLE: &str = "
fn packed(history: History) -> array<u32, WORDS> {
    return bitcast_all(vec4<f32>(history.tests, history.shadowed, history.depth, history.blocker));
}

fn bitcast_all(values: vec4<f32>) -> array<u32, WORDS> {
    let words = bitcast<vec4<u32>>(values);
    return array<u32, WORDS>(words.x, words.y, words.z, words.w);
}

fn unpacked(words: array<u32, WORDS>) -> History {
    return History(bitcast<f32>(words[0]), bitcast<f32>(words[1]), bitcast<f32>(words[2]), bitcast<f32>(words[3]));
}
";

/// A pixel as shaders read it: distances and flags, then its place in the last frame and a number that nobody reads. All 0
/// without a surface.
pub fn pixel_for_shader(method: &TemporalMethod, pixel: Option<&FramePixel<f32>>) -> [f32; 8] {
    let Some(pixel) = pixel else { return [0.0; 8] };
    let flags = [(pixel.in_shadow, 1.0), (pixel.hidden, 2.0), (pixel.moving, 4.0), (true, 8.0)];
    let flags = flags.iter().filter(|(is_set, _)| *is_set).map(|(_, value)| value).sum();
    let [x, y, distance] = method.last_place(pixel);
    [pixel.depth, pixel.receiver, pixel.map_distance, flags, x, y, distance, 0.0]
}

/// The start of a pixel as shaders read it.
pub fn start_for_shader(start: &Start<f32>) -> [f32; 4] {
    [start.fraction, start.blocker.unwrap_or(0.0), if start.moving { 1.0 } else { 0.0 }, 0.0]
}

/// What shaders read as `Screen`, for a buffer of a size.
pub fn screen_uniform(screen: &Screen, [width, height]: [u32; 2]) -> [u32; 4] {
    let [light, pixels] = [screen.light_size, screen.pixels_per_unit].map(|value| (value as f32).to_bits());
    [light, pixels, width, height]
}

/// Words of 32 bits of a pixel of the buffer; `None` for formats that cannot count.
pub fn buffer_words(method: &TemporalMethod) -> Option<usize> {
    match method.format {
        NumberFormat::F16 => Some(2),
        NumberFormat::F32 => Some(4),
        NumberFormat::Unorm8
        | NumberFormat::Unorm10
        | NumberFormat::Unorm16
        | NumberFormat::U32Fixed { .. } => None,
    }
}

/// Brings the buffer to the next frame. Entry point `update`, 64 pixels a group. `None` as for [`buffer_words`].
pub fn update_shader(method: &TemporalMethod) -> Option<String> {
    let storing = "
fn store(pixel: u32, history: History) {
    let words = packed(history);
    for (var k = 0u; k < WORDS; k++) {
        after[pixel * WORDS + k] = words[k];
    }
}
";
    joined(method, "", &[UPDATE, storing])
}

/// Shadows that are shown. Entry point `smooth_shadows`, 64 pixels a group. `None` as for [`buffer_words`].
pub fn smooth_shader(method: &TemporalMethod, taps: &PoissonTaps) -> Option<String> {
    let points: Vec<f64> = taps.points().iter().flatten().copied().collect();
    let constants = count("TAP_COUNT", taps.points().len())
        + &array("TAPS", if points.is_empty() { &[0.0; 2] } else { &points });
    joined(method, &constants, &[SMOOTH])
}

fn joined(method: &TemporalMethod, constants: &str, parts: &[&str]) -> Option<String> {
    let words = buffer_words(method)?;
    let packing = if words == 2 { HALF } else { SINGLE };
    let loading: String = ["before", "after"].iter().map(|buffer| loading(buffer)).collect();
    let settings = of_method(method) + &count("WORDS", words) + constants;
    Some(unroll(&format!("{settings}\n{ELEMENTARY}{HISTORY}{packing}{}{loading}", parts.join("\n"))))
}

fn loading(buffer: &str) -> String {
    format!(
        "
fn load_{buffer}(pixel: u32) -> History {{
    var words: array<u32, WORDS>;
    for (var k = 0u; k < WORDS; k++) {{
        words[k] = {buffer}[pixel * WORDS + k];
    }}
    return unpacked(words);
}}
"
    )
}

fn of_method(method: &TemporalMethod) -> String {
    // Only a start's depths count in the average, and only as long as it averages everything.
    let is_averaged = method.start_tests > 0.0 && !method.blockers_only;
    let numbers = [
        ("START_TESTS", method.start_tests),
        ("START_BLOCKERS", if is_averaged { method.start_blockers } else { 0.0 }),
        ("THRESHOLD", method.threshold),
        ("TOLERANCE", method.tolerance),
        ("DEPTH_RANGE", method.depth_range),
        ("MOST_TESTS", method.most_tests.min(UNLIMITED)),
        ("LEAST_SHARE", LEAST_SHARE),
        ("LEAST_BLOCKER", LEAST_BLOCKER),
    ];
    let flags = [
        ("CAUTIOUS", method.cautious),
        ("BLOCKERS_ONLY", method.blockers_only),
        ("INTERPOLATED", method.interpolated),
        ("EXACT", method.exact),
        ("TEXEL_MOVES", method.moving == MovingCasters::Texel),
        ("SEARCH_MOVES", method.moving == MovingCasters::Search),
        ("FILTERED", method.filter != FilterSource::Off),
        ("PREVIOUS", method.filter == FilterSource::Previous),
    ];
    let numbers: String = numbers.iter().map(|(name, value)| constant(name, *value)).collect();
    numbers + &flags.iter().map(|(name, value)| flag(name, *value)).collect::<String>()
}
