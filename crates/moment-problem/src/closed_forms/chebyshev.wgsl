// Cantelli's inequality: (lower, upper) bound from mean and second moment.

fn chebyshev(mean: f32, second: f32, z_f: f32) -> vec2<f32> {
    let offset = z_f - mean;
    let variance = abs(second - mean * mean);
    let square = offset * offset;
    let sum = variance + square;
    let far = select(0.0, square / sum, sum > 0.0);
    if offset > 0.0 {
        return ordered(select(1.0, far, sum > 0.0), 1.0);
    }
    return ordered(0.0, select(1.0, 1.0 - far, offset < 0.0));
}

// Clamped to [0, 1], the upper bound no less than the lower.
fn ordered(lower: f32, upper: f32) -> vec2<f32> {
    let clamped = clamp_unit(lower);
    return vec2<f32>(clamped, larger(smaller(upper, 1.0), clamped));
}

// What rounding in filters can take from the second moment of an unbiased variance shadow map.
const VARIANCE_ROUNDING: f32 = 8.0 * EPSILON;

fn cantelli(mean: f32, second: f32, z_f: f32) -> f32 {
    return chebyshev(mean, second + VARIANCE_ROUNDING * abs(second), z_f).x;
}
