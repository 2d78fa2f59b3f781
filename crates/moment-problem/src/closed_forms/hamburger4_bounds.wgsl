fn bounds(b: array<f32, CHANNELS>, z: f32) -> vec2<f32> {
    let points = solve4(b, variable(z));
    if points.regular {
        return bounds_of(points);
    }
    return points.degenerate;
}
