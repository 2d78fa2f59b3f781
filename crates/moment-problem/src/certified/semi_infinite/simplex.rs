//! Primal simplex method in double-double over finitely many depths, with columns added where the dual function
//! exceeds the step: a linear program over the whole interval, not over a grid.

use super::certificate::{SEARCH_TOLERANCE, Step};
use super::finite::{ARTIFICIAL_COSTS, ARTIFICIAL_RESIDUAL, Column, FiniteProgram, Turned};
use super::prepared::{FEASIBILITY_TOLERANCE, PreparedBasis};
use crate::arithmetic::{DoubleDouble, Real};
use crate::certified::bounds::CERTIFIED_GAP;
use crate::dense::dot;
use crate::error::MomentError;

/// A higher cost that leaves more than this share of the residual has met moments outside the set of moments (by
/// rounding, say): what is left is their distance to it, and still higher costs would only spoil the dual.
const STALLED: f64 = 0.9;

/// Exchanges: convergence is quadratic near the solution; more means that something is wrong.
const MAX_EXCHANGES: usize = 60;

/// Evaluations of functions with derivatives that all searches of one program may take, at one to two microseconds each: more
/// than any certified answer needed, and a fraction of a second.
const MAX_EVALUATIONS: usize = 400_000;

/// Cells of the uniform grid that the exchange starts from: coarse, since the exchange adds what is missing.
pub(crate) const START_CELLS: usize = 64;

/// Optimal vertex of one program.
pub(crate) struct Solution {
    /// y over the orthonormal rows.
    pub dual: Vec<DoubleDouble>,
    /// Objective value of the primal solution (without artificial costs).
    pub primal_value: f64,
    /// y . b minus the proved excess: a bound whatever happened before.
    pub proved: f64,
    /// Proved excess of the dual function over the step.
    pub excess: f64,
    /// Depths with weights.
    pub support: Vec<(f64, f64)>,
}

/// Whether moments are known to belong to a distribution, in which case bounds are proved for them as they are, or may have
/// been rounded out of the set of moments, in which case they are projected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    Distribution,
    Numbers,
}

impl Origin {
    /// Of moments for which these depths of their distribution are known.
    pub(crate) fn of(depths: &[f64]) -> Self {
        if depths.is_empty() { Self::Numbers } else { Self::Distribution }
    }
}

/// Minimises E\[p\] over distributions on \[0, 1\] with the moments `right_hand_side` (orthonormal coordinates).
///
/// `extra` are depths to start from besides the uniform grid and z_f, such as the kernel's own.
pub(crate) fn minimise(
    prepared: &PreparedBasis,
    right_hand_side: &[DoubleDouble],
    origin: Origin,
    step: Step,
    extra: &[f64],
) -> Result<Solution, MomentError> {
    Program::new(prepared, (right_hand_side, origin), step, START_CELLS, extra).solve()
}

/// A linear program over the depths collected so far.
pub(crate) struct Program<'a> {
    prepared: &'a PreparedBasis,
    step: Step,
    origin: Origin,
    finite: FiniteProgram,
    evaluations: usize,
}

impl<'a> Program<'a> {
    /// Starts from the ends of `cells` equal cells, the `extra` depths and z_f.
    pub(crate) fn new(
        prepared: &'a PreparedBasis,
        (target, origin): (&[DoubleDouble], Origin),
        step: Step,
        cells: usize,
        extra: &[f64],
    ) -> Self {
        let mut depths: Vec<f64> = (0..=cells).map(|i| i as f64 / cells as f64).collect();
        depths.extend_from_slice(extra);
        depths.push(step.z_f());
        depths.sort_by(f64::total_cmp);
        depths.dedup();
        let columns = depths.iter().map(|&z| column(prepared, step, z)).collect();
        Self { prepared, step, origin, finite: FiniteProgram::new(target, columns), evaluations: 0 }
    }

    /// Columns without the artificial ones.
    pub(crate) fn columns(&self) -> &[Column] {
        self.finite.columns()
    }

    /// The program over the present depths in coordinates of its optimal basis.
    pub(crate) fn in_present_basis(&self) -> Result<Turned, MomentError> {
        self.finite.in_present_basis()
    }

    /// Optimum over the present depths: its dual y over the orthonormal rows and its value y . b.
    pub(crate) fn finite_optimum(&mut self) -> Result<(Vec<DoubleDouble>, f64), MomentError> {
        self.finite.optimum()
    }

    /// Exchanges until the dual function stays below the step on all of \[0, 1\], and certifies the result.
    pub(crate) fn solve(mut self) -> Result<Solution, MomentError> {
        self.exchange()?;
        self.finish()
    }

    /// Adds columns where the dual function exceeds the step until there are none; returns y . b.
    pub(crate) fn exchange(&mut self) -> Result<f64, MomentError> {
        let mut before = f64::INFINITY;
        for cost in ARTIFICIAL_COSTS {
            self.finite.set_artificial_cost(cost);
            self.exchange_at_present_cost()?;
            let residual = self.finite.vertex()?.residual;
            let is_spent = self.evaluations > MAX_EVALUATIONS;
            if residual <= ARTIFICIAL_RESIDUAL || residual > STALLED * before || is_spent {
                break;
            }
            before = residual;
        }
        Ok(self.finite_optimum()?.1)
    }

    fn exchange_at_present_cost(&mut self) -> Result<(), MomentError> {
        for _ in 0..MAX_EXCHANGES {
            self.finite.optimise()?;
            let vertex = self.finite.vertex()?;
            if vertex.residual <= FEASIBILITY_TOLERANCE && vertex.is_zero() {
                break; // nothing is smaller, so nothing has to be proved
            }
            let (violations, examined) = self.prepared.violations(&vertex.dual, self.step, SEARCH_TOLERANCE);
            self.evaluations += examined * self.prepared.basis().len();
            if violations.is_empty()
                || self.evaluations > MAX_EVALUATIONS
                || !self.add_columns(violations.into_iter())
            {
                break;
            }
        }
        Ok(())
    }

    /// Adds columns for new depths; false if all were there.
    fn add_columns(&mut self, depths: impl Iterator<Item = f64>) -> bool {
        let before = self.finite.columns().len();
        for z in depths {
            if !self.finite.columns().iter().any(|column| column.z == z) {
                self.finite.push(column(self.prepared, self.step, z));
            }
        }
        self.finite.columns().len() > before
    }

    /// The present vertex with its proof.
    pub(crate) fn finish(&self) -> Result<Solution, MomentError> {
        let mut vertex = self.finite.vertex()?;
        let residual = vertex.residual;
        if residual.is_nan() || residual > FEASIBILITY_TOLERANCE {
            return Err(MomentError::Infeasible { residual });
        }
        // Depths so close that the perturbation alone made their weights positive: the vertex attains nothing.
        let negative = vertex.support.iter().map(|&(_, weight)| -weight).fold(0.0, f64::max);
        if negative > CERTIFIED_GAP {
            return Err(MomentError::Uncertified { gap: negative });
        }
        if vertex.is_zero() {
            vertex.dual.fill(DoubleDouble::zero());
        }
        let (y, attained) = (vertex.dual, vertex.attained);
        let target = if self.origin == Origin::Distribution { self.finite.target() } else { &attained };
        let dual_value = dot(&y, target).to_f64();
        let value = vertex.value.to_f64();
        // Nothing is below 0 at any excess; else the gap is at least the excess but for what the values differ by.
        let lead = dual_value - value;
        let hopeless = if value > CERTIFIED_GAP { lead + CERTIFIED_GAP } else { f64::INFINITY };
        let excess = self.prepared.excess(&y, self.step, hopeless);
        let excess =
            excess.map_err(|attained| MomentError::Uncertified { gap: value.min(attained - lead) })?;
        let excess = excess.max(0.0);
        let rounding: f64 = y.iter().zip(target).map(|(y, b)| (y.to_f64() * b.to_f64()).abs()).sum();
        let proved = dual_value - excess - rounding * 1e-28 - f64::EPSILON;
        Ok(Solution { dual: y, primal_value: value, proved, excess, support: vertex.support })
    }
}

fn column(prepared: &PreparedBasis, step: Step, z: f64) -> Column {
    Column { z, entries: prepared.column(z), cost: step.at(z) }
}
