//! The published algorithms as they are written down: in the depth z, without the branches and the variable
//! w = 1 / (z - z_f) of [`hamburger`](mod@crate::hamburger). For comparison.
//!
//! Everything here follows from MSM15 Algorithms 2 and 3 and the mathematics behind them: B = L D L^T, B c = (1, z_f,
//! z_f^2, ...), the roots of c_1 + c_2 z + ... + c_n z^(n-1), weights from the first moments. Where a pivot, c_n or a
//! difference of two roots vanishes these divide by zero; values are not clamped.

use super::roots;
use crate::arithmetic::Real;

/// Most support points.
const MAX_POINTS: usize = 5;

/// A bound that is a number, though perhaps one outside \[0, 1\].
#[inline(always)]
fn number<R: Real>(value: R) -> Option<R> {
    value.is_finite().then_some(value)
}

/// The lower bound of variance shadow maps from mean and second moment; `None` where the variance and the distance to
/// the mean both vanish.
pub fn chebyshev<R: Real>(moments: &[R; 2], z_f: R) -> Option<R> {
    let [b1, b2] = *moments;
    if z_f <= b1 {
        return number(R::zero());
    }
    let variance = b2 - b1 * b1;
    let offset = z_f - b1;
    number(R::one() - variance / (variance + offset * offset))
}

/// Solution of B c = (1, z_f, ..., z_f^(n-1)) by B = L D L^T for the Hankel matrix of the moments.
fn coefficients<R: Real>(moments: &[R], z_f: R) -> [R; MAX_POINTS] {
    let n = moments.len() / 2 + 1;
    let entry = |i: usize, j: usize| if i + j == 0 { R::one() } else { moments[i + j - 1] };
    let mut lower = [[R::zero(); MAX_POINTS]; MAX_POINTS];
    let mut pivots = [R::one(); MAX_POINTS];
    let mut c = [R::zero(); MAX_POINTS];
    let mut power = R::one();
    for i in 0..n {
        for j in 0..i {
            let dot = (0..j).fold(entry(i, j), |sum, k| sum - lower[i][k] * lower[j][k] * pivots[k]);
            lower[i][j] = dot / pivots[j];
        }
        pivots[i] = (0..i).fold(entry(i, i), |sum, k| sum - lower[i][k] * lower[i][k] * pivots[k]);
        c[i] = (0..i).fold(power, |sum, k| sum - lower[i][k] * c[k]);
        power = power * z_f;
    }
    for i in (0..n).rev() {
        c[i] = (i + 1..n).fold(c[i] / pivots[i], |sum, k| sum - lower[k][i] * c[k]);
    }
    c
}

/// The two support points besides z_f, ascending.
fn two_roots<R: Real>(moments: &[R; 4], z_f: R) -> [R; 2] {
    let [c1, c2, c3, ..] = coefficients(moments, z_f);
    let half = R::from_f64(0.5) * c2 / c3;
    let root = (half * half - c1 / c3).sqrt();
    [-half - root, root - half]
}

/// Weight of the point `of` beside two others: E\[(z - first) (z - second)\] over its value at `of`.
fn weight<R: Real>(moments: &[R; 4], of: R, first: R, second: R) -> R {
    (first * second - (first + second) * moments[0] + moments[1]) / ((of - first) * (of - second))
}

fn from_roots<R: Real>(moments: &[R; 4], z_f: R, [z2, z3]: [R; 2]) -> R {
    if z_f <= z2 {
        R::zero()
    } else if z_f <= z3 {
        weight(moments, z2, z_f, z3)
    } else {
        R::one() - weight(moments, z_f, z2, z3)
    }
}

/// The lower bound from four power moments on the line: MSM15 Algorithm 3 without its bias.
///
/// `None` where it ends in no number.
pub fn hamburger4<R: Real>(moments: &[R; 4], z_f: R) -> Option<R> {
    let roots = two_roots(moments, z_f);
    // A comparison with NaN would choose a branch by accident.
    if !(roots[0].is_finite() && roots[1].is_finite()) {
        return None;
    }
    number(from_roots(moments, z_f, roots))
}

/// The lower bound from four power moments on \[0, 1\] (MSM15 section 4): as on the line if both roots lie inside, else
/// with support {0, z_f, t, 1}.
///
/// `None` where it ends in no number.
pub fn hausdorff4<R: Real>(moments: &[R; 4], z_f: R) -> Option<R> {
    let (zero, one) = (R::zero(), R::one());
    let roots = two_roots(moments, z_f);
    if !(roots[0].is_finite() && roots[1].is_finite()) {
        return None;
    }
    if zero <= roots[0] && roots[1] <= one {
        return number(from_roots(moments, z_f, roots));
    }
    // z (1 - z) (z - z_f) (z - t) vanishes on the support.
    let [b1, b2, b3, b4] = *moments;
    let t = ((b3 - b4) - z_f * (b2 - b3)) / ((b2 - b3) - z_f * (b1 - b2));
    let sum = z_f + t;
    let at_one = (b3 - sum * b2 + z_f * t * b1) / ((one - z_f) * (one - t));
    let at_z_f = ((b2 - b3) - t * (b1 - b2)) / (z_f * (one - z_f) * (z_f - t));
    if t < z_f {
        number(one - at_one - at_z_f)
    } else {
        number(((b2 - sum * b1 + z_f * t) - (b3 - sum * b2 + z_f * t * b1)) / (z_f * t))
    }
}

/// The lower bound from M = 2, 4, 6 or 8 power moments on the line: MSM15 Algorithm 2, roots in closed form.
///
/// `None` where it ends in no number.
pub fn hamburger<R: Real, const M: usize>(moments: &[R; M], z_f: R) -> Option<R> {
    const { assert!(M == 2 || M == 4 || M == 6 || M == 8) }
    match M {
        2 => return chebyshev(&[moments[0], moments[1]], z_f),
        4 => return hamburger4(&[moments[0], moments[1], moments[2], moments[3]], z_f),
        _ => {}
    }
    let count = M / 2;
    let c = coefficients(moments, z_f);
    let a = c.map(|coefficient| coefficient / c[count]);
    let mut support = [z_f; MAX_POINTS];
    if count == 3 {
        support[1..4].copy_from_slice(&roots::cubic(a[2], a[1], a[0]));
    } else {
        support[1..].copy_from_slice(&roots::quartic(a[3], a[2], a[1], a[0]));
    }
    let support = &support[..=count];
    if support.iter().any(|z| !z.is_finite()) {
        return None;
    }
    let mut sum = R::zero();
    for (i, &z) in support.iter().enumerate().filter(|(_, z)| **z < z_f) {
        // The polynomial that vanishes at all other points, and its expectation.
        let mut polynomial = [R::zero(); MAX_POINTS];
        polynomial[0] = R::one();
        let mut at_z = R::one();
        for (_, &other) in support.iter().enumerate().filter(|&(j, _)| j != i) {
            for k in (0..count + 1).rev() {
                let below = if k > 0 { polynomial[k - 1] } else { R::zero() };
                polynomial[k] = below - other * polynomial[k];
            }
            at_z = at_z * (z - other);
        }
        let expectation = (1..=count).fold(polynomial[0], |sum, k| sum + polynomial[k] * moments[k - 1]);
        sum = sum + expectation / at_z;
    }
    number(sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::DoubleDouble;
    use crate::closed_forms::{hamburger as ours, hausdorff};
    use proptest::prelude::*;

    fn moments<R: Real, const M: usize>(atoms: &[(f64, f64)]) -> [R; M] {
        let total: f64 = atoms.iter().map(|a| a.1).sum();
        std::array::from_fn(|k| {
            atoms.iter().fold(R::zero(), |sum, &(z, w)| {
                sum + R::from_f64(w / total) * R::from_f64(z).powi(k as i32 + 1)
            })
        })
    }

    proptest! {
        /// With more digits than the problem loses, the published and the rewritten form are the same function.
        #[test]
        fn the_published_form_is_the_same_function(
            atoms in prop::collection::vec((0.01..0.99f64, 0.1..1.0f64), 6..9),
            z_f in 0.02..0.98f64,
        ) {
            fn same(published: Option<DoubleDouble>, ours: DoubleDouble) -> Result<(), TestCaseError> {
                let published = published.unwrap().to_f64();
                prop_assert!((published - ours.to_f64()).abs() < 1e-8, "{published} {ours:?}");
                Ok(())
            }
            // Close depths cost digits that even double-double lacks.
            let mut sorted: Vec<f64> = atoms.iter().map(|a| a.0).collect();
            sorted.sort_by(f64::total_cmp);
            prop_assume!(sorted.windows(2).all(|w| w[1] - w[0] > 0.01));
            let z = DoubleDouble::from(z_f);
            same(hamburger(&moments::<_, 2>(&atoms), z), ours::hamburger(&moments::<_, 2>(&atoms), z).lower)?;
            same(hamburger(&moments::<_, 4>(&atoms), z), ours::hamburger(&moments::<_, 4>(&atoms), z).lower)?;
            same(hamburger(&moments::<_, 6>(&atoms), z), ours::hamburger(&moments::<_, 6>(&atoms), z).lower)?;
            same(hamburger(&moments::<_, 8>(&atoms), z), ours::hamburger(&moments::<_, 8>(&atoms), z).lower)?;
            same(hausdorff4(&moments::<_, 4>(&atoms), z), hausdorff::hausdorff4(&moments::<_, 4>(&atoms), z).lower)?;
        }
    }

    #[test]
    fn one_surface_has_no_number() {
        let b: [f32; 4] = moments(&[(0.5, 1.0)]);
        assert_eq!(hamburger4(&b, 0.75), None);
        assert_eq!(hamburger(&moments::<f32, 6>(&[(0.5, 1.0)]), 0.75), None);
        assert_eq!(ours::hamburger4(&b, 0.75).lower, 1.0);
    }
}
