// Where z_f, a free point and both ends are the points: the end and the free point.
fn ends_in_front(b: array<f32, CHANNELS>, z_f: f32) -> InFront {
    var found: InFront;
    let mass = b[0] - b[1];
    // Four roundings of the mean depth.
    let noise = 4.0 * EPSILON * abs(b[0]) + TINY;
    if mass <= noise {
        return with_point(found, 0u, 0.0, clamp_unit(1.0 - b[0]));
    }
    let mean = (b[1] - b[2]) / mass;
    let x = z_f - mean;
    let variance = larger(abs((b[2] - b[3]) / mass - mean * mean), noise / mass);
    let sum = variance + x * x;
    let free = select(smaller(larger(mean - variance / x, 0.0), 1.0), 1.0, x == 0.0);
    let at_z_f = mass * (variance / sum) / (z_f * (1.0 - z_f));
    let spread = free * (1.0 - free);
    let at_free = select(0.0, mass * (x * x / sum) / spread, spread > TINY);
    let at_one = b[0] - at_z_f * z_f - at_free * free;
    let at_zero = (1.0 - b[0]) - at_z_f * (1.0 - z_f) - at_free * (1.0 - free);
    let lower = clamp_unit(select(at_zero, 1.0 - at_z_f - at_one, free < z_f));
    let first = smaller(clamp_unit(at_zero), lower);
    found = with_point(found, 0u, 0.0, first);
    if free < z_f {
        found = with_point(found, 1u, free, lower - first);
    }
    return found;
}

fn in_front(b: array<f32, CHANNELS>, z: f32) -> InFront {
    let points = solve4(b, z);
    let inside = z <= 0.0 || z >= 1.0 || (point_inside(points.w.x, z) && point_inside(points.w.y, z));
    if !points.regular || inside {
        return points_in_front(points, b, z);
    }
    return ends_in_front(b, z);
}
