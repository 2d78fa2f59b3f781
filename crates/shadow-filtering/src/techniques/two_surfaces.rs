//! Kernels of one or exactly two depths, such as the shadow of one wall on another, need no moment bias: four moments
//! determine the depths and their weights (MSM15 Proposition 4). The bias alone would cost up to alpha / d^2 for a
//! receiver at distance d from a surface.

use std::f64::consts::TAU;

/// Pivots up to this count as zero: what rounding in two filter passes, some sixteen roundings of moments of size 1,
/// and the differences of the factorisation leave of it.
const NOISE: f64 = 32.0 * f64::EPSILON;

/// A pivot that small leaves room for mass elsewhere: at most NOISE / p(z)^2 at the depth z, p the polynomial that
/// vanishes at both depths (Markov's inequality for p^2). A surface counts as in front where that is less than this,
/// a tenth of the tolerance for violations of a bound.
pub(crate) const UNCERTAIN_MASS: f64 = 1e-7;

/// Least variance (squared chord for trigonometric moments): below, rounding moves the roots too far.
const LEAST_VARIANCE: f64 = 1e-6;

/// The mass before `z_f` if the four power moments, in any variable, are those of at most two points; no more than the true
/// mass.
pub(crate) fn powers(moments: [f64; 4], z_f: f64) -> Option<f64> {
    let [b1, b2, b3, b4] = moments;
    let variance = b2 - b1 * b1;
    let e = b3 - b1 * b2;
    if variance <= NOISE {
        return Some(if z_f > b1 && clear(z_f - b1) { 1.0 } else { 0.0 });
    }
    if variance < LEAST_VARIANCE || b4 - b2 * b2 - e * e / variance > NOISE {
        return None;
    }
    // z^2 - l (z - b1) - b2 vanishes at both points.
    let l = e / variance;
    let gap = (l * l - 4.0 * (l * b1 - b2)).max(0.0).sqrt();
    let points = [0.5 * (l - gap), 0.5 * (l + gap)];
    let weights = [(points[1] - b1) / gap, (b1 - points[0]) / gap];
    let mass = points.iter().zip(weights).filter(|&(&point, _)| z_f > point && clear((z_f - point) * gap));
    Some(mass.map(|(_, weight)| weight).sum::<f64>().clamp(0.0, 1.0))
}

/// The same from sine and cosine of 2 pi z and 4 pi z.
pub(crate) fn trigonometric(moments: [f64; 4], z_f: f64) -> Option<f64> {
    let [s1, c1, s2, c2] = moments;
    // With u = e^(2 pi i z): first and second moment a and b, and b - a^2.
    let square = [c1 * c1 - s1 * s1, 2.0 * c1 * s1];
    let rest = [c2 - square[0], s2 - square[1]];
    let variance = 1.0 - c1 * c1 - s1 * s1;
    if variance <= NOISE {
        if !clear(s1.hypot(c1 - 1.0)) {
            return None;
        }
        let depth = (s1.atan2(c1) / TAU).rem_euclid(1.0);
        return Some(if z_f > depth && clear(z_f - depth) { 1.0 } else { 0.0 });
    }
    let pivot = variance - (rest[0] * rest[0] + rest[1] * rest[1]) / variance;
    if variance < LEAST_VARIANCE || pivot > NOISE {
        return None;
    }
    // Both points solve u^2 - sum u + product = 0; E[conj(u) p] = 0 and E[p] = 0 give product and sum.
    let product = [-rest[0] / variance, -rest[1] / variance];
    let sum = [c1 + product[0] * c1 + product[1] * s1, s1 + product[1] * c1 - product[0] * s1];
    let discriminant =
        [sum[0] * sum[0] - sum[1] * sum[1] - 4.0 * product[0], 2.0 * sum[0] * sum[1] - 4.0 * product[1]];
    let (size, half) =
        (discriminant[0].hypot(discriminant[1]).sqrt(), 0.5 * discriminant[1].atan2(discriminant[0]));
    let root = [size * half.cos(), size * half.sin()];
    let points = [-0.5, 0.5].map(|sign| [0.5 * sum[0] + sign * root[0], 0.5 * sum[1] + sign * root[1]]);
    let (sine, cosine) = (TAU * z_f).sin_cos();
    let mut mass = 0.0;
    for (point, other) in [(points[0], points[1]), (points[1], points[0])] {
        let depth = (point[1].atan2(point[0]) / TAU).rem_euclid(1.0);
        // 0 and 1 are the same point of the circle; the moments do not tell which.
        if !clear(point[1].hypot(point[0] - 1.0) * size) {
            return None;
        }
        if z_f > depth && clear((cosine - point[0]).hypot(sine - point[1]) * size) {
            let along = [point[0] - other[0], point[1] - other[1]];
            mass += ((c1 - other[0]) * along[0] + (s1 - other[1]) * along[1]) / (size * size);
        }
    }
    Some(mass.clamp(0.0, 1.0))
}

/// `value` is p at the depth in question.
fn clear(value: f64) -> bool {
    NOISE <= UNCERTAIN_MASS * value * value
}
