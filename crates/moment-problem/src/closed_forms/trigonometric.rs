//! Trigonometric moment shadow mapping: sine and cosine of 2 pi z and 4 pi z on \[0, 1\] (MSM15 section 4, TMSM).
//!
//! On the circle 0 and 1 are the same point, but mass at z = 1 does not shadow while mass at z = 0 does; so the
//! problem has two jumps, at z_f and at the seam, and its solution for the lower bound is one of
//! 1. z_f and two more points (canonical representation through z_f),
//! 2. the seam (z = 1) and two more points (canonical representation through the seam),
//! 3. z_f, the seam and two more points, either both in front of z_f or one on each side.
//!
//! Every such distribution with non-negative weights has the given moments, so each is an upper bound of the
//! minimum, and the minimum is one of them: we take the smallest.
//!
//! With c = cos pi z, s = sin pi z and x = c / s = cot pi z, trigonometric polynomials of degree 2 are quartic forms
//! in (c, s), and h_k = E\[c^k s^(4-k)\] are linear in the moments. In front of z_f means x > cot pi z_f.
//!
//! Case 3. The dual polynomial vanishes at z_f and at the seam. One point a in front, b behind: it is
//! C sin(pi z) sin(pi (z_f - z)) sin^2(pi (z - b)) with its maximum 1 at a, which gives b as a rational function of a.
//! Both in front: 1 minus it is C sin^2(pi (z - a)) sin^2(pi (z - b)), equal to 1 at both jumps. Together with the
//! moments s_k = E\[(x_f - x) x^k / (1 + x^2)^2\], which see only a and b and so satisfy
//! s_2 - (x_a + x_b) s_1 + x_a x_b s_0 = 0, this is a quartic in x_a in the first and a quadratic in the second case.

use super::hamburger::Pair;
use super::roots;
use crate::arithmetic::{DoubleDouble, Real};

/// A candidate distribution: its mass strictly in front of z_f, and its points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate<R> {
    pub front: R,
    smallest_weight: R,
    /// (x = cot pi z, weight) of the free points.
    free: [(R, R); 2],
    pub at_z_f: R,
    pub at_seam: R,
}

/// Weights of a candidate of case 3 may be negative by the root of a rounding error. Few surfaces with a bias alpha have
/// points next to a jump at distances of some alpha, known up to epsilon / alpha, and such candidates have weights of some
/// -alpha: once the side of a point is a guess, alpha^2 < epsilon, the candidate with the mass on the jump counts. It has
/// less mass in front, so that nothing is shadowed by rounding.
fn least_weight<R: Real>() -> R {
    R::from_f64(-R::EPSILON.sqrt())
}

/// A determinant of the h_k (entries at most 1) up to this many rounding errors is taken for zero: one surface.
const RANK_ROUNDINGS: f64 = 8.0;

/// Sharp bounds from E\[sin 2 pi z, cos 2 pi z, sin 4 pi z, cos 4 pi z\] for z_f in \[0, 1\].
///
/// The lower bound is of the mass in \[0, z_f), the upper of the mass in \[0, z_f\]. Moments of no distribution give
/// some value in \[0, 1\].
pub fn trigonometric4<R: Real>(moments: &[R; 4], z_f: R) -> Pair<R> {
    let (zero, one) = (R::zero(), R::one());
    let lower = lower_candidate(moments, z_f).map_or(zero, |candidate| candidate.front);
    // Mirroring the depths exchanges the two bounds.
    let mirrored = lower_candidate(&mirror(moments), one - z_f).map_or(zero, |candidate| candidate.front);
    Pair::clamped(lower, one - mirrored.clamp_unit())
}

/// Moments of 1 - z.
pub(crate) fn mirror<R: Real>(moments: &[R; 4]) -> [R; 4] {
    let [s1, c1, s2, c2] = *moments;
    [-s1, c1, -s2, c2]
}

/// The distribution of least mass before z_f; `None` where that mass is trivially 0 (z_f = 0).
pub(crate) fn lower_candidate<R: Real>(moments: &[R; 4], z_f: R) -> Option<Candidate<R>> {
    let (zero, one) = (R::zero(), R::one());
    if z_f <= zero {
        return None;
    }
    // sin pi z_f from the nearer end, so that it does not lose digits near 1.
    let half_turn = |z: R| R::from_double_double(DoubleDouble::pi()) * z;
    let near_end = half_turn(if z_f > R::from_f64(0.5) { one - z_f } else { z_f });
    let sine = near_end.sin();
    let cosine = if z_f > R::from_f64(0.5) { -near_end.cos() } else { near_end.cos() };

    let h = forms(moments);
    let rotated = forms(&rotate(moments, sine, cosine));
    // A point within rounding of the seam does not count as in front: at the seam it need not shadow.
    let noise = R::from_f64(RANK_ROUNDINGS * R::EPSILON);
    let through_z_f =
        three_points(&rotated, |x| x * sine + cosine < -(noise * (one + x.abs()))).map(|candidate| {
            Candidate {
                // Back from cot pi (z - z_f) to cot pi z.
                free: candidate.free.map(|(x, w)| ((x * cosine - sine) / (x * sine + cosine), w)),
                at_z_f: candidate.at_seam,
                at_seam: zero,
                ..candidate
            }
        });
    if sine <= zero {
        return through_z_f; // z_f = 1: both jumps coincide
    }
    let through_seam = three_points(&h, |x| x * sine - cosine > noise * (one + x.abs()));
    let four = [one_each_side(&h, sine, cosine), both_in_front(&h, sine, cosine)]
        .into_iter()
        .flatten()
        .filter(|candidate| candidate.smallest_weight >= least_weight());
    let mut best: Option<Candidate<R>> = None;
    for candidate in [through_z_f, through_seam].into_iter().flatten().chain(four) {
        if best.is_none_or(|best| candidate.front < best.front) {
            best = Some(candidate);
        }
    }
    best
}

impl<R: Real> Candidate<R> {
    /// Depths and weights of the free points.
    pub(crate) fn free_points(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        /// Points this close to the seam are on it, on the side that does not shadow.
        const SEAM: f64 = 1e-15;
        self.free.iter().map(|&(x, w)| {
            let z = 1f64.atan2(x.to_f64()) / std::f64::consts::PI;
            (if z < SEAM { 1.0 } else { z }, w.to_f64())
        })
    }
}

/// h_k = E\[cos^k sin^(4-k)\] of pi z, k = 0..4.
fn forms<R: Real>(moments: &[R; 4]) -> [R; 5] {
    let [s1, c1, s2, c2] = *moments;
    let constant = R::from_f64;
    let eighth = constant(0.125);
    [
        (constant(3.0) - constant(4.0) * c1 + c2) * eighth,
        (s1 + s1 - s2) * eighth,
        (R::one() - c2) * eighth,
        (s1 + s1 + s2) * eighth,
        (constant(3.0) + constant(4.0) * c1 + c2) * eighth,
    ]
}

/// Moments of z - z_f, given sin and cos of pi z_f.
fn rotate<R: Real>(moments: &[R; 4], sine: R, cosine: R) -> [R; 4] {
    let turn = |s: R, c: R, sin: R, cos: R| (s * cos - c * sin, c * cos + s * sin);
    let two = R::from_f64(2.0);
    let (sin2, cos2) = (two * sine * cosine, cosine * cosine - sine * sine);
    let (sin4, cos4) = (two * sin2 * cos2, cos2 * cos2 - sin2 * sin2);
    let (s1, c1) = turn(moments[0], moments[1], sin2, cos2);
    let (s2, c2) = turn(moments[2], moments[3], sin4, cos4);
    [s1, c1, s2, c2]
}

/// The form alpha c^2 + beta c s + gamma s^2 that vanishes on the two points besides s = 0.
fn node_quadratic<R: Real>(h: &[R; 5]) -> [R; 3] {
    [h[2] * h[0] - h[1] * h[1], h[1] * h[2] - h[3] * h[0], h[3] * h[1] - h[2] * h[2]]
}

/// At most one surface besides the point at s = 0, read off the moments of lowest order.
fn two_points<R: Real>(h: &[R; 5], in_front: impl Fn(R) -> bool) -> Candidate<R> {
    let (zero, one) = (R::zero(), R::one());
    let (mixed, square) = (h[1] + h[3], h[0] + h[2]);
    let noise = R::from_f64(RANK_ROUNDINGS * R::EPSILON);
    let (x, weight) = if square <= noise {
        (zero, zero)
    } else {
        let x = mixed / square;
        (x, (square * (one + x * x)).min(one))
    };
    let front = if in_front(x) { weight } else { zero };
    let rest = one - weight;
    Candidate { front, smallest_weight: rest, free: [(x, weight), (x, zero)], at_z_f: zero, at_seam: rest }
}

/// Canonical representation with a point at s = 0 of the frame of `h` (its weight is returned as `at_seam`).
fn three_points<R: Real>(h: &[R; 5], in_front: impl Fn(R) -> bool) -> Option<Candidate<R>> {
    let (zero, one) = (R::zero(), R::one());
    let [alpha, beta, gamma] = node_quadratic(h);
    // The h_k err by a rounding of 1 each, their products by as much times the other factor.
    let noise = R::from_f64(RANK_ROUNDINGS * R::EPSILON) * (h[0] + h[1].abs() + h[2] + h[3].abs()).abs();
    if alpha.abs() <= noise && beta.abs() <= noise && gamma.abs() <= noise {
        return Some(two_points(h, in_front));
    }
    // alpha vanishes with one surface besides s = 0 only; then solve for 1 / x, whose roots are never both infinite.
    let [x1, x2] = if alpha.abs() * R::from_f64(1.0 / R::EPSILON) > gamma.abs() {
        roots::quadratic(beta / alpha, gamma / alpha)
    } else {
        let limit = R::from_f64(1.0 / R::EPSILON);
        roots::quadratic(beta / gamma, alpha / gamma).map(|y| if y == zero { limit } else { one / y })
    };
    if !(x1.is_finite() && x2.is_finite()) {
        return None;
    }
    // E[s (c - x2 s)] sees only the first point: (1 + x1^2) (E[s c] - x2 E[s^2]) / (x1 - x2).
    let (mixed, square) = (h[1] + h[3], h[0] + h[2]);
    let weight = |x: R, other: R| {
        let step = x - other;
        if step == zero { zero } else { (one + x * x) * (mixed - other * square) / step }
    };
    let (w1, w2) = (weight(x1, x2), weight(x2, x1));
    let rest = one - w1 - w2;
    let count = |x: R, w: R| if in_front(x) { w } else { zero };
    Some(Candidate {
        front: count(x1, w1) + count(x2, w2),
        smallest_weight: w1.min(w2).min(rest),
        free: [(x1, w1), (x2, w2)],
        at_z_f: zero,
        at_seam: rest,
    })
}

/// sin(pi z_f) s_k for k = 0, 1, 2.
fn reduced<R: Real>(h: &[R; 5], sine: R, cosine: R) -> [R; 3] {
    [0, 1, 2].map(|k| cosine * h[k] - sine * h[k + 1])
}

/// Case 3 with the points given: weights from the reduced moments.
fn four_points<R: Real>(
    h: &[R; 5],
    sine: R,
    cosine: R,
    xa: R,
    xb: R,
    b_in_front: bool,
) -> Option<Candidate<R>> {
    let one = R::one();
    let s = reduced(h, sine, cosine);
    let weight = |x: R, other: R| {
        let square = one + x * x;
        (s[1] - other * s[0]) / (x - other) * square * square / (cosine - x * sine)
    };
    let (wa, wb) = (weight(xa, xb), weight(xb, xa));
    // The form c (c sin - s cos) (c - xa s) (c - xb s) / sin is 1 at the seam and 0 at the other points.
    let (sum, product) = (xa + xb, xa * xb);
    let form = |k: usize| h[k + 2] - sum * h[k + 1] + product * h[k];
    let at_seam = form(2) - form(1) * cosine / sine;
    let at_z_f = one - wa - wb - at_seam;
    let front = if b_in_front { wa + wb } else { wa };
    if !front.is_finite() {
        return None;
    }
    Some(Candidate {
        front,
        smallest_weight: wa.min(wb).min(at_seam).min(at_z_f),
        free: [(xa, wa), (xb, wb)],
        at_z_f,
        at_seam,
    })
}

fn both_in_front<R: Real>(h: &[R; 5], sine: R, cosine: R) -> Option<Candidate<R>> {
    let s = reduced(h, sine, cosine);
    let divisor = sine * s[1] - cosine * s[0];
    if divisor == R::zero() {
        return None;
    }
    // (x_a - x_f) (x_b - x_f) = 1 + x_f^2 and the moment relation give the sum, then the product.
    let sum = sine * (s[2] + s[0]) / divisor;
    let product = R::one() + cosine * sum / sine;
    let half = sum * R::from_f64(0.5);
    let distinct = half * half > product; // false for NaN, too
    if !distinct {
        return None;
    }
    let [xb, xa] = roots::quadratic(-sum, product);
    // Both roots lie on the same side of x_f; the front is the upper one.
    if xb * sine > cosine { four_points(h, sine, cosine, xa, xb, true) } else { None }
}

fn one_each_side<R: Real>(h: &[R; 5], sine: R, cosine: R) -> Option<Candidate<R>> {
    let constant = R::from_f64;
    let [s0, s1, s2] = reduced(h, sine, cosine);
    let (two, three, four) = (constant(2.0), constant(3.0), constant(4.0));
    // The quartic in x = x_a, highest power first.
    let quartic = [
        sine * s0,
        -(four * sine * s1 + two * cosine * s0),
        constant(6.0) * cosine * s1 + three * sine * (s2 - s0),
        four * sine * s1 + two * cosine * (s0 - two * s2),
        -(sine * s2 + two * cosine * s1),
    ];
    let evaluate = |x: R| {
        let (mut value, mut slope) = (quartic[0], R::zero());
        for &coefficient in &quartic[1..] {
            slope = slope * x + value;
            value = value * x + coefficient;
        }
        (value, slope)
    };
    // x_b runs through everything behind z_f while x_a runs through this bracket, which spans a factor of 3.
    let cot = cosine / sine;
    let root = (four * cot * cot + three).sqrt();
    // (2 cot + root) without cancellation for negative cot: root^2 - 4 cot^2 = 3.
    let mut high = if cot >= R::zero() { cot + cot + root } else { three / (root - cot - cot) };
    let mut low = high / three;
    let rising = evaluate(high).0 > R::zero();
    if (evaluate(low).0 > R::zero()) == rising {
        return None;
    }
    // Newton's method, replaced by bisection wherever it leaves the bracket.
    let mut x = (low + high) * constant(0.5);
    for _ in 0..MAX_STEPS {
        let (value, slope) = evaluate(x);
        if (value > R::zero()) == rising {
            high = x;
        } else {
            low = x;
        }
        let newton = x - value / slope;
        let next = if newton > low && newton < high { newton } else { (low + high) * constant(0.5) };
        let moved = (next - x).abs();
        x = next;
        if moved <= constant(R::EPSILON) * x.abs() {
            break;
        }
    }
    // b as a function of a, from the maximum of the dual polynomial at a.
    let numerator = ((two * cosine - x * sine) * x + three * sine) * x - two * cosine;
    let denominator = (four * cosine - three * x * sine) * x + sine;
    let xb = numerator / denominator;
    // At the ends of the bracket b meets z_f or the seam: cases 1 and 2.
    if xb * sine < cosine { four_points(h, sine, cosine, x, xb, false) } else { None }
}

/// Steps for one root: bisection alone needs one for every bit of a double-double.
const MAX_STEPS: usize = 110;
