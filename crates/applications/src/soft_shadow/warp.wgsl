// (e^(c z) - 1) / (e^c - 1) with c = WARP, or z where that is 0.

fn warped(z: f32) -> f32 {
    if WARP > 0.0 {
        return (exponential(WARP * z) - 1.0) / WARP_SPAN;
    }
    return z;
}

fn unwarped(value: f32) -> f32 {
    if WARP > 0.0 {
        return log(clamp_unit(value) * WARP_SPAN + 1.0) / WARP;
    }
    return value;
}
