// Twin of `resolve` over encoded samples: the mean of b over the SAMPLES samples of a texel, transformed for storage.

fn resolved(texel: vec2<i32>) -> array<f32, CHANNELS> {
    let share = 1.0 / f32(SAMPLES);
    var sum: array<f32, CHANNELS>;
    for (var s = 0; s < SAMPLES; s++) {
        var b = encode(sample_depth(texel, s));
        for (var k = 0u; k < CHANNELS; k++) {
            sum[k] = sum[k] + share * b[k];
        }
    }
    return quantise(sum);
}
