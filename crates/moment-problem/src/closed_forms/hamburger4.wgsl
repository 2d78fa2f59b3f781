// Four power moments on the line: the three points z_f and z_f + 1 / w that attain both bounds.

struct ThreePoints {
    regular: bool,
    // Both bounds where the moments are those of at most two surfaces.
    degenerate: vec2<f32>,
    w: vec2<f32>,
    at_z_f: f32,
    s: vec2<f32>,
}

// From P_1, P_2 and the slope of P_2 at z_f, and the pivots d_1 and d_2.
fn three_points(p: vec3<f32>, d: vec2<f32>) -> ThreePoints {
    var points: ThreePoints;
    points.degenerate = vec2<f32>(0.0, 1.0);
    let q0 = d.x * d.y + p.x * p.x * d.y + p.y * p.y * d.x;
    let q1 = p.x * d.y + p.y * p.z * d.x;
    let q2 = p.y * d.x;
    if q0 > 0.0 {
        points.regular = true;
        points.w = quadratic_roots(q1 / q0, q2 / q0);
        points.at_z_f = d.x * d.y / q0;
        points.s = vec2<f32>(-p.x, d.x + p.x * p.x);
    }
    return points;
}

fn solve4(b: array<f32, 4>, z_f: f32) -> ThreePoints {
    let d1 = b[1] - b[0] * b[0];
    if d1 <= pivot_floor(b[1]) {
        var points: ThreePoints;
        points.degenerate = chebyshev(b[0], b[1], z_f);
        return points;
    }
    let e = b[2] - b[0] * b[1];
    let l = e / d1;
    let d2 = positive_pivot(b[3] - b[1] * b[1] - l * e, b[3]);
    let p1 = z_f - b[0];
    let p2 = z_f * z_f - b[1] - l * p1;
    return three_points(vec3<f32>(p1, p2, z_f + z_f - l), vec2<f32>(d1, d2));
}

fn bounds_of(points: ThreePoints) -> vec2<f32> {
    let w = points.w;
    var lower = 0.0;
    if w.x < 0.0 {
        if w.y < 0.0 {
            lower = 1.0 - points.at_z_f;
        } else {
            lower = w.x * w.x * (points.s.x - points.s.y * w.y) / (w.x - w.y);
        }
    }
    return ordered(lower, lower + points.at_z_f);
}
