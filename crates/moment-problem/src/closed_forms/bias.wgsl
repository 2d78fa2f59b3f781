// Bias first, then `bounds`.

fn biased_bounds(filtered: array<f32, CHANNELS>, z: f32) -> vec2<f32> {
    var centre = CENTRE;
    var biased = filtered;
    for (var k = 0u; k < CHANNELS; k++) {
        biased[k] = KEEP * biased[k] + ALPHA * centre[k];
    }
    return bounds(biased, z);
}
