//! Four power moments on \[0, 1\]: Hausdorff 4MSM (MSM15 section 4).
//!
//! The sharp bounds are attained by a distribution of index 3 with a point at z_f, where an end point of the interval
//! counts one half: either z_f with two points inside (the Hamburger solution, if both lie in \[0, 1\]) or z_f, one
//! point t inside and both end points. In the second case z (1 - z) (z - z_f) (z - t) vanishes on the support, so
//! t = E\[z^2 (1 - z) (z - z_f)\] / E\[z (1 - z) (z - z_f)\].

use crate::arithmetic::Real;
use crate::hamburger::{Pair, Solution4, canonical, solve4};

/// A support point outside \[0, 1\] by this many rounding errors of 1 is taken for an end point.
const INSIDE_ROUNDINGS: f64 = 16.0;

/// Bounds from four power moments of a distribution on \[0, 1\], for z_f in \[0, 1\].
///
/// At z_f = 0 the lower bound is 0. Moments of no distribution on \[0, 1\] give some value in \[0, 1\].
#[inline]
pub fn hausdorff4<R: Real>(moments: &[R; 4], z_f: R) -> Pair<R> {
    match solve4(moments, z_f) {
        Solution4::Degenerate(pair) => pair,
        Solution4::Regular(points) if is_inside(&points.w, z_f) => points.bounds(),
        Solution4::Regular(_) => ends_bounds(moments, z_f, free_point(moments, z_f)),
    }
}

/// Whether all z_f + 1/w lie in \[0, 1\], that is w z_f <= -1 or w (1 - z_f) >= 1. With surfaces at 0 or 1 these are
/// equalities up to rounding. A z_f at an end takes no part in the second case.
#[inline(always)]
fn is_inside<R: Real>(w: &[R], z_f: R) -> bool {
    let (zero, one) = (R::zero(), R::one());
    let nearly = one - R::from_f64(INSIDE_ROUNDINGS * R::EPSILON);
    let point_inside = |&w: &R| if w < zero { w * z_f <= -nearly } else { w * (one - z_f) >= nearly };
    z_f <= zero || z_f >= one || w.iter().all(point_inside)
}

/// The fourth point of the second case. With all mass at the ends (or the moments on the boundary of their cone) any
/// point serves, with weight 0.
#[inline(always)]
fn free_point<R: Real>(moments: &[R; 4], z_f: R) -> R {
    let [b1, b2, b3, b4] = *moments;
    // E[z^k (1 - z) (z - z_f)] for k = 1, 2.
    let first = (b2 - b3) - z_f * (b1 - b2);
    let second = (b3 - b4) - z_f * (b2 - b3);
    let noise = R::from_f64(4.0 * R::EPSILON) * b1.abs();
    if first.abs() <= noise { R::one() } else { (second / first).max(R::zero()).min(R::one()) }
}

fn ends_bounds<R: Real>(moments: &[R; 4], z_f: R, free: R) -> Pair<R> {
    let weights = end_weights(moments, z_f, free);
    let one = R::one();
    if free < z_f {
        // 0 and the free point lie in front; the rest is better conditioned when the free point nears 0.
        let lower = one - weights.at_z_f - weights.at_one;
        Pair::clamped(lower, one - weights.at_one)
    } else {
        Pair::clamped(weights.at_zero, weights.at_zero + weights.at_z_f)
    }
}

struct EndWeights<R> {
    at_zero: R,
    at_z_f: R,
    at_one: R,
}

/// Weights of 0, z_f and 1 beside the free point t: each is the expectation of the cubic that vanishes at the other
/// points, divided by its value there. A vanishing divisor means coinciding points; the weight is then 0.
fn end_weights<R: Real>(moments: &[R; 4], z_f: R, free: R) -> EndWeights<R> {
    let [b1, b2, b3, _] = *moments;
    let one = R::one();
    let ratio = |numerator: R, divisor: R| {
        if divisor.abs() <= R::from_f64(R::TINY) { R::zero() } else { numerator / divisor }
    };
    let (sum, product) = (z_f + free, z_f * free);
    // (z - z_f)(z - t) = z^2 - sum z + product
    let at_zero = (b2 - sum * b1 + product) - (b3 - sum * b2 + product * b1);
    let at_one = b3 - sum * b2 + product * b1;
    let at_z_f = (b2 - b3) - free * (b1 - b2);
    EndWeights {
        at_zero: ratio(at_zero, product),
        at_one: ratio(at_one, (one - z_f) * (one - free)),
        at_z_f: ratio(at_z_f, z_f * (one - z_f) * (z_f - free)).max(R::zero()),
    }
}

/// The distribution that attains the bounds, for the evidence path.
pub(crate) fn support<R: Real>(moments: &[R; 4], z_f: R) -> Vec<(R, R)> {
    let solution = canonical(moments, z_f);
    // Fewer points than three: the moments determine the distribution, whose points are inside up to rounding.
    if solution.count < 2 || is_inside(&solution.inverse_offsets[..solution.count], z_f) {
        return solution.points(z_f);
    }
    let free = free_point(moments, z_f);
    let weights = end_weights(moments, z_f, free);
    let rest = R::one() - weights.at_zero - weights.at_z_f - weights.at_one;
    vec![(z_f, weights.at_z_f), (R::zero(), weights.at_zero), (free, rest), (R::one(), weights.at_one)]
}
