//! The points in front of z_f of the distribution that attains the lower bound.
//!
//! A blocker search takes it for the true one and averages the depths in front of the receiver (BHS16 section 3.3;
//! for two moments this is the average of Yang et al., *Variance Soft Shadow Mapping*, 2010, with the unblocked
//! depth at z_f). On the line points may lie outside \[0, 1\]; one at infinity has weight 0 and is left out.

use super::canonical::canonical;
use super::hamburger::{Solution4, ThreePoints, front_weight, solve4};
use super::hausdorff::{four_points, is_inside};
use super::roots;
use crate::arithmetic::Real;

/// Most points in front: m = 8 moments have five, z_f among them.
const MOST: usize = 4;

/// Depths and weights in front of z_f. The weights are not negative and sum to the lower bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InFront<R> {
    points: [(R, R); MOST],
    count: usize,
}

impl<R: Real> InFront<R> {
    fn nothing() -> Self {
        Self { points: [(R::zero(), R::zero()); MOST], count: 0 }
    }

    fn push(&mut self, depth: R, weight: R) {
        // A weight below is rounding, and its depth may be infinite; comparisons with NaN are false.
        if weight > R::from_f64(R::TINY) && depth.is_finite() {
            self.points[self.count] = (depth, weight.min(R::one()));
            self.count += 1;
        }
    }

    /// Depth and weight of each point.
    pub fn points(&self) -> &[(R, R)] {
        &self.points[..self.count]
    }

    /// The lower bound.
    pub fn mass(&self) -> R {
        self.points().iter().fold(R::zero(), |sum, &(_, weight)| sum + weight).min(R::one())
    }
}

/// From mean and second moment: one point.
pub(super) fn chebyshev<R: Real>(moments: &[R; 2], z_f: R) -> InFront<R> {
    let [b1, b2] = *moments;
    let mut found = InFront::nothing();
    let offset = z_f - b1;
    if offset > R::zero() {
        let variance = (b2 - b1 * b1).abs();
        let square = offset * offset;
        let sum = variance + square;
        let weight = if sum > R::zero() { square / sum } else { R::one() };
        found.push(b1 - variance / offset, weight);
    }
    found
}

/// From M = 2, 4, 6 or 8 power moments on the line.
pub(super) fn hamburger<R: Real, const M: usize>(moments: &[R; M], z_f: R) -> InFront<R> {
    match M {
        2 => chebyshev(&[moments[0], moments[1]], z_f),
        4 => match solve4(&[moments[0], moments[1], moments[2], moments[3]], z_f) {
            Solution4::Regular(points) => three_points(&points, z_f),
            Solution4::Degenerate(pair) => degenerate(pair.lower, moments[0], moments[1], z_f),
        },
        _ => {
            let solution = canonical(moments, z_f);
            let lower = solution.bounds().lower;
            let mut found = InFront::nothing();
            let has_mass = lower > R::from_f64(R::TINY);
            if !has_mass {
                return found;
            }
            let mut push = |w: R| {
                if w < R::zero() {
                    found.push(z_f + R::one() / w, solution.christoffel(w));
                }
            };
            if solution.singular.is_some() {
                // Few surfaces, which the moments determine: the roots of their polynomial. One that is z_f up to the
                // root of a rounding is no blocker.
                let least = R::from_f64(64.0 * R::EPSILON.sqrt());
                let [c0, c1, c2, c3, _] = solution.taylor[solution.count];
                let offsets = match solution.count {
                    1 => [-c0, R::zero(), R::zero(), R::zero()],
                    2 => pad(roots::quadratic(c1, c0)),
                    3 => pad(roots::cubic(c2, c1, c0)),
                    _ => roots::quartic(c3, c2, c1, c0),
                };
                offsets
                    .into_iter()
                    .filter(|&offset| offset < -least)
                    .for_each(|offset| push(R::one() / offset));
            } else {
                solution.inverse_offsets[..solution.count].iter().for_each(|&w| push(w));
            }
            let mass = found.points().iter().fold(R::zero(), |sum, &(_, weight)| sum + weight);
            if mass > R::zero() {
                found.points[..found.count].iter_mut().for_each(|(_, w)| *w = *w * (lower / mass));
            } else {
                found.push(z_f, lower);
            }
            found
        }
    }
}

fn pad<R: Real, const N: usize>(roots: [R; N]) -> [R; MOST] {
    std::array::from_fn(|i| if i < N { roots[i] } else { R::zero() })
}

/// From four power moments on \[0, 1\].
pub(super) fn hausdorff4<R: Real>(moments: &[R; 4], z_f: R) -> InFront<R> {
    match solve4(moments, z_f) {
        Solution4::Degenerate(pair) => degenerate(pair.lower, moments[0], moments[1], z_f),
        Solution4::Regular(points) if is_inside(&points.w, z_f) => three_points(&points, z_f),
        Solution4::Regular(_) => {
            let points = four_points(moments, z_f);
            let lower = points.bounds(z_f).lower;
            let at_zero = points.at_zero.clamp_unit().min(lower);
            let mut found = InFront::nothing();
            found.push(R::zero(), at_zero);
            if points.free < z_f {
                found.push(points.free, lower - at_zero);
            }
            found
        }
    }
}

/// At most two surfaces of which two moments tell all, or no answer, for which the bound is 0.
fn degenerate<R: Real>(lower: R, b1: R, b2: R, z_f: R) -> InFront<R> {
    if lower > R::zero() { chebyshev(&[b1, b2], z_f) } else { InFront::nothing() }
}

fn three_points<R: Real>(points: &ThreePoints<R>, z_f: R) -> InFront<R> {
    let one = R::one();
    let [w1, w2] = points.w;
    let lower = points.bounds().lower;
    let mut found = InFront::nothing();
    if w1 < R::zero() {
        let apart = w2 < R::zero() && w1 < w2;
        // Of two in front the second takes the rest, so that the sum is right even where they nearly coincide.
        let first = if apart {
            front_weight(w1, w2, points.s[0], points.s[1]).max(R::zero()).min(lower)
        } else {
            lower
        };
        found.push(z_f + one / w1, first);
        if apart {
            found.push(z_f + one / w2, lower - first);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{hamburger as bounds, hausdorff};
    use proptest::prelude::*;

    fn moments<const M: usize>(atoms: &[(f64, f64)]) -> [f64; M] {
        let total: f64 = atoms.iter().map(|a| a.1).sum();
        std::array::from_fn(|k| atoms.iter().map(|&(z, w)| w / total * z.powi(k as i32 + 1)).sum())
    }

    /// Weight and first moment in front of z_f.
    fn front(points: impl IntoIterator<Item = (f64, f64)>, z_f: f64) -> [f64; 2] {
        let before = points.into_iter().filter(|p| p.0 < z_f);
        before.fold([0.0; 2], |[mass, moment], (z, w)| [mass + w, moment + w * z])
    }

    proptest! {
        /// Up to m / 2 surfaces, and one more if z_f lies on it, are reconstructed.
        #[test]
        fn few_surfaces_are_found(
            atoms in prop::collection::vec((0.05..0.95f64, 0.2..1.0f64), 3),
            z_f in 0.0..1.0f64,
        ) {
            let separate = |depths: &[f64]| {
                let mut sorted = depths.to_vec();
                sorted.sort_by(f64::total_cmp);
                sorted.windows(2).all(|w| w[1] - w[0] > 0.05)
            };
            prop_assume!(separate(&[atoms[0].0, atoms[1].0, atoms[2].0, z_f]));
            let check = |found: InFront<f64>, atoms: &[(f64, f64)], z_f: f64, tolerance: f64| {
                let total: f64 = atoms.iter().map(|a| a.1).sum();
                let [mass, moment] = front(atoms.iter().map(|&(z, w)| (z, w / total)), z_f);
                let [got, got_moment] = front(found.points().iter().copied(), z_f);
                prop_assert!((mass - got).abs() < tolerance, "{mass} {found:?}");
                prop_assert!((moment - got_moment).abs() < tolerance, "{moment} {found:?}");
                Ok(())
            };
            let on = atoms[2].0;
            check(chebyshev(&moments(&atoms[..1]), z_f), &atoms[..1], z_f, 1e-9)?;
            check(chebyshev(&moments(&atoms[1..]), on), &atoms[1..], on, 1e-9)?;
            check(hamburger::<_, 4>(&moments(&atoms[..2]), z_f), &atoms[..2], z_f, 1e-7)?;
            check(hamburger::<_, 4>(&moments(&atoms), on), &atoms, on, 1e-7)?;
            check(hausdorff4(&moments(&atoms), on), &atoms, on, 1e-7)?;
            check(hamburger::<_, 6>(&moments(&atoms), z_f), &atoms, z_f, 1e-4)?;
        }

        /// The weights are the lower bound, and all points lie in front.
        #[test]
        fn weights_sum_to_the_bound(
            atoms in prop::collection::vec((0.0..1.0f64, 0.01..1.0f64), 1..7),
            z_f in 0.0..1.0f64,
        ) {
            let (b2, b4, b6) = (moments::<2>(&atoms), moments::<4>(&atoms), moments::<6>(&atoms));
            for (found, lower) in [
                (chebyshev(&b2, z_f), bounds::chebyshev(&b2, z_f).lower),
                (hamburger(&b4, z_f), bounds::hamburger4(&b4, z_f).lower),
                (hausdorff4(&b4, z_f), hausdorff::hausdorff4(&b4, z_f).lower),
                (hamburger(&b6, z_f), bounds::hamburger(&b6, z_f).lower),
            ] {
                prop_assert!((found.mass() - lower).abs() < 1e-12, "{lower} {found:?}");
                prop_assert!(found.points().iter().all(|p| p.0 <= z_f && p.1 > 0.0), "{found:?}");
            }
        }
    }

    #[test]
    fn single_surfaces_and_empty_fronts() {
        let b = moments::<4>(&[(0.5, 1.0)]);
        assert_eq!(hamburger(&b, 0.75).points(), [(0.5, 1.0)]);
        assert_eq!(hamburger(&b, 0.5).points(), []);
        assert_eq!(hausdorff4(&b, 0.25).mass(), 0.0);
        assert_eq!(hamburger::<f64, 4>(&[f64::NAN; 4], 0.5).points(), []);
    }
}
