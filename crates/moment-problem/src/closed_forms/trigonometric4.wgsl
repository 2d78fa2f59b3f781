// Sine and cosine of 2 pi z and 4 pi z on [0, 1]: the least mass of five kinds of distribution with these moments.

fn encode(depth: f32) -> array<f32, CHANNELS> {
    let z = unit(depth);
    let wave = sine_cosine(PI * (z + z));
    let product = wave.x * wave.y;
    return array<f32, CHANNELS>(wave.x, wave.y, product + product, (wave.y - wave.x) * (wave.y + wave.x));
}

const PI: f32 = 3.14159265;
// Returned where there is no such distribution: more than any mass.
const NONE: f32 = 2.0;
const RANK_NOISE: f32 = 8.0 * EPSILON;
// The root of a rounding error: see the Rust twin.
const LEAST_WEIGHT: f32 = -3.4526698e-4;

// Mass in front of z_f (`through` is z_f) or of the seam's own order, for a canonical representation.
struct Frame {
    // A point at cotangent x is in front if slope x + offset > noise (1 + |x|).
    slope: f32,
    offset: f32,
}

fn in_front(frame: Frame, x: f32) -> bool {
    return x * frame.slope + frame.offset > RANK_NOISE * (1.0 + abs(x));
}

fn forms(b: array<f32, 4>) -> array<f32, 5> {
    return array<f32, 5>(
        (3.0 - 4.0 * b[1] + b[3]) * 0.125,
        (b[0] + b[0] - b[2]) * 0.125,
        (1.0 - b[3]) * 0.125,
        (b[0] + b[0] + b[2]) * 0.125,
        (3.0 + 4.0 * b[1] + b[3]) * 0.125,
    );
}

fn three_points(h: array<f32, 5>, frame: Frame) -> f32 {
    let alpha = h[2] * h[0] - h[1] * h[1];
    let beta = h[1] * h[2] - h[3] * h[0];
    let gamma = h[3] * h[1] - h[2] * h[2];
    let noise = RANK_NOISE * abs(h[0] + abs(h[1]) + h[2] + abs(h[3]));
    let mixed = h[1] + h[3];
    let square = h[0] + h[2];
    if abs(alpha) <= noise && abs(beta) <= noise && abs(gamma) <= noise {
        if square <= RANK_NOISE {
            return 0.0;
        }
        let x = mixed / square;
        return select(0.0, smaller(square * (1.0 + x * x), 1.0), in_front(frame, x));
    }
    let limit = 1.0 / EPSILON;
    var x: vec2<f32>;
    if abs(alpha) * limit > abs(gamma) {
        x = quadratic_roots(beta / alpha, gamma / alpha);
    } else {
        let y = quadratic_roots(beta / gamma, alpha / gamma);
        x = vec2<f32>(select(1.0 / y.x, limit, y.x == 0.0), select(1.0 / y.y, limit, y.y == 0.0));
    }
    if !(abs(x.x) <= LARGEST && abs(x.y) <= LARGEST) {
        return NONE;
    }
    let step = x.x - x.y;
    let weights = vec2<f32>(
        (1.0 + x.x * x.x) * (mixed - x.y * square) / step,
        (1.0 + x.y * x.y) * (mixed - x.x * square) / -step,
    );
    return select(0.0, select(weights.x, 0.0, step == 0.0), in_front(frame, x.x))
        + select(0.0, select(weights.y, 0.0, step == 0.0), in_front(frame, x.y));
}

fn four_points(h: array<f32, 5>, sine: f32, cosine: f32, xa: f32, xb: f32, b_in_front: bool) -> f32 {
    let s0 = cosine * h[0] - sine * h[1];
    let s1 = cosine * h[1] - sine * h[2];
    let square_a = 1.0 + xa * xa;
    let square_b = 1.0 + xb * xb;
    let wa = (s1 - xb * s0) / (xa - xb) * square_a * square_a / (cosine - xa * sine);
    let wb = (s1 - xa * s0) / (xb - xa) * square_b * square_b / (cosine - xb * sine);
    let sum = xa + xb;
    let product = xa * xb;
    let at_seam = (h[4] - sum * h[3] + product * h[2]) - (h[3] - sum * h[2] + product * h[1]) * cosine / sine;
    let at_z_f = 1.0 - wa - wb - at_seam;
    let front = select(wa, wa + wb, b_in_front);
    let smallest = smaller(smaller(smaller(wa, wb), at_seam), at_z_f);
    if abs(front) <= LARGEST && smallest >= LEAST_WEIGHT {
        return front;
    }
    return NONE;
}

fn both_in_front(h: array<f32, 5>, sine: f32, cosine: f32) -> f32 {
    let s0 = cosine * h[0] - sine * h[1];
    let s1 = cosine * h[1] - sine * h[2];
    let s2 = cosine * h[2] - sine * h[3];
    let divisor = sine * s1 - cosine * s0;
    if divisor == 0.0 {
        return NONE;
    }
    let sum = sine * (s2 + s0) / divisor;
    let product = 1.0 + cosine * sum / sine;
    let half = 0.5 * sum;
    if !(half * half > product) {
        return NONE;
    }
    let x = quadratic_roots(-sum, product);
    if x.x * sine > cosine {
        return four_points(h, sine, cosine, x.y, x.x, true);
    }
    return NONE;
}

fn quartic_value_slope(c: array<f32, 5>, x: f32) -> vec2<f32> {
    var value = c[0];
    var slope = value;
    value = value * x + c[1];
    slope = slope * x + value;
    value = value * x + c[2];
    slope = slope * x + value;
    value = value * x + c[3];
    slope = slope * x + value;
    value = value * x + c[4];
    return vec2<f32>(value, slope);
}

fn one_each_side(h: array<f32, 5>, sine: f32, cosine: f32) -> f32 {
    let s0 = cosine * h[0] - sine * h[1];
    let s1 = cosine * h[1] - sine * h[2];
    let s2 = cosine * h[2] - sine * h[3];
    let quartic = array<f32, 5>(
        sine * s0,
        -(4.0 * sine * s1 + 2.0 * cosine * s0),
        6.0 * cosine * s1 + 3.0 * sine * (s2 - s0),
        4.0 * sine * s1 + 2.0 * cosine * (s0 - 2.0 * s2),
        -(sine * s2 + 2.0 * cosine * s1),
    );
    let cot = cosine / sine;
    let root = sqrt(4.0 * cot * cot + 3.0);
    var high = select(3.0 / (root - cot - cot), cot + cot + root, cot >= 0.0);
    var low = high / 3.0;
    let rising = quartic_value_slope(quartic, high).x > 0.0;
    if (quartic_value_slope(quartic, low).x > 0.0) == rising {
        return NONE;
    }
    var x = (low + high) * 0.5;
    for (var step = 0u; step < MAX_STEPS; step++) {
        let at = quartic_value_slope(quartic, x);
        if (at.x > 0.0) == rising {
            high = x;
        } else {
            low = x;
        }
        let newton = x - at.x / at.y;
        let next = select((low + high) * 0.5, newton, newton > low && newton < high);
        let moved = abs(next - x);
        x = next;
        if moved <= EPSILON * abs(x) {
            break;
        }
    }
    let numerator = ((2.0 * cosine - x * sine) * x + 3.0 * sine) * x - 2.0 * cosine;
    let denominator = (4.0 * cosine - 3.0 * x * sine) * x + sine;
    let xb = numerator / denominator;
    if xb * sine < cosine {
        return four_points(h, sine, cosine, x, xb, false);
    }
    return NONE;
}

// Bisection alone needs one for every bit.
const MAX_STEPS: u32 = 40u;

// The least mass in front of z_f.
fn lower_bound(b: array<f32, 4>, z_f: f32) -> f32 {
    if z_f <= 0.0 {
        return 0.0;
    }
    let beyond = z_f > 0.5;
    let wave = sine_cosine(PI * select(z_f, 1.0 - z_f, beyond));
    let sine = wave.x;
    let cosine = select(wave.y, -wave.y, beyond);
    // Moments of z - z_f.
    let sin2 = 2.0 * sine * cosine;
    let cos2 = cosine * cosine - sine * sine;
    let sin4 = 2.0 * sin2 * cos2;
    let cos4 = cos2 * cos2 - sin2 * sin2;
    let rotated = array<f32, 4>(
        b[0] * cos2 - b[1] * sin2,
        b[1] * cos2 + b[0] * sin2,
        b[2] * cos4 - b[3] * sin4,
        b[3] * cos4 + b[2] * sin4,
    );
    let through_z_f = three_points(forms(rotated), Frame(-sine, -cosine));
    if sine <= 0.0 {
        return select(0.0, through_z_f, through_z_f != NONE);
    }
    let h = forms(b);
    var best = through_z_f;
    best = smaller(three_points(h, Frame(sine, -cosine)), best);
    best = smaller(one_each_side(h, sine, cosine), best);
    best = smaller(both_in_front(h, sine, cosine), best);
    return select(0.0, best, best != NONE);
}

fn bounds(b: array<f32, CHANNELS>, z: f32) -> vec2<f32> {
    let mirrored = lower_bound(array<f32, 4>(-b[0], b[1], -b[2], b[3]), 1.0 - z);
    return ordered(lower_bound(b, z), 1.0 - clamp_unit(mirrored));
}
