//! Four power moments on \[0, 1\]: Hausdorff 4MSM (MSM15 section 4).
//!
//! The sharp bounds are attained by a distribution of index 3 with a point at z_f, where an end point of the interval
//! counts one half: either z_f with two points inside (the Hamburger solution, if both lie in \[0, 1\]) or z_f, one
//! point t inside and both end points. In the second case z (1 - z) (z - z_f) (z - t) vanishes on the support, so
//! t = E\[z^2 (1 - z) (z - z_f)\] / E\[z (1 - z) (z - z_f)\].

use crate::arithmetic::Real;
use crate::hamburger::{Canonical, Pair, canonical};

/// A support point outside \[0, 1\] by this many rounding errors of 1 is taken for an end point.
const INSIDE_ROUNDINGS: f64 = 16.0;

/// Support points with their weights, z_f first; points of weight 0 may be missing.
pub(crate) struct Support<R> {
    pub points: [(R, R); 4],
    pub count: usize,
}

/// Bounds from four power moments of a distribution on \[0, 1\], for z_f in \[0, 1\].
///
/// At z_f = 0 the lower bound is 0. Moments of no distribution on \[0, 1\] give some value in \[0, 1\].
#[inline]
pub fn hausdorff4<R: Real>(moments: &[R; 4], z_f: R) -> Pair<R> {
    match solve(moments, z_f, 1.0) {
        Solution::Interior(canonical) => canonical.bounds(),
        Solution::Ends { free, .. } => ends_bounds(moments, z_f, free),
    }
}

enum Solution<R> {
    Interior(Canonical<R>),
    /// z_f, both end points and the free point.
    Ends {
        free: R,
    },
}

#[inline(always)]
fn solve<R: Real>(moments: &[R; 4], z_f: R, floor_scale: f64) -> Solution<R> {
    let (zero, one) = (R::zero(), R::one());
    let hamburger = canonical(moments, z_f, floor_scale);
    // z_f + 1/w lies in [0, 1] exactly if w z_f <= -1 or w (1 - z_f) >= 1; with surfaces at 0 or 1 these are equal up
    // to rounding. A z_f at an end takes no part in the second case.
    let nearly = one - R::from_f64(INSIDE_ROUNDINGS * R::EPSILON);
    let at_end = z_f <= zero || z_f >= one;
    let inside = at_end
        || hamburger.inverse_offsets[..hamburger.count]
            .iter()
            .all(|&w| if w < zero { w * z_f <= -nearly } else { w * (one - z_f) >= nearly });
    // Fewer points than three mean that the moments determine the distribution: its points are inside, and rounding
    // must not send us to the other branch.
    if inside || hamburger.count < 2 {
        return Solution::Interior(hamburger);
    }
    let [b1, b2, b3, b4] = *moments;
    // E[z^k (1 - z) (z - z_f)] for k = 1, 2.
    let first = (b2 - b3) - z_f * (b1 - b2);
    let second = (b3 - b4) - z_f * (b2 - b3);
    let noise = R::from_f64(4.0 * R::EPSILON) * b1.abs();
    // All mass at the ends (or the moment vector on the boundary of the cone): any free point serves, with weight 0.
    let free = if first.abs() <= noise { one } else { (second / first).max(zero).min(one) };
    Solution::Ends { free }
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
pub(crate) fn support<R: Real>(moments: &[R; 4], z_f: R, floor_scale: f64) -> Support<R> {
    match solve(moments, z_f, floor_scale) {
        Solution::Interior(canonical) => {
            let points = canonical.points(z_f);
            let mut support = Support { points: [(z_f, R::zero()); 4], count: points.len() };
            for (slot, point) in support.points.iter_mut().zip(points) {
                *slot = point;
            }
            support
        }
        Solution::Ends { free } => {
            let weights = end_weights(moments, z_f, free);
            let rest = R::one() - weights.at_zero - weights.at_z_f - weights.at_one;
            let points = [
                (z_f, weights.at_z_f),
                (R::zero(), weights.at_zero),
                (free, rest),
                (R::one(), weights.at_one),
            ];
            Support { points, count: 4 }
        }
    }
}
