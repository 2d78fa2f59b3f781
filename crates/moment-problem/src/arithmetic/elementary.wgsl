// Exponential, sine and cosine to the last few digits: WGSL's own may err by 2^-11 (sine) or by 3 + 2 |x| units.

const LARGEST: f32 = 3.4028234e38;
const EPSILON: f32 = 1.1920929e-7;
const TINY: f32 = 1e-30;

// Larger and smaller of two; `b` where `a` is NaN.
fn larger(a: f32, b: f32) -> f32 {
    return select(b, a, a > b);
}

fn smaller(a: f32, b: f32) -> f32 {
    return select(b, a, a < b);
}

// Clamped to [0, 1]; NaN becomes 0.
fn clamp_unit(x: f32) -> f32 {
    return smaller(larger(x, 0.0), 1.0);
}

// A depth clamped to [0, 1]; NaN becomes 1, the far plane.
fn unit(depth: f32) -> f32 {
    return select(select(1.0, depth, depth < 1.0), 0.0, depth < 0.0);
}

// e^x for |x| <= 88: x = k ln 2 + r with |r| <= ln 2 / 2, then a polynomial in r.
fn exponential(x: f32) -> f32 {
    let k = round(x * 1.44269504);
    // The first part of ln 2 has 9 bits, so that k times it is exact.
    let r = (x - k * 0.693359375) + k * 2.12194440e-4;
    let tail = ((((1.9875691e-4 * r + 1.3981999e-3) * r + 8.3334519e-3) * r + 4.1665796e-2) * r + 1.6666666e-1) * r + 0.5;
    let value = 1.0 + (r + r * r * tail);
    // 2^k in two factors, as it may not be a normal number itself.
    let half = i32(k) / 2;
    return value * power_of_two(half) * power_of_two(i32(k) - half);
}

fn power_of_two(exponent: i32) -> f32 {
    return bitcast<f32>(u32(exponent + 127) << 23u);
}

// (sine, cosine) of x for |x| up to some thousand: x = q pi / 2 + r with |r| <= pi / 4.
fn sine_cosine(x: f32) -> vec2<f32> {
    let q = round(x * 0.636619772);
    let r = ((x - q * 1.5703125) - q * 4.83751297e-4) - q * 7.54978995e-8;
    let s = r * r;
    let sine = r + r * s * ((-1.9515296e-4 * s + 8.3321609e-3) * s - 1.6666655e-1);
    let cosine = 1.0 - 0.5 * s + s * s * ((2.4433157e-5 * s - 1.3887316e-3) * s + 4.1666646e-2);
    let quadrant = u32(i32(q)) & 3u;
    let swapped = select(vec2<f32>(sine, cosine), vec2<f32>(cosine, sine), (quadrant & 1u) == 1u);
    return vec2<f32>(select(swapped.x, -swapped.x, quadrant >= 2u), select(swapped.y, -swapped.y, quadrant == 1u || quadrant == 2u));
}
