//! MSM15 Algorithm 1 through good_lp, with every answer checked.

use super::bounds::{Bounds, CERTIFIED_GAP, Interval, LowerBound, check_input};
use super::semi_infinite::{Column, Origin, PreparedBasis, Program, Solution, Step, assemble};
use crate::arithmetic::DoubleDouble;
use crate::basis::Basis;
use crate::error::{BasisError, MomentError};
use good_lp::{
    Expression, ProblemVariables, ResolutionError, Solution as _, SolverModel, constraint, variable,
};

/// Cells of the uniform grid that joins the kernel's own depths and z_f in the support I of Algorithm 1.
const GRID_CELLS: usize = 256;

/// A solver's objective may exceed the certified optimum by this much. Both solvers stop at 1e-8 to 1e-9.
const OBJECTIVE_TOLERANCE: f64 = 1e-6;

/// A solver's weights may miss an equation (orthonormal rows) or be negative by this much.
const RESIDUAL_TOLERANCE: f64 = 1e-6;

/// The linear programming solvers behind good_lp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LpSolver {
    /// An interior-point method.
    Clarabel,
    /// A simplex method.
    Microlp,
    /// HiGHS, for comparison: simplex and interior-point methods in C++, which need cmake and libclang to be built.
    #[cfg(feature = "highs")]
    Highs,
}

impl LpSolver {
    /// Those that need no system library, in the order in which they are asked.
    pub const ALL: [Self; 2] = [Self::Clarabel, Self::Microlp];

    /// The solver's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clarabel => "clarabel",
            Self::Microlp => "microlp",
            #[cfg(feature = "highs")]
            Self::Highs => "HiGHS",
        }
    }
}

/// Sharp bounds for any basis on \[0, 1\] by linear programming (MSM15 Algorithm 1).
///
/// The support I is a uniform grid, the distribution's own depths and z_f: off-grid moments of few surfaces have no
/// representing distribution on a grid alone. Rows are orthonormalised. A solver's word is not taken: its weights are
/// put back into the equations, and its objective is compared with the value proved on I by a dual vector that was
/// computed independently. A solver that fails either test is replaced by the other; if both fail the result is an
/// error. The answer returned is then carried from I to all of \[0, 1\] by exchange, with the certificate of
/// [`ExchangeSimplex`](crate::ExchangeSimplex).
#[derive(Clone, Debug)]
pub struct LinearProgram {
    prepared: PreparedBasis,
    solvers: Vec<LpSolver>,
}

impl LinearProgram {
    /// Prepares the basis (some milliseconds; reuse it). Asks clarabel first, then microlp.
    pub fn new(basis: &Basis) -> Result<Self, BasisError> {
        Ok(Self { prepared: PreparedBasis::new(basis)?, solvers: LpSolver::ALL.to_vec() })
    }

    /// Uses one solver only: what it gets wrong becomes an error.
    pub fn with_solver(basis: &Basis, solver: LpSolver) -> Result<Self, BasisError> {
        Ok(Self { prepared: PreparedBasis::new(basis)?, solvers: vec![solver] })
    }

    fn step(
        &self,
        (target, origin): (&[DoubleDouble], Origin),
        step: Step,
        extra: &[f64],
    ) -> Result<Solution, MomentError> {
        let mut program = Program::new(&self.prepared, (target, origin), step, GRID_CELLS, extra);
        let (dual, optimum) = program.finite_optimum()?;
        let Err(first_error) = self.consult(program.columns(), target, &dual, optimum) else {
            return program.solve();
        };
        // Moments without known depths need not have a distribution on a grid. Ask again once the exchange has found
        // the depths; where the moments belong to no distribution at all, the exchange says so.
        let optimum = program.exchange()?;
        let solution = program.finish()?;
        if self.consult(program.columns(), target, &solution.dual, optimum).is_ok() {
            return Ok(solution);
        }
        // A last time with other rows: neighbouring depths make the orthonormal ones nearly dependent.
        let turned = program.in_present_basis()?;
        self.consult(&turned.columns, &turned.target, &turned.dual, optimum).map_err(|_| first_error)?;
        Ok(solution)
    }

    /// Asks the solvers in turn until the answer of one passes its check.
    fn consult(
        &self,
        columns: &[Column],
        target: &[DoubleDouble],
        dual: &[DoubleDouble],
        optimum: f64,
    ) -> Result<(), MomentError> {
        let right_hand_side: Vec<f64> = target.iter().map(|b| b.to_f64()).collect();
        let dual_size: f64 = dual.iter().map(|y| y.to_f64().abs()).sum();
        let mut result = Err(MomentError::Uncertified { gap: f64::INFINITY });
        for &solver in &self.solvers {
            let claim = ask(solver, columns, &right_hand_side);
            match claim.and_then(|claim| claim.check(optimum, dual_size)) {
                Ok(()) => return Ok(()),
                Err(error) => result = Err(error),
            }
        }
        result
    }
}

/// What a solver returned, after its weights were put back into the program.
pub(crate) struct Claim {
    pub(crate) objective: f64,
    /// Largest error of an equation.
    residual: f64,
    /// Most negative weight.
    negative: f64,
}

impl Claim {
    fn check(&self, optimum: f64, dual_size: f64) -> Result<(), MomentError> {
        let worst = self.residual.max(self.negative);
        if worst.is_nan() || worst > RESIDUAL_TOLERANCE {
            return Err(MomentError::Uncertified { gap: worst });
        }
        // Weights that miss the equations by r may undercut the optimum by |y| r, but by no more.
        let difference = self.objective - optimum;
        let admissible = -(OBJECTIVE_TOLERANCE + dual_size * worst)..=OBJECTIVE_TOLERANCE;
        if admissible.contains(&difference) {
            Ok(())
        } else {
            Err(MomentError::Uncertified { gap: difference })
        }
    }
}

/// Minimises sum p_j w_j subject to sum a_j w_j = b, w >= 0.
pub(crate) fn ask(
    solver: LpSolver,
    columns: &[Column],
    right_hand_side: &[f64],
) -> Result<Claim, MomentError> {
    let fail = |error: ResolutionError| MomentError::Solver {
        name: solver.name().to_owned(),
        message: error.to_string(),
    };
    let mut variables = ProblemVariables::new();
    let weights = variables.add_vector(variable().min(0.0), columns.len());
    let cost: Expression = columns.iter().zip(&weights).map(|(column, &w)| column.cost * w).sum();
    let rows: Vec<Expression> = (0..right_hand_side.len())
        .map(|i| columns.iter().zip(&weights).map(|(column, &w)| column.entries[i].to_f64() * w).sum())
        .collect();
    let constraints = rows.into_iter().zip(right_hand_side).map(|(row, &b)| constraint!(row == b));
    let problem = variables.minimise(cost);
    let values: Vec<f64> = match solver {
        LpSolver::Clarabel => {
            let solution = problem.using(good_lp::clarabel).with_all(constraints).solve().map_err(fail)?;
            weights.iter().map(|&w| solution.value(w)).collect()
        }
        LpSolver::Microlp => {
            let solution = problem.using(good_lp::microlp).with_all(constraints).solve().map_err(fail)?;
            weights.iter().map(|&w| solution.value(w)).collect()
        }
        #[cfg(feature = "highs")]
        LpSolver::Highs => {
            let solution = problem.using(good_lp::highs).with_all(constraints).solve().map_err(fail)?;
            weights.iter().map(|&w| solution.value(w)).collect()
        }
    };
    let mut claim = Claim { objective: 0.0, residual: 0.0, negative: 0.0 };
    let mut sums: Vec<f64> = right_hand_side.iter().map(|b| -b).collect();
    for (column, &w) in columns.iter().zip(&values) {
        claim.objective += column.cost * w;
        claim.negative = claim.negative.max(-w);
        for (sum, entry) in sums.iter_mut().zip(&column.entries) {
            *sum += entry.to_f64() * w;
        }
    }
    claim.residual =
        sums.iter().fold(0.0, |worst: f64, sum| if sum.is_nan() { f64::NAN } else { worst.max(sum.abs()) });
    Ok(claim)
}

impl LowerBound for LinearProgram {
    fn name(&self) -> &'static str {
        match self.solvers[..] {
            [LpSolver::Clarabel] => "linear program (clarabel)",
            [LpSolver::Microlp] => "linear program (microlp)",
            #[cfg(feature = "highs")]
            [LpSolver::Highs] => "linear program (HiGHS)",
            [] | [_, _, ..] => "linear program",
        }
    }

    fn basis(&self) -> &Basis {
        self.prepared.basis()
    }

    fn bounds_near(&self, moments: &[DoubleDouble], z_f: f64, depths: &[f64]) -> Result<Bounds, MomentError> {
        check_input(self.basis(), Interval::Unit, moments, z_f)?;
        let target = self.prepared.right_hand_side(moments)?;
        let target = (&target[..], Origin::of(depths));
        let lower = self.step(target, Step::Lower { z_f }, depths)?;
        let upper = self.step(target, Step::Upper { z_f }, depths)?;
        assemble(&self.prepared, &lower, &upper).certified(CERTIFIED_GAP)
    }
}
