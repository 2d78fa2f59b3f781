fn in_front(b: array<f32, CHANNELS>, z: f32) -> InFront {
    return chebyshev_in_front(b[0], b[1], variable(z));
}
