fn bounds(b: array<f32, CHANNELS>, z: f32) -> vec2<f32> {
    return chebyshev(b[0], b[1], variable(z));
}
