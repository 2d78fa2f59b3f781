// Percentage-closer filtering of a depth texture: WEIGHTS of SIZE taps along each axis, borders clamped to the edge. Each
// tap is compared with the receiver's plane there, which differs from z_f by at most PLANE_LIMIT.

fn percentage_closer(depths: texture_2d<f32>, at: vec2<f32>, z_f: f32, gradient: vec2<f32>) -> f32 {
    let texel = vec2<i32>(floor(at));
    var weights = WEIGHTS;
    let last = vec2<i32>(textureDimensions(depths)) - 1;
    let radius = i32(SIZE / 2u);
    var total = 0.0;
    for (var j = 0u; j < SIZE; j++) {
        var line = 0.0;
        for (var i = 0u; i < SIZE; i++) {
            let tap = texel + vec2<i32>(vec2<u32>(i, j)) - radius;
            let across = dot(gradient, vec2<f32>(tap) + 0.5 - at);
            // A plane seen edge-on has no gradient; NaN counts as the limit.
            let compared = z_f + smaller(larger(across, -PLANE_LIMIT), PLANE_LIMIT);
            let depth = textureLoad(depths, clamp(tap, vec2<i32>(0), last), 0).x;
            line = line + select(0.0, weights[i], depth < compared);
        }
        total = total + weights[j] * line;
    }
    return min(total, 1.0);
}
