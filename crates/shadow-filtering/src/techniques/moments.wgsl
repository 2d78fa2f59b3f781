// Moment shadow maps: bias, bound and blend around `biased_bounds`, which each kind has its own of. ALPHA is the moment bias,
// KEEP = 1 - ALPHA, CENTRE what the moments are biased towards, BETA the blend of both bounds.

fn shade(filtered: array<f32, CHANNELS>, z_f: f32) -> f32 {
    let pair = biased_bounds(filtered, unit(z_f));
    return pair.x + BETA * (pair.y - pair.x);
}
