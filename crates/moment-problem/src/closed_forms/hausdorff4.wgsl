// Four power moments on [0, 1].

// A support point outside [0, 1] by so many roundings is taken for an end point.
const NEARLY: f32 = 1.0 - 16.0 * EPSILON;

fn point_inside(w: f32, z_f: f32) -> bool {
    return select(w * (1.0 - z_f) >= NEARLY, w * z_f <= -NEARLY, w < 0.0);
}

fn bounds(b: array<f32, CHANNELS>, z_f: f32) -> vec2<f32> {
    let points = solve4(b, z_f);
    if !points.regular {
        return points.degenerate;
    }
    if z_f <= 0.0 || z_f >= 1.0 || (point_inside(points.w.x, z_f) && point_inside(points.w.y, z_f)) {
        return bounds_of(points);
    }
    // Both end points, z_f and one point between, from the moments of z (1 - z) dZ.
    let mass = b[0] - b[1];
    let noise = 4.0 * EPSILON * abs(b[0]) + TINY;
    if mass <= noise {
        return ordered(1.0 - b[0], 1.0 - b[0]);
    }
    let mean = (b[1] - b[2]) / mass;
    let x = z_f - mean;
    let second = (b[2] - b[3]) / mass;
    let variance = larger(abs(second - mean * mean), noise / mass);
    let sum = variance + x * x;
    let near = variance / sum;
    let far = x * x / sum;
    let free = select(smaller(larger(mean - variance / x, 0.0), 1.0), 1.0, x == 0.0);
    let at_z_f = mass * near / (z_f * (1.0 - z_f));
    let spread = free * (1.0 - free);
    let at_free = select(0.0, mass * far / spread, spread > TINY);
    if free < z_f {
        let at_one = b[0] - at_z_f * z_f - at_free * free;
        return ordered(1.0 - at_z_f - at_one, 1.0 - at_one);
    }
    let at_zero = (1.0 - b[0]) - at_z_f * (1.0 - z_f) - at_free * (1.0 - free);
    return ordered(at_zero, at_zero + at_z_f);
}
