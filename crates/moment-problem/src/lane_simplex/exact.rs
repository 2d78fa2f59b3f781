//! Programs that double precision cannot certify: the simplex method in double-double from the basis that was found.

use super::width::Width;
use crate::arithmetic::{DoubleDouble, Real};
use crate::dense::{Factors, dot};
use crate::fast_simplex::{SupportColumns, SupportDistribution, exact_bound};

/// Share of a full-support distribution that is mixed in while pivoting, so that kernels of few depths are not degenerate;
/// final values are computed without it.
const PERTURBATION: f64 = 1e-24;

/// A column enters if it improves the dual function by more than this.
const GAIN: f64 = 1e-13;

/// Pivot elements below this share of the largest are rounding.
const PIVOT_TOLERANCE: f64 = 1e-18;

/// Pivots from the basis that was found; beyond these the method starts afresh.
const MAX_PIVOTS: usize = 60;

/// Roundings of sums of products in double-double, relative.
const ROUNDING: f64 = 1e-30;

/// A bound with its proof.
#[derive(Clone, Debug)]
pub struct ExactBound {
    /// G.
    pub lower: f64,
    /// Proved: no distribution on the support with these moments has less mass before z_f.
    pub proved: f64,
    /// Ascending basic columns.
    pub support: Vec<u16>,
}

/// The simplex method in double-double from a given basis, for the columns of one basis of functions.
pub struct ExactSimplex<'a> {
    columns: &'a SupportColumns,
    /// By row: its entries over the support.
    rows: Vec<Vec<f64>>,
    /// Zeros, as many: what entries lack.
    none: Vec<f64>,
    /// Moments of the distribution that is mixed in.
    perturbation: Vec<DoubleDouble>,
}

impl<'a> ExactSimplex<'a> {
    /// For these columns.
    pub fn new(columns: &'a SupportColumns) -> Self {
        let rank = columns.rank();
        let depths = columns.depths();
        let mut rows = vec![vec![0.0; depths]; rank];
        let mut perturbation = vec![DoubleDouble::zero(); rank];
        let share = PERTURBATION / depths as f64;
        for j in 0..depths {
            // Unequal weights (golden-ratio sequence), so that ties are broken whatever the symmetry.
            let weight = DoubleDouble::from(share * (0.5 + (j as f64 * 0.618_033_988_749_895).fract()));
            for (i, &a) in columns.column(j)[..rank].iter().enumerate() {
                rows[i][j] = a;
                perturbation[i] = perturbation[i] + weight * DoubleDouble::from(a);
            }
        }
        Self { columns, rows, none: vec![0.0; depths], perturbation }
    }

    fn entries(&self, j: u16) -> &'a [f64] {
        &self.columns.column(usize::from(j))[..self.columns.rank()]
    }

    /// G for a kernel at depth number `step` of the support with F = `mass_before`, from ascending columns near the optimum;
    /// `None` where even double-double does not suffice.
    ///
    /// # Panics
    /// If the support has no such depth or column.
    pub fn bound(
        &self,
        kernel: &SupportDistribution,
        step: u16,
        mass_before: f64,
        support: &[u16],
    ) -> Option<ExactBound> {
        self.near(kernel, step, mass_before, support).or_else(|| {
            let (bound, vertex) = exact_bound(self.columns, kernel, (step, mass_before), support).ok()?;
            let support = vertex.support[..self.columns.rank()].to_vec();
            Some(ExactBound { lower: bound.lower, proved: bound.lower_proved, support })
        })
    }

    fn near(
        &self,
        kernel: &SupportDistribution,
        step: u16,
        mass_before: f64,
        support: &[u16],
    ) -> Option<ExactBound> {
        let rank = self.columns.rank();
        let mut target = vec![DoubleDouble::zero(); rank];
        for (&j, &weight) in kernel.indices().iter().zip(kernel.weights()) {
            for (sum, &a) in target.iter_mut().zip(self.entries(j)) {
                *sum = *sum + DoubleDouble::from(weight) * DoubleDouble::from(a);
            }
        }
        let perturbed: Vec<DoubleDouble> =
            target.iter().zip(&self.perturbation).map(|(&value, &extra)| value + extra).collect();
        let cost = |j: u16| if j < step { 1.0 } else { 0.0 };
        let mut basis = support.to_vec();
        for _ in 0..MAX_PIVOTS {
            let factors = Factors::new(rank, |i, r| DoubleDouble::from(self.entries(basis[r])[i]))?;
            let weights = factors.solve(&perturbed);
            let costs: Vec<DoubleDouble> = basis.iter().map(|&j| DoubleDouble::from(cost(j))).collect();
            let dual = factors.solve_transposed(&costs);
            let least = (0..rank).min_by(|&a, &b| weights[a].to_f64().total_cmp(&weights[b].to_f64()))?;
            if weights[least].to_f64() < 0.0 {
                let unit: Vec<DoubleDouble> =
                    (0..rank).map(|i| DoubleDouble::from(if i == least { 1.0 } else { 0.0 })).collect();
                basis[least] = self.repairing(&factors.solve_transposed(&unit), &dual, step, &basis)?;
                continue;
            }
            let excesses = self.products(&dual, step);
            let excess = excesses.iter().fold(0.0, |most: f64, &excess| most.max(excess));
            // Basic columns price out to rounding only.
            let entering = (0..excesses.len() as u16)
                .filter(|j| !basis.contains(j) && excesses[usize::from(*j)] > GAIN)
                .max_by(|&a, &b| excesses[usize::from(a)].total_cmp(&excesses[usize::from(b)]));
            if let Some(entering) = entering {
                let column: Vec<DoubleDouble> =
                    self.entries(entering).iter().map(|&a| DoubleDouble::from(a)).collect();
                let direction: Vec<f64> = factors.solve(&column).iter().map(|d| d.to_f64()).collect();
                let largest = direction.iter().fold(0.0, |most: f64, d| most.max(d.abs()));
                let ratio = |r: usize| weights[r].to_f64().max(0.0) / direction[r];
                let leaving = (0..rank)
                    .filter(|&r| direction[r] > PIVOT_TOLERANCE * largest)
                    .min_by(|&a, &b| ratio(a).total_cmp(&ratio(b)))?;
                basis[leaving] = entering;
                continue;
            }
            let value = dot(&dual, &target).to_f64();
            let size: f64 = dual.iter().map(|y| y.to_f64().abs()).sum();
            let rounding = size * ROUNDING;
            let proved = (value - excess - 2.0 * rounding).max(0.0);
            if !(proved.is_finite() && size.is_finite()) {
                return None;
            }
            basis.sort_unstable();
            // The objective of the optimal weights is the same number.
            let lower = value.clamp(0.0, mass_before.max(proved));
            return Some(ExactBound { lower, proved, support: basis });
        }
        None
    }

    /// The column that takes the place of one with a negative weight (dual simplex method); `rho` is its row of the inverse.
    fn repairing(
        &self,
        rho: &[DoubleDouble],
        dual: &[DoubleDouble],
        step: u16,
        basis: &[u16],
    ) -> Option<u16> {
        let sizes = self.products(rho, 0);
        let excesses = self.products(dual, step);
        let floor = -PIVOT_TOLERANCE * sizes.iter().fold(0.0, |least: f64, &size| least.min(size));
        let mut best: Option<(u16, f64)> = None;
        for (j, (&size, &excess)) in sizes.iter().zip(&excesses).enumerate() {
            let j = j as u16;
            if -size > floor && !basis.contains(&j) {
                let ratio = (-excess).max(0.0) / -size;
                if best.is_none_or(|(_, least)| ratio < least) {
                    best = Some((j, ratio));
                }
            }
        }
        best.map(|(j, _)| j)
    }

    /// y . a over the support, less 1 before `step`, in double-double.
    fn products(&self, y: &[DoubleDouble], step: u16) -> Vec<f64> {
        let mut values = vec![0.0; self.columns.depths()];
        values.iter_mut().take(usize::from(step)).for_each(|value| *value = -1.0);
        let mut errors = vec![0.0; values.len()];
        for (y, row) in y.iter().zip(&self.rows) {
            let factor = (y.to_f64(), y.low());
            Width::widest().accumulate(factor, (row, &self.none), &mut values, &mut errors);
        }
        values.iter_mut().zip(&errors).for_each(|(value, error)| *value += error);
        values
    }
}
