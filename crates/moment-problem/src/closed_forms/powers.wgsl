// Powers of 2 z - 1 (SIGNED) or of z.

fn variable(z: f32) -> f32 {
    return select(z, z + z - 1.0, SIGNED);
}

fn encode(depth: f32) -> array<f32, CHANNELS> {
    let base = variable(unit(depth));
    var stored: array<f32, CHANNELS>;
    var power = 1.0;
    for (var k = 0u; k < CHANNELS; k++) {
        power = power * base;
        stored[k] = power;
    }
    return stored;
}

// A pivot of the Hankel matrix up to this counts as zero.
fn pivot_floor(moment: f32) -> f32 {
    return 4.0 * EPSILON * abs(moment) + TINY;
}

fn positive_pivot(pivot: f32, moment: f32) -> f32 {
    return larger(abs(pivot), pivot_floor(moment));
}
