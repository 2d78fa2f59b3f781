// What the distribution that attains the lower bound puts in front of z_f: up to three points; those without have weight 0.

struct InFront {
    depths: array<f32, 3>,
    weights: array<f32, 3>,
}

// A weight below is rounding, and its depth may be infinite.
fn with_point(before: InFront, slot: u32, depth: f32, weight: f32) -> InFront {
    var found = before;
    let counts = weight > TINY && abs(depth) <= LARGEST;
    for (var i = 0u; i < 3u; i++) {
        found.depths[i] = select(found.depths[i], depth, counts && i == slot);
        found.weights[i] = select(found.weights[i], smaller(weight, 1.0), counts && i == slot);
    }
    return found;
}

// From mean and second moment: one point.
fn chebyshev_in_front(mean: f32, second: f32, z_f: f32) -> InFront {
    var found: InFront;
    let offset = z_f - mean;
    if offset > 0.0 {
        let variance = abs(second - mean * mean);
        let square = offset * offset;
        let sum = variance + square;
        found = with_point(found, 0u, mean - variance / offset, select(1.0, square / sum, sum > 0.0));
    }
    return found;
}
