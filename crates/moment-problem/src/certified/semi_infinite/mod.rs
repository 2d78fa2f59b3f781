//! Certified bounds for any basis on \[0, 1\]: a semi-infinite linear program solved by exchange.

mod certificate;
mod finite;
mod prepared;
mod simplex;

pub(crate) use certificate::Step;
pub(crate) use finite::{Column, FiniteProgram};
pub(crate) use prepared::PreparedBasis;
pub(crate) use simplex::{Origin, Program, Solution, minimise};

use super::exact::{ExactPowers, exact_of};
use crate::arithmetic::DoubleDouble;
use crate::basis::Basis;
use crate::certified::bounds::{
    Bounds, CERTIFIED_GAP, Certificate, Interval, LowerBound, UNIT_WEIGHT_TOLERANCE, check_depths,
    check_input, sorted_support,
};
use crate::distribution::DepthDistribution;
use crate::error::{BasisError, MomentError};

/// Power moments up to which the simplex in double-double is at its ease.
const MOST_POWERS: usize = 8;

/// The certified solver for any basis on \[0, 1\].
///
/// Solves MSM15 Problem 1 over the continuum: a simplex method in double-double on a growing set of depths, to which
/// every local maximum of the dual function above the step is added (Remez' exchange), until none is left. The final
/// dual function is then bounded rigorously (interval arithmetic with derivatives) over the whole interval.
#[derive(Clone, Debug)]
pub struct ExchangeSimplex {
    prepared: PreparedBasis,
}

impl ExchangeSimplex {
    /// Prepares the basis (some milliseconds; reuse it for many moment vectors).
    pub fn new(basis: &Basis) -> Result<Self, BasisError> {
        Ok(Self { prepared: PreparedBasis::new(basis)? })
    }
}

/// Both bounds for checked input.
pub(crate) fn solve_prepared(
    prepared: &PreparedBasis,
    (moments, origin): (&[DoubleDouble], Origin),
    z_f: f64,
    extra: &[f64],
) -> Result<Bounds, MomentError> {
    let target = prepared.right_hand_side(moments)?;
    let lower = minimise(prepared, &target, origin, Step::Lower { z_f }, extra)?;
    let upper = minimise(prepared, &target, origin, Step::Upper { z_f }, extra)?;
    assemble(prepared, &lower, &upper).certified(CERTIFIED_GAP)
}

/// Bounds from the solutions of the two programs.
pub(crate) fn assemble(prepared: &PreparedBasis, lower: &Solution, upper: &Solution) -> Bounds {
    let coefficients = |y: &[DoubleDouble]| prepared.coefficients(y).iter().map(|c| c.to_f64()).collect();
    let (support, weights) = sorted_support(lower.support.iter().copied(), UNIT_WEIGHT_TOLERANCE);
    Bounds {
        lower: lower.primal_value.clamp(0.0, 1.0),
        upper: (1.0 - upper.primal_value).clamp(0.0, 1.0),
        support,
        weights,
        certificate: Certificate {
            lower_dual: coefficients(&lower.dual),
            upper_dual: coefficients(&upper.dual),
            worst_slack: lower.excess.max(upper.excess),
            lower_proved: lower.proved.max(0.0),
            upper_proved: (1.0 - upper.proved).min(1.0),
        },
    }
}

impl LowerBound for ExchangeSimplex {
    fn name(&self) -> &'static str {
        "exchange simplex"
    }

    fn basis(&self) -> &Basis {
        self.prepared.basis()
    }

    fn bounds_near(&self, moments: &[DoubleDouble], z_f: f64, depths: &[f64]) -> Result<Bounds, MomentError> {
        check_input(self.basis(), Interval::Unit, moments, z_f)?;
        if depths.is_empty() && self.basis().power_order().is_some_and(|order| order > MOST_POWERS) {
            // Moments of no distribution are projected by the simplex.
            match ExactPowers::of_moments(moments, z_f).bounds(Interval::Unit) {
                Err(MomentError::Infeasible { .. } | MomentError::NotPositiveDefinite { .. }) => {}
                result => return result,
            }
        }
        solve_prepared(&self.prepared, (moments, Origin::of(depths)), z_f, depths)
    }

    fn bounds_of(&self, z: &DepthDistribution, z_f: f64) -> Result<Bounds, MomentError> {
        check_depths(z.depths(), Interval::Unit)?;
        let exact = || exact_of(self.basis(), Interval::Unit, z, z_f);
        let order = self.basis().power_order().unwrap_or(0);
        // Few depths are determined by their moments: a degenerate vertex for the simplex, nothing to exact arithmetic.
        let is_exact_first = (order > MOST_POWERS || 2 * z.depths().len() <= order) && z_f.is_finite();
        if let Some(result) = is_exact_first.then(exact).flatten() {
            return result;
        }
        let result = self.bounds_near(&z.moments(self.basis()), z_f, z.depths());
        result.or_else(|error| if error.is_unresolved() { exact().unwrap_or(Err(error)) } else { Err(error) })
    }
}
