// Powers of the variable from what is stored of them: OFFSET + MATRIX powers, with INVERSE. SIGNED: the variable is 2 z - 1.

fn decoded(means: array<f32, CHANNELS>) -> array<f32, CHANNELS> {
    var stored = means;
    if !SIGNED {
        return stored;
    }
    var inverse = INVERSE;
    var offset = OFFSET;
    var moments: array<f32, CHANNELS>;
    for (var i = 0u; i < CHANNELS; i++) {
        for (var j = 0u; j < CHANNELS; j++) {
            moments[i] = moments[i] + inverse[i * CHANNELS + j] * (stored[j] - offset[j]);
        }
    }
    return moments;
}

fn depth_of(variable: f32) -> f32 {
    return select(variable, 0.5 * (variable + 1.0), SIGNED);
}
