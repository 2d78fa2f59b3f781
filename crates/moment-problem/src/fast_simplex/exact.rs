//! Fragments that single steps of `f64` could not certify: the same linear program in double-double.

use super::support::{SupportColumns, SupportDistribution};
use super::{FastBound, FastSolution, FastVertex, Hints, Task};
use crate::arithmetic::{DoubleDouble, Real};
use crate::certified::{Column, FiniteProgram, LpSolver, ask};
use crate::dense::dot;
use crate::error::MomentError;

/// Roundings of sums of products in double-double, relative.
const ROUNDING: f64 = 1e-30;

/// Decides the fragments that are listed as uncertified and leaves there what remains so.
pub(super) fn settle(task: &Task<'_>, solution: &mut FastSolution, hints: &Hints) {
    for (index, hint) in std::mem::take(&mut solution.uncertified).into_iter().zip(hints) {
        solution.exact += 1;
        let fragment = &task.fragments[index];
        let kernel = &task.kernels[fragment.kernel as usize];
        match bound(task.columns, kernel, (fragment.step, fragment.mass_before), hint) {
            Ok((mut bound, vertex)) => {
                bound.vertex = solution.vertices.len() as u32;
                solution.vertices.push(vertex);
                solution.bounds[index] = bound;
                if bound.lower - bound.lower_proved > task.tolerance {
                    solution.uncertified.push(index);
                }
            }
            Err(_) => {
                // The dual vector 0 proves the trivial bound.
                let vertex = FastVertex { step: fragment.step, ..FastVertex::default() };
                let bound = FastBound { vertex: solution.vertices.len() as u32, ..FastBound::default() };
                solution.vertices.push(vertex);
                solution.bounds[index] = bound;
                solution.uncertified.push(index);
            }
        }
    }
}

/// A fragment's program over the whole support.
fn program(
    columns: &SupportColumns,
    kernel: &SupportDistribution,
    step: u16,
) -> (Vec<DoubleDouble>, Vec<Column>) {
    let rank = columns.rank();
    let entries = |j: usize| -> Vec<DoubleDouble> {
        columns.column(j)[..rank].iter().map(|&a| DoubleDouble::from(a)).collect()
    };
    let mut target = vec![DoubleDouble::zero(); rank];
    for (&j, &weight) in kernel.indices().iter().zip(kernel.weights()) {
        for (sum, a) in target.iter_mut().zip(entries(usize::from(j))) {
            *sum = *sum + DoubleDouble::from(weight) * a;
        }
    }
    let column = |j: usize| {
        let cost = if j < usize::from(step) { 1.0 } else { 0.0 };
        Column { z: j as f64, entries: entries(j), cost }
    };
    (target, (0..columns.depths()).map(column).collect())
}

/// G by the double-double simplex method alone: a reference that shares no code with the fast one but the columns.
///
/// # Errors
/// [`MomentError`] where even double-double does not suffice.
pub fn reference_bound(
    columns: &SupportColumns,
    kernel: &SupportDistribution,
    step: u16,
) -> Result<f64, MomentError> {
    let (target, real) = program(columns, kernel, step);
    FiniteProgram::new(&target, real).optimum_without_artificial().map(|(_, value)| value)
}

/// What a solver behind good_lp says G is, unchecked, on the same program.
///
/// # Errors
/// [`MomentError::Solver`] with the solver's message.
pub fn good_lp_bound(
    columns: &SupportColumns,
    kernel: &SupportDistribution,
    step: u16,
    solver: LpSolver,
) -> Result<f64, MomentError> {
    let (target, real) = program(columns, kernel, step);
    let right_hand_side: Vec<f64> = target.iter().map(|b| b.to_f64()).collect();
    ask(solver, &real, &right_hand_side).map(|claim| claim.objective)
}

/// G for a fragment at `step` with F = `mass_before`, and its certificate. `hint` are the columns of bases near the optimum,
/// one after the other.
pub(crate) fn bound(
    columns: &SupportColumns,
    kernel: &SupportDistribution,
    (step, mass_before): (u16, f64),
    hint: &[u16],
) -> Result<(FastBound, FastVertex), MomentError> {
    let rank = columns.rank();
    let (target, real) = program(columns, kernel, step);
    let mut program = FiniteProgram::new(&target, real);
    // Without a hint that leads to a feasible basis the program starts from artificial columns.
    let _ = hint.chunks_exact(rank).any(|columns| program.start_at(columns));
    let (dual, value) = program.optimum_without_artificial()?;
    let excess = |column: &Column| (dot(&dual, &column.entries) - DoubleDouble::from(column.cost)).to_f64();
    let size: f64 = dual.iter().map(|y| y.to_f64().abs()).sum();
    let lacking = program.columns().iter().map(excess).fold(0.0, f64::max) + size * ROUNDING;
    let mut vertex = FastVertex { step, lacking, rank: rank as u8, ..FastVertex::default() };
    for (i, y) in dual.iter().enumerate() {
        vertex.dual[i] = y.to_f64();
        vertex.dual_low[i] = (*y - DoubleDouble::from(vertex.dual[i])).to_f64();
    }
    for (place, j) in vertex.support.iter_mut().zip(program.basic_depths()) {
        *place = j as u16;
    }
    vertex.support[..rank].sort_unstable();
    let lower_proved = (value - lacking - size * ROUNDING).max(0.0);
    // The primal objective of the optimal vertex is the same number; its weights were computed to 1e-24.
    let lower = value.clamp(0.0, mass_before.max(lower_proved));
    Ok((FastBound { lower, lower_proved, vertex: 0 }, vertex))
}
