// Moment shadow maps: bias, bound and blend around `bounds`, which each kind has its own of. ALPHA is the moment bias,
// KEEP = 1 - ALPHA, CENTRE what the moments are biased towards, BETA the blend of both bounds.

fn shade(filtered: array<f32, CHANNELS>, z_f: f32) -> f32 {
    var centre = CENTRE;
    var biased = filtered;
    for (var k = 0u; k < CHANNELS; k++) {
        biased[k] = KEEP * biased[k] + ALPHA * centre[k];
    }
    let pair = bounds(biased, unit(z_f));
    return pair.x + BETA * (pair.y - pair.x);
}
