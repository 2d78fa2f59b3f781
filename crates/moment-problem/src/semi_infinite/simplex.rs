//! Primal simplex method in double-double over finitely many depths, with columns added where the dual function
//! exceeds the step: a linear program over the whole interval, not over a grid.

use super::certificate::{SEARCH_TOLERANCE, Step};
use super::prepared::{FEASIBILITY_TOLERANCE, PreparedBasis};
use crate::arithmetic::{DoubleDouble, Real};
use crate::dense::{Factors, dot};
use crate::error::MomentError;

/// Costs of an artificial variable, tried in turn. They bound the dual vector, whose size decides how close together
/// the exchange puts its depths, so the smallest one that drives the artificial variables out is best. Six
/// power moments of a kernel whose depths lie within 1e-3 need duals of 1e19.
const ARTIFICIAL_COSTS: [f64; 6] = [1e4, 1e7, 1e10, 1e13, 1e17, 1e21];

/// Artificial variables above this are not rounding: the next cost is tried. Then the exact solution
/// needs none, and its dual is no larger than the present cost.
const ARTIFICIAL_RESIDUAL: f64 = 1e-24;

/// A higher cost that leaves more than this share of the residual has met moments outside the set of moments (by
/// rounding, say): what is left is their distance to it, and still higher costs would only spoil the dual.
const STALLED: f64 = 0.9;

/// Share of a full-support distribution that is mixed in for the pivoting rules, so that kernels with few surfaces
/// are not degenerate vertices. Final values are computed without it. The bound may react to a perturbation by its
/// square root, so this leaves 1e-12.
const PERTURBATION: f64 = 1e-24;

/// Reduced costs above minus this count as optimal.
const OPTIMALITY_TOLERANCE: f64 = 1e-13;

/// Pivot elements below this share of the largest are not used.
const PIVOT_TOLERANCE: f64 = 1e-18;

/// Pivots between two exchanges: about ten times what tests need. Beyond it rounding drives a cycle; the proof of the
/// vertex reached decides what it is worth.
const MAX_PIVOTS: usize = 500;

/// Exchanges: convergence is quadratic near the solution; more means that something is wrong.
const MAX_EXCHANGES: usize = 60;

/// Cells of the uniform grid that the exchange starts from: coarse, since the exchange adds what is missing.
pub(crate) const START_CELLS: usize = 64;

/// A depth with its column a(z) of the constraint matrix and its cost p(z).
pub(crate) struct Column {
    pub z: f64,
    pub entries: Vec<DoubleDouble>,
    pub cost: f64,
}

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

/// Minimises E\[p\] over distributions on \[0, 1\] with the moments `right_hand_side` (orthonormal coordinates).
///
/// `extra` are depths to start from besides the uniform grid and z_f, such as the kernel's own.
pub(crate) fn minimise(
    prepared: &PreparedBasis,
    right_hand_side: &[DoubleDouble],
    step: Step,
    extra: &[f64],
) -> Result<Solution, MomentError> {
    Program::new(prepared, right_hand_side, step, START_CELLS, extra).solve()
}

/// A linear program over the depths collected so far.
pub(crate) struct Program<'a> {
    prepared: &'a PreparedBasis,
    step: Step,
    target: Vec<DoubleDouble>,
    perturbed: Vec<DoubleDouble>,
    /// The first `rank` columns are artificial unit columns with z = NaN.
    columns: Vec<Column>,
    basic: Vec<usize>,
}

impl<'a> Program<'a> {
    /// Starts from the ends of `cells` equal cells, the `extra` depths and z_f.
    pub(crate) fn new(
        prepared: &'a PreparedBasis,
        target: &[DoubleDouble],
        step: Step,
        cells: usize,
        extra: &[f64],
    ) -> Self {
        let rank = prepared.rank();
        let mut depths: Vec<f64> = (0..=cells).map(|i| i as f64 / cells as f64).collect();
        depths.extend_from_slice(extra);
        depths.push(step.z_f());
        depths.sort_by(f64::total_cmp);
        depths.dedup();
        let mut program = Self {
            prepared,
            step,
            target: target.to_vec(),
            perturbed: target.to_vec(),
            columns: Vec::new(),
            basic: (0..rank).collect(),
        };
        let real: Vec<Column> = depths.iter().map(|&z| program.column(z)).collect();
        let share = DoubleDouble::from(PERTURBATION / real.len() as f64);
        for (j, column) in real.iter().enumerate() {
            // Unequal weights (golden-ratio sequence), so that ties are broken whatever the symmetry.
            let weight = share * DoubleDouble::from(0.5 + (j as f64 * 0.618_033_988_749_895).fract());
            for (value, &entry) in program.perturbed.iter_mut().zip(&column.entries) {
                *value = *value + weight * entry;
            }
        }
        for row in 0..rank {
            let sign = if program.perturbed[row] < DoubleDouble::zero() { -1.0 } else { 1.0 };
            let entries = (0..rank).map(|i| DoubleDouble::from(if i == row { sign } else { 0.0 })).collect();
            program.columns.push(Column { z: f64::NAN, entries, cost: ARTIFICIAL_COSTS[0] });
        }
        program.columns.extend(real);
        program
    }

    /// Columns without the artificial ones.
    pub(crate) fn columns(&self) -> &[Column] {
        &self.columns[self.prepared.rank()..]
    }

    /// Optimum over the present depths: its dual y over the orthonormal rows and its value y . b.
    pub(crate) fn finite_optimum(&mut self) -> Result<(Vec<DoubleDouble>, f64), MomentError> {
        self.optimise()?;
        let dual = self.dual()?;
        let value = dot(&dual, &self.target).to_f64();
        Ok((dual, value))
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
            let rank = self.prepared.rank();
            self.columns[..rank].iter_mut().for_each(|column| column.cost = cost);
            self.exchange_at_present_cost()?;
            let residual = self.vertex()?.residual;
            if residual <= ARTIFICIAL_RESIDUAL || residual > STALLED * before {
                break;
            }
            before = residual;
        }
        Ok(self.finite_optimum()?.1)
    }

    fn exchange_at_present_cost(&mut self) -> Result<(), MomentError> {
        for _ in 0..MAX_EXCHANGES {
            self.optimise()?;
            let vertex = self.vertex()?;
            if vertex.residual <= FEASIBILITY_TOLERANCE && vertex.is_zero() {
                break; // nothing is smaller, so nothing has to be proved
            }
            let violations = self.prepared.violations(&vertex.dual, self.step, SEARCH_TOLERANCE);
            if violations.is_empty() || !self.add_columns(violations.into_iter()) {
                break;
            }
        }
        Ok(())
    }

    fn column(&self, z: f64) -> Column {
        Column { z, entries: self.prepared.column(z), cost: self.step.at(z) }
    }

    /// Adds columns for new depths; false if all were there.
    fn add_columns(&mut self, depths: impl Iterator<Item = f64>) -> bool {
        let before = self.columns.len();
        for z in depths {
            if !self.columns.iter().any(|column| column.z == z) {
                self.columns.push(self.column(z));
            }
        }
        self.columns.len() > before
    }

    fn factors(&self) -> Result<Factors<DoubleDouble>, MomentError> {
        let rank = self.basic.len();
        Factors::new(rank, |i, j| self.columns[self.basic[j]].entries[i])
            .ok_or_else(|| failure("the basis matrix became singular"))
    }

    fn costs(&self) -> Vec<DoubleDouble> {
        self.basic.iter().map(|&j| DoubleDouble::from(self.columns[j].cost)).collect()
    }

    fn dual(&self) -> Result<Vec<DoubleDouble>, MomentError> {
        Ok(self.factors()?.solve_transposed(&self.costs()))
    }

    fn optimise(&mut self) -> Result<(), MomentError> {
        let artificial = self.prepared.rank();
        for _ in 0..MAX_PIVOTS {
            let factors = self.factors()?;
            let y = factors.solve_transposed(&self.costs());
            let mut entering = None;
            let mut smallest = -OPTIMALITY_TOLERANCE;
            for (j, column) in self.columns.iter().enumerate().skip(artificial) {
                let reduced = (DoubleDouble::from(column.cost) - dot(&y, &column.entries)).to_f64();
                // Basic columns price out to rounding only, which nearly parallel columns can magnify.
                if reduced < smallest && !self.basic.contains(&j) {
                    smallest = reduced;
                    entering = Some(j);
                }
            }
            let Some(entering) = entering else { return Ok(()) };
            let x = factors.solve(&self.perturbed);
            let direction = factors.solve(&self.columns[entering].entries);
            let largest = direction.iter().map(|d| d.to_f64().abs()).fold(0.0, f64::max);
            let mut leaving: Option<(usize, f64, f64)> = None;
            for (i, (x, d)) in x.iter().zip(&direction).enumerate() {
                let d = d.to_f64();
                if d > PIVOT_TOLERANCE * largest {
                    let ratio = x.to_f64().max(0.0) / d;
                    let better =
                        leaving.is_none_or(|(_, best, pivot)| ratio < best || (ratio == best && d > pivot));
                    if better {
                        leaving = Some((i, ratio, d));
                    }
                }
            }
            let Some((row, ..)) = leaving else { return Err(failure("unbounded direction")) };
            self.basic[row] = entering;
        }
        Ok(())
    }

    /// The present vertex for the moments without perturbation.
    fn vertex(&self) -> Result<Vertex, MomentError> {
        let factors = self.factors()?;
        let x = factors.solve(&self.target);
        let mut vertex = Vertex {
            dual: factors.solve_transposed(&self.costs()),
            attained: self.target.clone(),
            value: DoubleDouble::zero(),
            support: Vec::new(),
            residual: 0.0,
        };
        for (&j, &weight) in self.basic.iter().zip(&x) {
            let column = &self.columns[j];
            if column.z.is_nan() {
                vertex.residual = vertex.residual.max(weight.to_f64().abs());
                for (value, &entry) in vertex.attained.iter_mut().zip(&column.entries) {
                    *value = *value - weight * entry;
                }
            } else {
                vertex.value = vertex.value + weight * DoubleDouble::from(column.cost);
                vertex.support.push((column.z, weight.to_f64()));
            }
        }
        Ok(vertex)
    }

    /// The present vertex with its proof.
    pub(crate) fn finish(&self) -> Result<Solution, MomentError> {
        let mut vertex = self.vertex()?;
        let residual = vertex.residual;
        if residual.is_nan() || residual > FEASIBILITY_TOLERANCE {
            return Err(MomentError::Infeasible { residual });
        }
        if vertex.is_zero() {
            vertex.dual.fill(DoubleDouble::zero());
        }
        let (y, target) = (vertex.dual, vertex.attained);
        let excess = self.prepared.excess(&y, self.step).max(0.0);
        let dual_value = dot(&y, &target).to_f64();
        let rounding: f64 = y.iter().zip(&target).map(|(y, b)| (y.to_f64() * b.to_f64()).abs()).sum();
        let proved = dual_value - excess - rounding * 1e-28 - f64::EPSILON;
        Ok(Solution { dual: y, primal_value: vertex.value.to_f64(), proved, excess, support: vertex.support })
    }
}

/// A basic solution.
struct Vertex {
    dual: Vec<DoubleDouble>,
    /// Right-hand side that the depths attain: the target, projected onto the set of moments if it was outside.
    attained: Vec<DoubleDouble>,
    value: DoubleDouble,
    support: Vec<(f64, f64)>,
    /// Largest artificial weight.
    residual: f64,
}

impl Vertex {
    /// Whether the objective is at its trivial minimum; the dual function 0 proves that.
    fn is_zero(&self) -> bool {
        self.value.to_f64() <= f64::EPSILON
    }
}

fn failure(message: &str) -> MomentError {
    MomentError::Solver { name: "exchange simplex".to_owned(), message: message.to_owned() }
}
