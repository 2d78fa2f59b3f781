// Percentage-closer filtering of a depth texture: WEIGHTS of SIZE taps along each axis, borders clamped to the edge.

fn percentage_closer(depths: texture_2d<f32>, texel: vec2<i32>, z_f: f32) -> f32 {
    var weights = WEIGHTS;
    let last = vec2<i32>(textureDimensions(depths)) - 1;
    let radius = i32(SIZE / 2u);
    var total = 0.0;
    for (var j = 0u; j < SIZE; j++) {
        var line = 0.0;
        for (var i = 0u; i < SIZE; i++) {
            let place = clamp(texel + vec2<i32>(vec2<u32>(i, j)) - radius, vec2<i32>(0), last);
            line = line + select(0.0, weights[i], textureLoad(depths, place, 0).x < z_f);
        }
        total = total + weights[j] * line;
    }
    return min(total, 1.0);
}
