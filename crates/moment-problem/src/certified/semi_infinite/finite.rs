//! Primal simplex method in double-double over finitely many columns.

use crate::arithmetic::{DoubleDouble, Real};
use crate::dense::{Factors, dot};
use crate::error::MomentError;

/// Costs of an artificial variable, tried in turn. They bound the dual vector, whose size decides how close together
/// the exchange puts its depths, so the smallest one that drives the artificial variables out is best. Six
/// power moments of a kernel whose depths lie within 1e-3 need duals of 1e19.
pub(super) const ARTIFICIAL_COSTS: [f64; 6] = [1e4, 1e7, 1e10, 1e13, 1e17, 1e21];

/// Artificial variables above this are not rounding: the next cost is tried. Then the exact solution
/// needs none, and its dual is no larger than the present cost.
pub(super) const ARTIFICIAL_RESIDUAL: f64 = 1e-24;

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

/// Pivots of one program: about ten times what any certified answer needed. Beyond it the program is refused in time.
const MAX_PIVOTS_IN_ALL: usize = 3000;

/// Pivots that bring a basis near the optimum to feasible weights; more are not worth it.
const MAX_REPAIRS: usize = 12;

/// A depth with its column a(z) of the constraint matrix and its cost p(z).
pub(crate) struct Column {
    pub z: f64,
    pub entries: Vec<DoubleDouble>,
    pub cost: f64,
}

/// A program in other coordinates: columns without the artificial ones, right-hand side, dual vector.
pub(crate) struct Turned {
    pub columns: Vec<Column>,
    pub target: Vec<DoubleDouble>,
    pub dual: Vec<DoubleDouble>,
}

/// A linear program with equality constraints in double-double: minimise sum p_j w_j subject to sum a_j w_j = b, w >= 0.
pub(crate) struct FiniteProgram {
    rank: usize,
    target: Vec<DoubleDouble>,
    perturbed: Vec<DoubleDouble>,
    /// The first `rank` columns are artificial unit columns with z = NaN.
    columns: Vec<Column>,
    basic: Vec<usize>,
    /// Pivots so far.
    pivots: usize,
}

impl FiniteProgram {
    /// Starts from artificial columns.
    pub(crate) fn new(target: &[DoubleDouble], real: Vec<Column>) -> Self {
        let rank = target.len();
        let mut perturbed = target.to_vec();
        let share = DoubleDouble::from(PERTURBATION / real.len() as f64);
        for (j, column) in real.iter().enumerate() {
            // Unequal weights (golden-ratio sequence), so that ties are broken whatever the symmetry.
            let weight = share * DoubleDouble::from(0.5 + (j as f64 * 0.618_033_988_749_895).fract());
            for (value, &entry) in perturbed.iter_mut().zip(&column.entries) {
                *value = *value + weight * entry;
            }
        }
        let mut columns = Vec::with_capacity(rank + real.len());
        for (row, &value) in perturbed.iter().enumerate() {
            let sign = if value < DoubleDouble::zero() { -1.0 } else { 1.0 };
            let entries = (0..rank).map(|i| DoubleDouble::from(if i == row { sign } else { 0.0 })).collect();
            columns.push(Column { z: f64::NAN, entries, cost: ARTIFICIAL_COSTS[0] });
        }
        columns.extend(real);
        Self { rank, target: target.to_vec(), perturbed, columns, basic: (0..rank).collect(), pivots: 0 }
    }

    /// Starts from given columns instead, by their numbers without the artificial ones, if they are a feasible
    /// basis or next to one.
    pub(crate) fn start_at(&mut self, columns: &[u16]) -> bool {
        let real = self.columns.len() - self.rank;
        if columns.len() != self.rank || columns.iter().any(|&j| usize::from(j) >= real) {
            return false;
        }
        let artificial = std::mem::take(&mut self.basic);
        self.basic = columns.iter().map(|&j| self.rank + usize::from(j)).collect();
        let is_feasible = self.repair().unwrap_or(false);
        if !is_feasible {
            self.basic = artificial;
        }
        is_feasible
    }

    /// Dual simplex method towards a basis without negative weights; true if it gets there.
    fn repair(&mut self) -> Result<bool, MomentError> {
        for _ in 0..MAX_REPAIRS {
            let factors = self.factors()?;
            let x = factors.solve(&self.perturbed);
            let least = x.iter().enumerate().min_by(|a, b| a.1.to_f64().total_cmp(&b.1.to_f64()));
            let Some((row, _)) = least.filter(|(_, weight)| **weight < DoubleDouble::zero()) else {
                return Ok(true);
            };
            let unit: Vec<DoubleDouble> =
                (0..self.rank).map(|i| DoubleDouble::from(if i == row { 1.0 } else { 0.0 })).collect();
            let (rho, y) = (factors.solve_transposed(&unit), factors.solve_transposed(&self.costs()));
            let sizes: Vec<f64> =
                self.columns.iter().map(|column| -dot(&rho, &column.entries).to_f64()).collect();
            let real = || (self.rank..self.columns.len()).filter(|j| !self.basic.contains(j));
            let floor = PIVOT_TOLERANCE * real().map(|j| sizes[j]).fold(0.0, f64::max);
            let ratio = |j: usize| {
                let column = &self.columns[j];
                let slack = (DoubleDouble::from(column.cost) - dot(&y, &column.entries)).to_f64();
                slack.max(0.0) / sizes[j]
            };
            let candidates = real().filter(|&j| sizes[j] > floor).map(|j| (j, ratio(j)));
            let entering = candidates.min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((entering, _)) = entering else { return Ok(false) };
            self.basic[row] = entering;
        }
        Ok(false)
    }

    /// The right-hand side as given.
    pub(crate) fn target(&self) -> &[DoubleDouble] {
        &self.target
    }

    /// The same program with the present basis as coordinates: columns of the basis become unit vectors, so that nothing
    /// is lost in rows of very different sizes.
    pub(crate) fn in_present_basis(&self) -> Result<Turned, MomentError> {
        let factors = self.factors()?;
        let turned = |column: &Column| {
            let entries = factors.solve(&column.entries);
            // A depth far from the basis has large coordinates: its weight is counted in their reciprocal.
            let size = entries.iter().map(|entry| entry.to_f64().abs()).fold(1.0, f64::max);
            let scale = DoubleDouble::one() / DoubleDouble::from(size);
            let entries = entries.into_iter().map(|entry| entry * scale).collect();
            Column { z: column.z, entries, cost: column.cost / size }
        };
        Ok(Turned {
            columns: self.columns().iter().map(turned).collect(),
            target: factors.solve(&self.target),
            dual: self.costs(),
        })
    }

    /// Columns without the artificial ones.
    pub(crate) fn columns(&self) -> &[Column] {
        &self.columns[self.rank..]
    }

    /// Depths of the basic columns that are not artificial.
    pub(crate) fn basic_depths(&self) -> impl Iterator<Item = f64> + '_ {
        self.basic.iter().filter(|&&j| j >= self.rank).map(|&j| self.columns[j].z)
    }

    pub(crate) fn push(&mut self, column: Column) {
        self.columns.push(column);
    }

    pub(crate) fn set_artificial_cost(&mut self, cost: f64) {
        self.columns[..self.rank].iter_mut().for_each(|column| column.cost = cost);
    }

    /// Optimum over the present columns: its dual y and its value y . b.
    pub(crate) fn optimum(&mut self) -> Result<(Vec<DoubleDouble>, f64), MomentError> {
        self.optimise()?;
        let dual = self.factors()?.solve_transposed(&self.costs());
        let value = dot(&dual, &self.target).to_f64();
        Ok((dual, value))
    }

    /// The same with the artificial cost raised until it no longer shows.
    pub(crate) fn optimum_without_artificial(&mut self) -> Result<(Vec<DoubleDouble>, f64), MomentError> {
        let mut result = self.optimum()?;
        for cost in &ARTIFICIAL_COSTS[1..] {
            if self.vertex()?.residual <= ARTIFICIAL_RESIDUAL {
                break;
            }
            self.set_artificial_cost(*cost);
            result = self.optimum()?;
        }
        Ok(result)
    }

    fn factors(&self) -> Result<Factors<DoubleDouble>, MomentError> {
        let rank = self.basic.len();
        Factors::new(rank, |i, j| self.columns[self.basic[j]].entries[i])
            .ok_or_else(|| failure("the basis matrix became singular"))
    }

    fn costs(&self) -> Vec<DoubleDouble> {
        self.basic.iter().map(|&j| DoubleDouble::from(self.columns[j].cost)).collect()
    }

    pub(crate) fn optimise(&mut self) -> Result<(), MomentError> {
        let artificial = self.rank;
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
            let Some(entering) = entering.filter(|_| self.pivots < MAX_PIVOTS_IN_ALL) else { return Ok(()) };
            self.pivots += 1;
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
    pub(crate) fn vertex(&self) -> Result<Vertex, MomentError> {
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
}

/// A basic solution.
pub(crate) struct Vertex {
    pub(super) dual: Vec<DoubleDouble>,
    /// Right-hand side that the depths attain: the target, projected onto the set of moments if it was outside.
    pub(super) attained: Vec<DoubleDouble>,
    pub(super) value: DoubleDouble,
    pub(super) support: Vec<(f64, f64)>,
    /// Largest artificial weight.
    pub(super) residual: f64,
}

impl Vertex {
    /// Whether the objective is at its trivial minimum; the dual function 0 proves that.
    pub(super) fn is_zero(&self) -> bool {
        self.value.to_f64() <= f64::EPSILON
    }
}

fn failure(message: &str) -> MomentError {
    MomentError::Solver { name: "exchange simplex".to_owned(), message: message.to_owned() }
}
