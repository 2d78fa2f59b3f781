// Exponential variance shadow maps; POSITIVE and NEGATIVE are the exponents per half depth range, and without a
// negative one CHANNELS is 2.

fn encode(depth: f32) -> array<f32, CHANNELS> {
    let z = unit(depth);
    let s = z + z - 1.0;
    var stored: array<f32, CHANNELS>;
    let ascending = exponential(POSITIVE * s);
    stored[0] = ascending;
    stored[1] = ascending * ascending;
    if CHANNELS == 4u {
        let descending = -exponential(-NEGATIVE * s);
        stored[CHANNELS - 2u] = descending;
        stored[CHANNELS - 1u] = descending * descending;
    }
    return stored;
}

// `cantelli` with everything divided by the mean: squares of small warped depths are subnormal, and may count as 0.
fn relative_cantelli(mean: f32, second: f32, z_f: f32) -> f32 {
    let offset = z_f - mean;
    if mean == 0.0 {
        return cantelli(mean, second, z_f);
    }
    if offset <= 0.0 {
        return 0.0;
    }
    let inverse = 1.0 / mean;
    let distance = offset * inverse;
    let relative = second * inverse * inverse;
    let variance = abs(relative + VARIANCE_ROUNDING * abs(relative) - 1.0);
    // In this form an infinite square of the distance gives 1.
    return clamp_unit(1.0 / (1.0 + variance / (distance * distance)));
}

fn shade(filtered: array<f32, CHANNELS>, z_f: f32) -> f32 {
    let z = unit(z_f);
    let s = z + z - 1.0;
    let first = relative_cantelli(filtered[0], filtered[1], exponential(POSITIVE * s));
    if CHANNELS == 2u {
        return first;
    }
    return larger(first, relative_cantelli(filtered[CHANNELS - 2u], filtered[CHANNELS - 1u], -exponential(-NEGATIVE * s)));
}
