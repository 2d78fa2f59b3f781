// Convolution shadow maps; FREQUENCY is c_1, AMPLITUDES are 2 a_k / (pi (2 k - 1)), DELTA, LOW and SPAN = high - low
// make them a lower bound.

const CHANNELS: u32 = 2u * COEFFICIENTS;

fn encode(depth: f32) -> array<f32, CHANNELS> {
    let angle = FREQUENCY * unit(depth);
    var wave = sine_cosine(angle);
    let twice = sine_cosine(angle + angle);
    var stored: array<f32, CHANNELS>;
    for (var k = 0u; k < COEFFICIENTS; k++) {
        stored[2u * k] = wave.y;
        stored[2u * k + 1u] = wave.x;
        wave = vec2<f32>(wave.x * twice.y + wave.y * twice.x, wave.y * twice.y - wave.x * twice.x);
    }
    return stored;
}

fn shade(filtered: array<f32, CHANNELS>, z_f: f32) -> f32 {
    var stored = filtered;
    var amplitudes = AMPLITUDES;
    let angle = FREQUENCY * (unit(z_f) - DELTA);
    var wave = sine_cosine(angle);
    let twice = sine_cosine(angle + angle);
    var sum = 0.5;
    for (var k = 0u; k < COEFFICIENTS; k++) {
        sum = sum + amplitudes[k] * (wave.x * stored[2u * k] - wave.y * stored[2u * k + 1u]);
        wave = vec2<f32>(wave.x * twice.y + wave.y * twice.x, wave.y * twice.y - wave.x * twice.x);
    }
    return clamp_unit((sum - LOW) / SPAN);
}
