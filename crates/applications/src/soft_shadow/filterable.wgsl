// Two queries to a field of moments.

fn blockers_of(moments: array<f32, CHANNELS>, z: f32) -> Blockers {
    var biased = decoded(moments);
    var centre = CENTRE;
    for (var k = 0u; k < CHANNELS; k++) {
        biased[k] = KEEP * biased[k] + ALPHA * centre[k];
    }
    let found = in_front(biased, warped(z));
    var blockers: Blockers;
    for (var i = 0u; i < 3u; i++) { if found.weights[i] > 0.0 {
        blockers.mass = blockers.mass + found.weights[i];
        blockers.depth_sum = blockers.depth_sum + found.weights[i] * unwarped(depth_of(found.depths[i]));
    } }
    return blockers;
}

fn soft_shadow(penumbra: Penumbra, at: vec2<f32>, z: f32, bias: f32) -> f32 {
    let searched = search_widths(penumbra, z);
    let moments = means(at - 0.5 * searched, at + 0.5 * searched, SEARCH_FIT);
    let blockers = blockers_of(moments, z - SEARCH_BIAS_SHARE * bias);
    if blockers.mass > UMBRA {
        return 1.0;
    }
    let widths = filter_widths(penumbra, z, average_blocker(blockers, z));
    return filtered_hard_shadow(widths, at, z, bias);
}
