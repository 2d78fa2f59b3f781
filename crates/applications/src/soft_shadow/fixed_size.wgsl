fn soft_shadow(penumbra: Penumbra, at: vec2<f32>, z: f32, bias: f32) -> f32 {
    return filtered_hard_shadow(vec2<f32>(FIXED_WIDTHS[0], FIXED_WIDTHS[1]), at, z, bias);
}
