// Twin of `Pyramid` for even sides: a texel of the next level is the mean of four.

@fragment
fn halve(@builtin(position) at: vec4<f32>) -> Targets {
    let first = 2 * vec2<i32>(at.xy);
    let last = map_size() - 1;
    var sum: array<f32, CHANNELS>;
    for (var i = 0; i < 4; i++) {
        var value = fetch(min(first + vec2<i32>(i & 1, i >> 1u), last));
        for (var k = 0u; k < CHANNELS; k++) {
            sum[k] = sum[k] + 0.25 * value[k];
        }
    }
    return to_targets(sum);
}
