// Four power moments on [0, 1], biased: rounding the biased moments would lose what a small bias is for.

// A support point outside [0, 1] by so many roundings is taken for an end point.
const NEARLY: f32 = 1.0 - 16.0 * EPSILON;

fn point_inside(w: f32, z_f: f32) -> bool {
    return select(w * (1.0 - z_f) >= NEARLY, w * z_f <= -NEARLY, w < 0.0);
}

// The upper twelve bits of the mantissa, and the rest.
fn split(a: f32) -> vec2<f32> {
    let t = 4097.0 * a;
    let high = t - (t - a);
    return vec2<f32>(high, a - high);
}

// a b rounded, and what rounding has taken from it (Dekker).
fn exact_product(a: f32, b: f32) -> vec2<f32> {
    let product = a * b;
    let x = split(a);
    let y = split(b);
    return vec2<f32>(product, ((x.x * y.x - product) + x.x * y.y + x.y * y.x) + x.y * y.y);
}

// a b - c d with next to nothing lost where the products cancel.
fn product_difference(a: f32, b: f32, c: f32, d: f32) -> f32 {
    let first = exact_product(a, b);
    let second = exact_product(c, d);
    return (first.x - second.x) + (first.y - second.y);
}

fn mixed(of_b: f32, of_c: f32) -> f32 {
    return KEEP * of_b + ALPHA * of_c;
}

// Variance of z, covariance of z and z^2, variance of z^2.
fn covariances(m: array<f32, 4>) -> vec3<f32> {
    return vec3<f32>(
        product_difference(1.0, m[1], m[0], m[0]),
        product_difference(1.0, m[2], m[0], m[1]),
        product_difference(1.0, m[3], m[1], m[1]),
    );
}

fn biased_bounds(b: array<f32, CHANNELS>, z_f: f32) -> vec2<f32> {
    let c = CENTRE;
    let cross = ALPHA * KEEP;
    let d = vec2<f32>(c[0] - b[0], c[1] - b[1]);
    let of_b = covariances(b);
    let of_c = covariances(c);
    let d1 = larger(abs(mixed(of_b.x, of_c.x) + cross * d.x * d.x), TINY);
    let e = mixed(of_b.y, of_c.y) + cross * d.x * d.y;
    let square = mixed(of_b.z, of_c.z) + cross * d.y * d.y;
    let l = e / d1;
    let d2 = positive_pivot(product_difference(square, d1, e, e) / d1, square);
    let p1 = (z_f - b[0]) - ALPHA * d.x;
    let p2 = (product_difference(z_f, z_f, 1.0, b[1]) - ALPHA * d.y) - l * p1;
    let points = three_points(vec3<f32>(p1, p2, z_f + z_f - l), vec2<f32>(d1, d2));
    if !points.regular {
        return points.degenerate;
    }
    if z_f <= 0.0 || z_f >= 1.0 || (point_inside(points.w.x, z_f) && point_inside(points.w.y, z_f)) {
        return bounds_of(points);
    }
    // Both end points, z_f and one point between, from the moments of z (1 - z) dZ.
    let m = vec3<f32>(b[0] - b[1], b[1] - b[2], b[2] - b[3]);
    let n = vec3<f32>(c[0] - c[1], c[1] - c[2], c[2] - c[3]);
    let mass = mixed(m.x, n.x);
    let b1 = mixed(b[0], c[0]);
    if mass <= TINY {
        return ordered(1.0 - b1, 1.0 - b1);
    }
    let mean = mixed(m.y, n.y) / mass;
    let x = mixed(product_difference(z_f, m.x, 1.0, m.y), product_difference(z_f, n.x, 1.0, n.y)) / mass;
    let spread_b = KEEP * KEEP * product_difference(m.x, m.z, m.y, m.y);
    let spread_c = ALPHA * ALPHA * product_difference(n.x, n.z, n.y, n.y);
    let spread_both = product_difference(m.x, n.z, m.y, n.y) + product_difference(n.x, m.z, n.y, m.y);
    let variance = abs((spread_b + spread_c + cross * spread_both) / (mass * mass));
    let sum = variance + x * x;
    let near = variance / sum;
    let far = x * x / sum;
    let free = select(smaller(larger(mean - variance / x, 0.0), 1.0), 1.0, x == 0.0);
    let at_z_f = mass * near / (z_f * (1.0 - z_f));
    let spread = free * (1.0 - free);
    let at_free = select(0.0, mass * far / spread, spread > TINY);
    if free < z_f {
        let at_one = b1 - at_z_f * z_f - at_free * free;
        return ordered(1.0 - at_z_f - at_one, 1.0 - at_one);
    }
    let at_zero = (1.0 - b1) - at_z_f * (1.0 - z_f) - at_free * (1.0 - free);
    return ordered(at_zero, at_zero + at_z_f);
}
