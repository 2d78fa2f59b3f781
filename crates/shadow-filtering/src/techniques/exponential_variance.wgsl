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

fn shade(filtered: array<f32, CHANNELS>, z_f: f32) -> f32 {
    let z = unit(z_f);
    let s = z + z - 1.0;
    let first = cantelli(filtered[0], filtered[1], exponential(POSITIVE * s));
    if CHANNELS == 2u {
        return first;
    }
    return larger(first, cantelli(filtered[CHANNELS - 2u], filtered[CHANNELS - 1u], -exponential(-NEGATIVE * s)));
}
