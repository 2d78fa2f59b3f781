//! Power moments without rounding, on the line and on \[0, 1\]: for kernels that double-double does not resolve.
//!
//! Depths, weights, moments and z_f are binary fractions, so the moments s_k about z_f and all determinants of them are
//! computed exactly (the sign of a pivot is never a guess, and moving or scaling the depths changes nothing). The points
//! besides z_f are the roots of the polynomial R of degree n with E\[u R(u) q(u)\] = 0 for all q of lower degree,
//! u = z - z_f; its coefficients are minors of (s_(i+j+1)), and the weight at z_f is det (s_(i+j)) / det (s_(i+j+2)).
//! On \[0, 1\] that is the answer if all points lie inside; else, and for an odd number of moments, ends of the interval belong
//! to the points, and the same holds for the measure z dZ, (1 - z) dZ or z (1 - z) dZ, which does not see them.
//!
//! Roots are rounded to so many bits as the certificate needs: with Hermite's polynomials h_a (1 at the point u_a, 0 at z_f
//! and at the other points, there with slope 0 unless it is an end) the sum of E\[h_a\] over the points in front is a proved
//! lower bound for *any* points (see `hermite`), the same over those behind a proved bound of the mass behind, and what both
//! and the exact weight at z_f leave of the total mass is all that the bounds can be wrong by. Precision is doubled
//! until that is nothing.

mod equation;
mod solution;

use super::bounds::{Bounds, CERTIFIED_GAP, Interval};
use crate::arithmetic::{DoubleDouble, Dyadic};
use crate::basis::Basis;
use crate::distribution::DepthDistribution;
use crate::error::MomentError;
use equation::Equation;
use solution::Solution;

/// Bits of the roots to start with: pairs of surfaces 1e-15 apart are resolved.
const FIRST_PRECISION: u64 = 192;

/// Bits at which the search for a proof ends: six times the exponent range of doubles.
const LAST_PRECISION: u64 = 12_288;

/// What both bounds may be wrong by, as a binary exponent, before precision is doubled: a thousandth of the last place of 1.
const NO_ERROR: i64 = -63;

/// A point outside \[0, 1\] by less than this (a binary exponent) is an end that was found as a root.
const AT_END: i64 = -90;

/// Parts of the arcsine distribution that are mixed in, as binary exponents, to reach the set of moments from just outside:
/// from the rounding of double-double to a few roundings of doubles.
pub(super) const MIXTURES: [i64; 8] = [-102, -94, -86, -76, -66, -56, -51, -47];

/// Moments of the arcsine distribution on \[-1, 1\] of even order, times 128.
const ARCSINE: [i64; 5] = [128, 64, 48, 40, 35];

/// Both bounds of a known distribution for a basis of powers z, ..., z^M; `None` for any other.
pub(super) fn exact_of(
    basis: &Basis,
    interval: Interval,
    z: &DepthDistribution,
    z_f: f64,
) -> Option<Result<Bounds, MomentError>> {
    let order = basis.power_order()?;
    let exact = ExactPowers::of_atoms(z.depths(), z.weights(), order, z_f).bounds(interval);
    Some(exact.map(|bounds| bounds.containing(z, z_f)))
}

/// E\[u^k\], k = 0..M, times an unknown total mass near 1; u = z - z_f.
pub(super) struct ExactPowers {
    z_f: f64,
    moments: Vec<Dyadic>,
}

impl ExactPowers {
    /// The first `order` moments of finitely many depths.
    pub(super) fn of_atoms(depths: &[f64], weights: &[DoubleDouble], order: usize, z_f: f64) -> Self {
        let mut moments = vec![Dyadic::zero(); order + 1];
        for (&z, &w) in depths.iter().zip(weights) {
            let u = &Dyadic::from(z) - &Dyadic::from(z_f);
            let mut term = Dyadic::from(w);
            for moment in &mut moments {
                *moment = &*moment + &term;
                term = &term * &u;
            }
        }
        Self { z_f, moments }
    }

    /// E\[z\], E\[z^2\], ... as they are.
    pub(super) fn of_moments(moments: &[DoubleDouble], z_f: f64) -> Self {
        let raw = std::iter::once(Dyadic::one()).chain(moments.iter().map(|&b| Dyadic::from(b)));
        Self::about(raw.collect(), z_f)
    }

    /// The same with the part 2^`exponent` of an arcsine distribution about 0, as wide as the moments are; at most eight.
    pub(super) fn of_mixture(moments: &[DoubleDouble], z_f: f64, exponent: i64) -> Self {
        let raw: Vec<Dyadic> = moments.iter().map(|&b| Dyadic::from(b)).collect();
        let width = |k: usize| raw[k - 1].magnitude().div_euclid(k as i64) + 1;
        let even = (2..=raw.len()).step_by(2).filter(|k| !raw[k - 1].is_zero());
        let width = even.map(width).max().unwrap_or(0);
        let rest = &Dyadic::one() - &Dyadic::power_of_two(exponent);
        let mixed = raw.iter().enumerate().map(|(i, b)| {
            let k = i + 1;
            let other = if k % 2 == 0 { Dyadic::integer(ARCSINE[k / 2]) } else { Dyadic::zero() };
            &(&rest * b) + &other.shifted(exponent - 7 + width * k as i64)
        });
        Self::about(std::iter::once(Dyadic::one()).chain(mixed).collect(), z_f)
    }

    /// Moments about z_f from those about 0, by repeated s_j <- s_j - z_f s_(j-1).
    fn about(mut moments: Vec<Dyadic>, z_f: f64) -> Self {
        let z = Dyadic::from(z_f);
        for k in 1..moments.len() {
            for j in (k..moments.len()).rev() {
                moments[j] = &moments[j] - &(&z * &moments[j - 1]);
            }
        }
        Self { z_f, moments }
    }

    /// Both bounds, proved. On the line the number of moments is even.
    ///
    /// # Errors
    /// [`MomentError::NotPositiveDefinite`] or [`MomentError::Infeasible`] where no distribution has exactly these moments,
    /// [`MomentError::Uncertified`] where the last precision does not suffice.
    pub(super) fn bounds(&self, interval: Interval) -> Result<Bounds, MomentError> {
        let (zero, one) = (-&Dyadic::from(self.z_f), &Dyadic::one() - &Dyadic::from(self.z_f));
        let is_even = self.moments.len() % 2 == 1;
        let choices: Vec<Vec<Dyadic>> = match interval {
            Interval::Real => vec![Vec::new()],
            Interval::Unit if is_even => vec![Vec::new(), vec![zero.clone(), one.clone()]],
            Interval::Unit => vec![vec![zero.clone()], vec![one.clone()]],
        };
        let inside = |points: &[Dyadic]| {
            let outside =
                |u: &Dyadic| [&zero - u, u - &one].iter().any(|d| d.is_positive() && d.magnitude() > AT_END);
            interval == Interval::Real || !points.iter().any(outside)
        };
        let mut failure = MomentError::Infeasible { residual: f64::NAN };
        // An end that is z_f itself takes no part.
        for ends in choices.into_iter().filter(|ends| !ends.iter().any(Dyadic::is_zero)) {
            match self.with_ends(&ends, &inside) {
                Ok(Some(solution)) => return Ok(solution.into_bounds(self.z_f)),
                Ok(None) => {}
                Err(error) => failure = error,
            }
        }
        Err(failure)
    }

    /// The solution whose points are z_f, these ends and others; `None` where such points lie outside or have negative weights.
    fn with_ends(
        &self,
        ends: &[Dyadic],
        inside: &impl Fn(&[Dyadic]) -> bool,
    ) -> Result<Option<Solution>, MomentError> {
        // Times |u - e| for each end e: negative moments for an end behind.
        let mut reduced = self.moments.clone();
        let mut at_z_f = Dyadic::one();
        for end in ends {
            let sign = |value: Dyadic| if end.is_positive() { -&value } else { value };
            reduced = reduced.windows(2).map(|s| sign(&s[1] - &(end * &s[0]))).collect();
            at_z_f = sign(-&(&at_z_f * end));
        }
        let mut equation = Equation::of(&reduced)?;
        equation.at_z_f.1 = &equation.at_z_f.1 * &at_z_f;
        let mut precision = FIRST_PRECISION;
        let mut gap = f64::INFINITY;
        while precision <= LAST_PRECISION {
            if let Some(mut points) = equation.points(precision) {
                if !inside(&points) {
                    return Ok(None);
                }
                points.retain(|u| !ends.contains(u));
                let solution = Solution::new(&self.moments, &equation.at_z_f, points, ends, precision);
                let missing = &solution.missing;
                gap = missing.to_f64();
                let is_last = 2 * precision > LAST_PRECISION && gap <= CERTIFIED_GAP;
                if missing.is_zero() || missing.magnitude() <= NO_ERROR || is_last {
                    return Ok(solution.is_distribution().then_some(solution));
                }
            }
            precision *= 2;
        }
        Err(MomentError::Uncertified { gap })
    }
}
