//! Power moments on the whole line with their proof: double-double where it resolves the kernel, else exact arithmetic.

use super::bounds::{
    Bounds, CERTIFIED_GAP, Certificate, Interval, LowerBound, check_depths, check_input, sorted_support,
};
use super::exact::{ExactPowers, MIXTURES, exact_of};
use super::hermite;
use crate::arithmetic::{DoubleDouble, Real};
use crate::basis::Basis;
use crate::closed_forms::canonical::canonical;
use crate::distribution::DepthDistribution;
use crate::error::MomentError;

/// Moments rounded to double precision may make a pivot of the moment matrix negative by this many units of the
/// moment it is computed from; more means that no distribution has them.
const PIVOT_NOISE: f64 = 1e-14;

/// Roundings of double-double that the weight at z_f goes through, relative to its sensitivity: factorisation,
/// polynomials and their sum, with room.
const DOUBLE_DOUBLE_ROUNDINGS: f64 = 64.0;

/// Relative error of the weight at z_f up to which its sensitivity, which is computed with it, means anything.
const LARGEST_RELATIVE_ERROR: f64 = 1e-2;

/// Answers of double-double are taken up to a tenth of the gap that is accepted.
const QUICK_GAP: f64 = 0.1 * CERTIFIED_GAP;

/// Support points with less weight than this are left out of dual polynomials: they run to infinity.
const NODE_WEIGHT: f64 = 1e-26;

/// Points this close to z_f (relative to 1 + |z_f|) are z_f: doubles cannot tell them apart.
const SAME_DEPTH: f64 = 1e-18;

/// Power moments z, ..., z^M on the whole line, M = 2, 4, 6 or 8 (MSM15 Algorithm 2).
#[derive(Clone, Debug)]
pub struct Hamburger<const M: usize> {
    basis: Basis,
}

/// Mean and second moment on the whole line: variance shadow maps (Cantelli's inequality).
pub type Chebyshev = Hamburger<2>;

impl<const M: usize> Default for Hamburger<M> {
    fn default() -> Self {
        const { assert!(M == 2 || M == 4 || M == 6 || M == 8) }
        Self { basis: Basis::power(M) }
    }
}

impl<const M: usize> Hamburger<M> {
    /// The bounds if double-double resolves and proves them.
    fn in_double_double(moments: &[DoubleDouble], z_f: f64) -> Option<Bounds> {
        let array: [DoubleDouble; M] = std::array::from_fn(|i| moments[i]);
        let solution = canonical(&array, DoubleDouble::from(z_f));
        if solution.singular.is_some() {
            return None;
        }
        let at_z_f = solution.at_z_f.to_f64();
        let relative = DOUBLE_DOUBLE_ROUNDINGS * DoubleDouble::EPSILON * solution.sensitivity(&array, z_f);
        if relative.is_nan() || relative > LARGEST_RELATIVE_ERROR || relative * at_z_f > QUICK_GAP {
            return None;
        }
        let points = solution.points(DoubleDouble::from(z_f));
        let others: Vec<(DoubleDouble, f64)> = points[1..].iter().map(|&(z, w)| (z, w.to_f64())).collect();
        Self::proved(z_f, at_z_f, &others, moments)
    }

    /// The bounds of at most M / 2 depths, which their moments determine (MSM15 Proposition 4): the depths themselves are the
    /// support, if double-double proves it.
    fn determined(z: &DepthDistribution, moments: &[DoubleDouble], z_f: f64) -> Option<Bounds> {
        let atoms = || z.depths().iter().zip(z.weights());
        let at_z_f = atoms().filter(|&(&depth, _)| depth == z_f).map(|(_, w)| w.to_f64()).sum();
        let others = atoms().filter(|&(&depth, _)| depth != z_f);
        let others: Vec<(DoubleDouble, f64)> =
            others.map(|(&depth, w)| (DoubleDouble::from(depth), w.to_f64())).collect();
        Self::proved(z_f, at_z_f, &others, moments)
    }

    /// [`Self::assemble`], if what is proved is sharp enough.
    fn proved(
        z_f: f64,
        at_z_f: f64,
        others: &[(DoubleDouble, f64)],
        moments: &[DoubleDouble],
    ) -> Option<Bounds> {
        let bounds = Self::assemble(z_f, at_z_f, others, moments);
        // Front, z_f and behind share the mass 1: what the proofs of the outer two and the weight at z_f leave of it is all
        // that either bound can be wrong by.
        let certificate = &bounds.certificate;
        let missing = certificate.upper_proved - certificate.lower_proved - at_z_f;
        let is_proved = missing.abs() <= QUICK_GAP && bounds.gap() <= QUICK_GAP;
        let is_consistent = (bounds.upper - bounds.lower - at_z_f).abs() <= QUICK_GAP;
        (is_proved && is_consistent).then_some(bounds)
    }

    /// Bounds for moments that rounding has put just outside the set of moments: those of the nearest that exist, if it makes
    /// no difference how they are brought inside.
    fn from_outside(moments: &[DoubleDouble], z_f: f64) -> Result<Bounds, MomentError> {
        let mut answers = Vec::new();
        let mut failure = MomentError::Uncertified { gap: f64::INFINITY };
        for exponent in MIXTURES {
            match ExactPowers::of_mixture(moments, z_f, exponent).bounds(Interval::Real) {
                Ok(bounds) => answers.push(bounds),
                Err(error) => failure = error,
            }
            if let [first, second] = &answers[..] {
                let difference = (first.lower - second.lower).abs().max((first.upper - second.upper).abs());
                let mut bounds = first.clone();
                let (proved, other) = (&mut bounds.certificate, &second.certificate);
                proved.lower_proved = proved.lower_proved.min(other.lower_proved).min(bounds.lower);
                proved.upper_proved = proved.upper_proved.max(other.upper_proved).max(bounds.upper);
                let gap = difference.max(bounds.gap());
                return if gap <= CERTIFIED_GAP { Ok(bounds) } else { Err(MomentError::Uncertified { gap }) };
            }
        }
        Err(failure)
    }

    /// Bounds from a support whose points besides z_f are `others`, as (depth, weight).
    fn assemble(z_f: f64, at_z_f: f64, others: &[(DoubleDouble, f64)], moments: &[DoubleDouble]) -> Bounds {
        let fragment = DoubleDouble::from(z_f);
        let near = |z: DoubleDouble| (z - fragment).abs().to_f64() <= SAME_DEPTH * (1.0 + z_f.abs());
        let at_z_f = at_z_f + others.iter().filter(|&&(z, _)| near(z)).map(|&(_, w)| w).sum::<f64>();
        let kept = || others.iter().filter(|&&(z, w)| w > NODE_WEIGHT && !near(z));
        let nodes: Vec<DoubleDouble> = kept().map(|&(z, _)| z).collect();
        let lower = hermite::dual(fragment, &nodes, moments, |z| z < fragment);
        let upper = hermite::dual(fragment, &nodes, moments, |z| z > fragment);
        let front = kept().filter(|&&(z, _)| z < fragment).map(|&(_, w)| w).sum::<f64>();
        let behind = kept().filter(|&&(z, _)| z > fragment).map(|&(_, w)| w).sum::<f64>();
        // Of two ways to sum the same weights, the one with fewer large terms is the more accurate.
        let attained_lower = if front < 0.5 { front } else { 1.0 - at_z_f - behind };
        let attained_upper = if behind < 0.5 { 1.0 - behind } else { front + at_z_f };
        let points = kept().map(|&(z, w)| (z.to_f64(), w)).chain([(z_f, at_z_f)]);
        let (support, weights) = sorted_support(points, NODE_WEIGHT);
        Bounds {
            lower: attained_lower.clamp(0.0, 1.0),
            upper: attained_upper.clamp(0.0, 1.0),
            support,
            weights,
            certificate: Certificate {
                lower_dual: lower.coefficients,
                upper_dual: upper.coefficients,
                worst_slack: 0.0,
                lower_proved: lower.proved,
                upper_proved: (1.0 - upper.proved).min(1.0),
            },
        }
    }
}

impl<const M: usize> LowerBound for Hamburger<M> {
    fn name(&self) -> &'static str {
        ["Chebyshev", "Hamburger 4", "Hamburger 6", "Hamburger 8"][M / 2 - 1]
    }

    fn basis(&self) -> &Basis {
        &self.basis
    }

    fn interval(&self) -> Interval {
        Interval::Real
    }

    fn bounds_near(
        &self,
        moments: &[DoubleDouble],
        z_f: f64,
        _depths: &[f64],
    ) -> Result<Bounds, MomentError> {
        check_input(&self.basis, Interval::Real, moments, z_f)?;
        if let Some(bounds) = Self::in_double_double(moments, z_f) {
            return Ok(bounds);
        }
        match ExactPowers::of_moments(moments, z_f).bounds(Interval::Real) {
            Err(MomentError::NotPositiveDefinite { index, pivot }) => {
                let scale = moments[2 * index.max(2) - 3].to_f64().abs();
                if pivot < -PIVOT_NOISE * scale {
                    return Err(MomentError::NotPositiveDefinite { index, pivot });
                }
                Self::from_outside(moments, z_f)
            }
            result => result,
        }
    }

    /// The answer depends on the moments alone, but those are taken from the depths without rounding where double-double
    /// does not resolve them, and no bound passes F, which it can by rounding only.
    fn bounds_of(&self, z: &DepthDistribution, z_f: f64) -> Result<Bounds, MomentError> {
        check_depths(z.depths(), Interval::Real)?;
        let moments: Vec<DoubleDouble> = z.moments(&self.basis);
        check_input(&self.basis, Interval::Real, &moments, z_f)?;
        // Of the moments of at most M / 2 depths double-double would meet a vanishing pivot.
        let quick = if z.depths().len() > M / 2 {
            Self::in_double_double(&moments, z_f)
        } else {
            Self::determined(z, &moments, z_f)
        };
        match quick {
            Some(bounds) => Ok(bounds.containing(z, z_f)),
            None => exact_of(&self.basis, Interval::Real, z, z_f)
                .unwrap_or(Err(MomentError::Uncertified { gap: f64::INFINITY })),
        }
    }
}
