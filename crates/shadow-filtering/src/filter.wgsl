// Twin of `filter`: one pass of a separable kernel, WEIGHTS of SIZE taps, borders clamped to the edge.

fn one_pass(texel: vec2<i32>, axis: vec2<i32>) -> array<f32, CHANNELS> {
    var weights = WEIGHTS;
    let last = map_size() - 1;
    let radius = i32(SIZE / 2u);
    var sum: array<f32, CHANNELS>;
    for (var i = 0u; i < SIZE; i++) {
        var value = fetch(clamp(texel + axis * (i32(i) - radius), vec2<i32>(0), last));
        for (var k = 0u; k < CHANNELS; k++) {
            sum[k] = sum[k] + weights[i] * value[k];
        }
    }
    return sum;
}

@fragment
fn along_rows(@builtin(position) at: vec4<f32>) -> Targets {
    return to_targets(one_pass(vec2<i32>(at.xy), vec2<i32>(1, 0)));
}

@fragment
fn along_columns(@builtin(position) at: vec4<f32>) -> Targets {
    return to_targets(one_pass(vec2<i32>(at.xy), vec2<i32>(0, 1)));
}
