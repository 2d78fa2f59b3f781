//! Power moments on the whole line: Hamburger moment shadow mapping (MSM15 Algorithms 2 and 3) and, for m = 2, the
//! one-sided Chebyshev (Cantelli) inequality of variance shadow maps.
//!
//! Everything is expressed in w = 1 / (z - z_f) instead of z. With the kernel polynomial
//! K(x, y) = sum_k P_k(x) P_k(y) / d_k (P_k the monic orthogonal polynomials, d_k the pivots of the Hankel matrix
//! B = L D L^T), Algorithm 2's coefficients are c = B^-1 (1, z_f, ...), its polynomial is K(z_f, z), and expanding it
//! at z_f gives K(z_f, z_f + 1/w) w^(n-1) = q_0 w^(n-1) + q_1 w^(n-2) + ... with q_0 = K(z_f, z_f) >= 1. So
//! - the leading coefficient never vanishes: the pole c_n -> 0, where a support point runs to infinity and MSM15
//!   reports single wrong pixels, is the harmless root w = 0;
//! - a support point lies in front of z_f exactly if w < 0;
//! - the weight at z_f, which is the upper minus the lower bound, is the Christoffel number 1 / q_0;
//! - if all other points lie in front, the lower bound is 1 - 1 / q_0 (for m = 2 this is Cantelli's inequality).
//!
//! Where an earlier pivot is not larger than its rounding error the distribution is numerically one of fewer surfaces.
//! Then the bound of the leading moments alone is returned: it is still a bound, and it is exact in the limit, because
//! that many surfaces are determined by that many moments (MSM15 Proposition 4). A pivot that is used is positive: its
//! absolute value, and at least its rounding error.

use super::canonical::{canonical, pivot_floor, positive_pivot};
pub use super::pair::Pair;
use super::roots;
use crate::arithmetic::Real;

/// Bounds from mean and second moment (variance shadow maps): Cantelli's inequality.
///
/// Zero variance means one surface at the mean: the lower bound is 0 up to the mean and 1 beyond it.
#[inline(always)]
pub fn chebyshev<R: Real>(moments: &[R; 2], z_f: R) -> Pair<R> {
    let offset = z_f - moments[0];
    let variance = (moments[1] - moments[0] * moments[0]).abs();
    let square = offset * offset;
    let sum = variance + square;
    let one = R::one();
    // Both vanish only where z_f is the single surface itself, up to underflow.
    let far = if sum > R::zero() { square / sum } else { R::zero() };
    if offset > R::zero() {
        // The upper bound behind the mean is 1, as the other point lies in front.
        let lower = if sum > R::zero() { far } else { one };
        Pair::clamped(lower, one)
    } else {
        Pair::clamped(R::zero(), if offset < R::zero() { one - far } else { one })
    }
}

/// Bounds from four power moments: Hamburger 4MSM (MSM15 Algorithm 3 without its bias).
#[inline(always)]
pub fn hamburger4<R: Real>(moments: &[R; 4], z_f: R) -> Pair<R> {
    match solve4(moments, z_f) {
        Solution4::Regular(points) => points.bounds(),
        Solution4::Degenerate(pair) => pair,
    }
}

/// What four moments say about z_f.
pub(crate) enum Solution4<R> {
    /// More than two surfaces: the three points that attain both bounds.
    Regular(ThreePoints<R>),
    /// At most two surfaces, which the moments determine.
    Degenerate(Pair<R>),
}

/// z_f and z_f + 1 / w_i.
pub(crate) struct ThreePoints<R> {
    /// w_1 <= w_2.
    pub w: [R; 2],
    at_z_f: R,
    /// First and second moment about z_f.
    pub s: [R; 2],
}

impl<R: Real> ThreePoints<R> {
    /// From P_1, P_2 and the slope of P_2 at z_f, and the pivots d_1 and d_2.
    #[inline(always)]
    pub(crate) fn new([p1, p2, p2_slope]: [R; 3], [d1, d2]: [R; 2]) -> Option<Self> {
        let q0 = d1 * d2 + p1 * p1 * d2 + p2 * p2 * d1;
        let q1 = p1 * d2 + p2 * p2_slope * d1;
        let q2 = p2 * d1;
        // Neither zero nor NaN.
        (q0 > R::zero()).then(|| {
            let w = roots::quadratic(q1 / q0, q2 / q0);
            Self { w, at_z_f: d1 * d2 / q0, s: [-p1, d1 + p1 * p1] }
        })
    }

    #[inline(always)]
    pub(crate) fn bounds(&self) -> Pair<R> {
        let [w1, w2] = self.w;
        let lower = if w1 >= R::zero() {
            R::zero()
        } else if w2 < R::zero() {
            R::one() - self.at_z_f
        } else {
            front_weight(w1, w2, self.s[0], self.s[1])
        };
        Pair::clamped(lower, lower + self.at_z_f)
    }
}

#[inline(always)]
pub(crate) fn solve4<R: Real>(moments: &[R; 4], z_f: R) -> Solution4<R> {
    let [b1, b2, b3, b4] = *moments;
    let d1 = b2 - b1 * b1;
    if d1 <= pivot_floor(b2) {
        return Solution4::Degenerate(chebyshev(&[b1, b2], z_f));
    }
    let e = b3 - b1 * b2;
    let l = e / d1;
    let d2 = positive_pivot(b4 - b2 * b2 - l * e, b4);
    // P_1 and P_2 at z_f; w-polynomial times d1 d2, so that nothing divides by a small pivot.
    let p1 = z_f - b1;
    let p2 = z_f * z_f - b2 - l * p1;
    match ThreePoints::new([p1, p2, z_f + z_f - l], [d1, d2]) {
        Some(points) => Solution4::Regular(points),
        None => Solution4::Degenerate(Pair { lower: R::zero(), upper: R::one() }),
    }
}

/// Weight of the point 1 / w1 if the three points are 0, 1 / w1 and 1 / w2 and the first moments about 0 are s1, s2.
#[inline(always)]
pub(crate) fn front_weight<R: Real>(w1: R, w2: R, s1: R, s2: R) -> R {
    w1 * w1 * (s1 - s2 * w2) / (w1 - w2)
}

/// Bounds from M = 2, 4, 6 or 8 power moments on the whole line (MSM15 Algorithm 2 in the form described above).
///
/// The moments are those of z, z^2, ..., z^M, without z^0. Input that no distribution has gives some value in
/// \[0, 1\]; use [`Hamburger`](crate::Hamburger) to be told.
#[inline(always)]
pub fn hamburger<R: Real, const M: usize>(moments: &[R; M], z_f: R) -> Pair<R> {
    match M {
        2 => chebyshev(&[moments[0], moments[1]], z_f),
        4 => hamburger4(&[moments[0], moments[1], moments[2], moments[3]], z_f),
        _ => canonical(moments, z_f).bounds(),
    }
}
