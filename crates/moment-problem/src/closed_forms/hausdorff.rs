//! Four power moments on \[0, 1\]: Hausdorff 4MSM (MSM15 section 4).
//!
//! The sharp bounds are attained by a distribution of index 3 with a point at z_f, where an end point of the interval
//! counts one half: either z_f with two points inside (the Hamburger solution, if both lie in \[0, 1\]) or z_f, one
//! point t inside and both end points.
//!
//! In the second case the measure z (1 - z) dZ, whose moments M_k = b_(k+1) - b_(k+2) do not see the end points, has
//! points at z_f and t only. With its mean m and its variance V that is Cantelli's extremal distribution: with
//! x = z_f - m, t = m - V / x, and of its mass M_0 the share V / (V + x^2) lies at z_f. V cannot be negative; where
//! rounding made it so, it tells how large the rounding is.

use super::canonical::{canonical, positive_pivot};
use super::hamburger::{Pair, Solution4, ThreePoints, solve4};
use crate::arithmetic::Real;

/// A support point outside \[0, 1\] by this many rounding errors of 1 is taken for an end point.
const INSIDE_ROUNDINGS: f64 = 16.0;

/// A mass of z (1 - z) dZ up to this many rounding errors of the mean depth counts as none: two roundings of the
/// moments, each taken twice in the variance.
const MASS_ROUNDINGS: f64 = 4.0;

/// Bounds from four power moments of a distribution on \[0, 1\], for z_f in \[0, 1\].
///
/// At z_f = 0 the lower bound is 0. Moments of no distribution on \[0, 1\] give some value in \[0, 1\].
#[inline]
pub fn hausdorff4<R: Real>(moments: &[R; 4], z_f: R) -> Pair<R> {
    match solve4(moments, z_f) {
        Solution4::Degenerate(pair) => pair,
        Solution4::Regular(points) if is_inside(&points.w, z_f) => points.bounds(),
        Solution4::Regular(_) => four_points(moments, z_f).bounds(z_f),
    }
}

/// [`hausdorff4`] of (1 - alpha) b + alpha c for the moments b of one distribution and c of another, 0 < alpha < 1.
///
/// Rounding the mixture loses what a small bias is for, since b is rounded in the places of alpha. A mixture's covariances
/// are the mixed covariances plus alpha (1 - alpha) times products of the differences of means; those of b are differences
/// of products, which [`Real::product_difference`] rounds once, and nothing else cancels.
#[inline]
pub fn hausdorff4_biased<R: Real>(b: &[R; 4], c: &[R; 4], alpha: R, z_f: R) -> Pair<R> {
    let (zero, one) = (R::zero(), R::one());
    let keep = one - alpha;
    let cross = alpha * keep;
    let mix = |of_b: R, of_c: R| keep * of_b + alpha * of_c;
    let minus = R::product_difference;
    let d = [c[0] - b[0], c[1] - b[1]];
    // Covariances of z and z^2.
    let of = |m: &[R; 4]| {
        [minus(one, m[1], m[0], m[0]), minus(one, m[2], m[0], m[1]), minus(one, m[3], m[1], m[1])]
    };
    let (of_b, of_c) = (of(b), of(c));
    let d1 = (mix(of_b[0], of_c[0]) + cross * d[0] * d[0]).abs().max(R::from_f64(R::TINY));
    let e = mix(of_b[1], of_c[1]) + cross * d[0] * d[1];
    let square = mix(of_b[2], of_c[2]) + cross * d[1] * d[1];
    let l = e / d1;
    let d2 = positive_pivot(minus(square, d1, e, e) / d1, square);
    let p1 = (z_f - b[0]) - alpha * d[0];
    let p2 = (minus(z_f, z_f, one, b[1]) - alpha * d[1]) - l * p1;
    let Some(points) = ThreePoints::new([p1, p2, z_f + z_f - l], [d1, d2]) else {
        return Pair { lower: zero, upper: one };
    };
    if is_inside(&points.w, z_f) {
        return points.bounds();
    }
    // Moments of z (1 - z) dZ.
    let between = |m: &[R; 4]| [m[0] - m[1], m[1] - m[2], m[2] - m[3]];
    let (m, n) = (between(b), between(c));
    let (mass, first, b1) = (mix(m[0], n[0]), mix(m[1], n[1]), mix(b[0], c[0]));
    if mass <= R::from_f64(R::TINY) {
        return Pair::clamped(one - b1, one - b1);
    }
    let x = mix(minus(z_f, m[0], one, m[1]), minus(z_f, n[0], one, n[1])) / mass;
    let spread = keep * keep * minus(m[0], m[2], m[1], m[1])
        + alpha * alpha * minus(n[0], n[2], n[1], n[1])
        + cross * (minus(m[0], n[2], m[1], n[1]) + minus(n[0], m[2], n[1], m[1]));
    between_ends(b1, mass, first / mass, x, (spread / (mass * mass)).abs(), z_f).bounds(z_f)
}

/// Whether all z_f + 1/w lie in \[0, 1\], that is w z_f <= -1 or w (1 - z_f) >= 1. With surfaces at 0 or 1 these are
/// equalities up to rounding. A z_f at an end takes no part in the second case.
#[inline(always)]
pub(crate) fn is_inside<R: Real>(w: &[R], z_f: R) -> bool {
    let (zero, one) = (R::zero(), R::one());
    let nearly = one - R::from_f64(INSIDE_ROUNDINGS * R::EPSILON);
    let point_inside = |&w: &R| if w < zero { w * z_f <= -nearly } else { w * (one - z_f) >= nearly };
    z_f <= zero || z_f >= one || w.iter().all(point_inside)
}

/// The four points of the second case: 0, z_f, t and 1.
pub(crate) struct FourPoints<R> {
    pub free: R,
    pub at_zero: R,
    at_z_f: R,
    at_free: R,
    at_one: R,
}

/// Solves the second case. With all mass at the ends any free point serves, with weight 0.
#[inline(always)]
pub(crate) fn four_points<R: Real>(moments: &[R; 4], z_f: R) -> FourPoints<R> {
    let [b1, b2, b3, b4] = *moments;
    let (zero, one) = (R::zero(), R::one());
    let mass = b1 - b2;
    let noise = R::from_f64(MASS_ROUNDINGS * R::EPSILON) * b1.abs() + R::from_f64(R::TINY);
    if mass <= noise {
        return FourPoints { free: one, at_zero: one - b1, at_z_f: zero, at_free: zero, at_one: b1 };
    }
    let mean = (b2 - b3) / mass;
    let x = z_f - mean;
    let second = (b3 - b4) / mass;
    // Rounding of the moments, seen relative to the mass between the ends.
    let floor = noise / mass;
    let variance = (second - mean * mean).abs().max(floor);
    between_ends(b1, mass, mean, x, variance, z_f)
}

/// The four points from the mean depth b1 and the mass, mean and variance of z (1 - z) dZ; x is z_f less that mean.
#[inline(always)]
fn between_ends<R: Real>(b1: R, mass: R, mean: R, x: R, variance: R, z_f: R) -> FourPoints<R> {
    let (zero, one) = (R::zero(), R::one());
    let sum = variance + x * x;
    let (near, far) = (variance / sum, x * x / sum);
    // z_f at the mean: all mass is at z_f, and t runs to an end.
    let free = if x == zero { one } else { (mean - variance / x).max(zero).min(one) };
    let at_z_f = mass * near / (z_f * (one - z_f));
    let spread = free * (one - free);
    let at_free = if spread > R::from_f64(R::TINY) { mass * far / spread } else { zero };
    let at_one = b1 - at_z_f * z_f - at_free * free;
    let at_zero = (one - b1) - at_z_f * (one - z_f) - at_free * (one - free);
    FourPoints { free, at_zero, at_z_f, at_free, at_one }
}

impl<R: Real> FourPoints<R> {
    #[inline(always)]
    pub(crate) fn bounds(&self, z_f: R) -> Pair<R> {
        let one = R::one();
        if self.free < z_f {
            // 0 and the free point lie in front; what lies behind is better conditioned when the free point nears 0.
            Pair::clamped(one - self.at_z_f - self.at_one, one - self.at_one)
        } else {
            Pair::clamped(self.at_zero, self.at_zero + self.at_z_f)
        }
    }
}

/// The distribution that attains the bounds, for the evidence path.
pub(crate) fn support<R: Real>(moments: &[R; 4], z_f: R) -> Vec<(R, R)> {
    let solution = canonical(moments, z_f);
    // Fewer points than three: the moments determine the distribution, whose points are inside up to rounding.
    if solution.count < 2 || is_inside(&solution.inverse_offsets[..solution.count], z_f) {
        return solution.points(z_f);
    }
    let FourPoints { free, at_zero, at_z_f, at_free, at_one } = four_points(moments, z_f);
    vec![(z_f, at_z_f), (R::zero(), at_zero), (free, at_free), (R::one(), at_one)]
}
