// Real roots of monic polynomials all of whose roots are real, ascending, by square roots only.

fn quadratic_roots(b: f32, c: f32) -> vec2<f32> {
    let b_half = 0.5 * b;
    let root = sqrt(larger(b_half * b_half - c, 0.0));
    let far = select(-(root + b_half), root - b_half, b_half < 0.0);
    let near = select(c / far, far, far == 0.0);
    return select(vec2<f32>(far, near), vec2<f32>(near, far), near < far);
}

// cos(acos(target) / 3) for target in [0, 1].
fn third_angle_cosine(target_cosine: f32) -> f32 {
    var x = 0.8660254 + 0.1339746 * target_cosine;
    for (var step = 0u; step < 2u; step++) {
        let square = x * x;
        x = x - ((4.0 * square - 3.0) * x - target_cosine) / (12.0 * square - 3.0);
    }
    return x;
}

fn sorted(roots: vec3<f32>) -> vec3<f32> {
    let low = smaller(roots.x, roots.y);
    let high = larger(roots.y, roots.x);
    let middle = larger(low, smaller(high, roots.z));
    return vec3<f32>(smaller(low, roots.z), middle, larger(high, roots.z));
}

// Up to two Newton steps on x^3 + a x^2 + b x + c, each taken only if the residual decreases.
fn polish_cubic(a: f32, b: f32, c: f32, start: f32) -> f32 {
    var x = start;
    var value = ((x + a) * x + b) * x + c;
    for (var step = 0u; step < 2u; step++) {
        // As the Horner scheme forms it, coefficient by coefficient.
        let slope = ((x + (x + a)) * x) + ((x + a) * x + b);
        let next = x - value / slope;
        let next_value = ((next + a) * next + b) * next + c;
        if !(abs(next_value) < abs(value)) {
            break;
        }
        x = next;
        value = next_value;
    }
    return x;
}

fn cubic_roots(a: f32, b: f32, c: f32) -> vec3<f32> {
    let shift = -(a / 3.0);
    let p = b + a * shift;
    let q = shift * (shift * (a + shift) + b) + c;
    let r = sqrt(larger(-(p / 3.0), 0.0));
    let scale = 2.0 * r * r * r;
    if scale <= TINY {
        return vec3<f32>(shift);
    }
    let third = third_angle_cosine(smaller(abs(q) / scale, 1.0));
    let depressed = 2.0 * r * third;
    let first = polish_cubic(a, b, c, shift + select(depressed, -depressed, q > 0.0));
    // Deflate from the end that does not cancel.
    var linear: f32;
    var rest: f32;
    if abs(first * first * first) > abs(c) {
        rest = -(c / first);
        linear = (rest - b) / first;
    } else {
        linear = a + first;
        rest = b + first * linear;
    }
    return sorted(vec3<f32>(first, quadratic_roots(linear, rest)));
}
