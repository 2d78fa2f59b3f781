// Twin of `Pyramid` for even sides: a texel of the next level is the mean of four.

fn halved(texel: vec2<i32>) -> array<f32, CHANNELS> {
    let first = 2 * texel;
    let last = map_size() - 1;
    var sum: array<f32, CHANNELS>;
    for (var i = 0; i < 4; i++) {
        var value = fetch(min(first + vec2<i32>(i & 1, i >> 1u), last));
        for (var k = 0u; k < CHANNELS; k++) {
            sum[k] = sum[k] + 0.25 * value[k];
        }
    }
    return sum;
}
