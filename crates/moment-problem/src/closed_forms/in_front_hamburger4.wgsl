fn in_front(b: array<f32, CHANNELS>, z: f32) -> InFront {
    let z_f = variable(z);
    return points_in_front(solve4(b, z_f), b, z_f);
}
