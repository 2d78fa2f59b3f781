// Twin of `filter`: one pass of a separable kernel along AXIS, WEIGHTS of SIZE taps, borders clamped to the edge.

@fragment
fn filter_axis(@builtin(position) at: vec4<f32>) -> Targets {
    let texel = vec2<i32>(at.xy);
    var weights = WEIGHTS;
    let last = map_size() - 1;
    let radius = i32(SIZE / 2u);
    var sum: array<f32, CHANNELS>;
    for (var i = 0u; i < SIZE; i++) {
        var value = fetch(clamp(texel + AXIS * (i32(i) - radius), vec2<i32>(0), last));
        for (var k = 0u; k < CHANNELS; k++) {
            sum[k] = sum[k] + weights[i] * value[k];
        }
    }
    return to_targets(sum);
}
