//! Programs that double precision cannot certify: the simplex method in double-double from the basis that was found.

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

/// A certified bound.
#[derive(Clone, Debug)]
pub(super) struct ExactBound {
    pub(super) lower: f64,
    pub(super) proved: f64,
    /// Ascending columns.
    pub(super) support: Vec<u16>,
}

/// The columns of one basis.
pub(super) struct ExactRoute<'a> {
    columns: &'a SupportColumns,
    /// By row: largest entry.
    largest: Vec<f64>,
    /// Moments of the distribution that is mixed in.
    perturbation: Vec<DoubleDouble>,
}

impl<'a> ExactRoute<'a> {
    pub(super) fn new(columns: &'a SupportColumns) -> Self {
        let rank = columns.rank();
        let mut largest = vec![0.0f64; rank];
        let mut perturbation = vec![DoubleDouble::zero(); rank];
        let share = PERTURBATION / columns.depths() as f64;
        for j in 0..columns.depths() {
            // Unequal weights (golden-ratio sequence), so that ties are broken whatever the symmetry.
            let weight = DoubleDouble::from(share * (0.5 + (j as f64 * 0.618_033_988_749_895).fract()));
            for (i, &a) in columns.column(j)[..rank].iter().enumerate() {
                largest[i] = largest[i].max(a.abs());
                perturbation[i] = perturbation[i] + weight * DoubleDouble::from(a);
            }
        }
        Self { columns, largest, perturbation }
    }

    fn entries(&self, j: u16) -> &'a [f64] {
        &self.columns.column(usize::from(j))[..self.columns.rank()]
    }

    /// G for one fragment, from a basis near the optimum; `None` where even double-double does not suffice.
    pub(super) fn bound(
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
            let (excess, entering) = self.largest_excess(&dual, step, &basis);
            if excess > GAIN && !basis.contains(&entering) {
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
            let proved = (value - excess.max(0.0) - 2.0 * rounding).max(0.0);
            if !proved.is_finite() {
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
    fn repairing(&self, rho: &[DoubleDouble], dual: &[DoubleDouble], step: u16, basis: &[u16]) -> Option<u16> {
        let mut best: Option<(u16, f64)> = None;
        let sizes: Vec<f64> = (0..self.columns.depths() as u16)
            .map(|j| {
                let terms = rho.iter().zip(self.entries(j));
                -terms.fold(DoubleDouble::zero(), |sum, (&r, &a)| sum + r * DoubleDouble::from(a)).to_f64()
            })
            .collect();
        let floor = PIVOT_TOLERANCE * sizes.iter().fold(0.0, |most: f64, &size| most.max(size));
        for (j, &size) in sizes.iter().enumerate() {
            let j = j as u16;
            if size > floor && !basis.contains(&j) {
                let ratio = (-self.excess(dual, j, step)).max(0.0) / size;
                if best.is_none_or(|(_, least)| ratio < least) {
                    best = Some((j, ratio));
                }
            }
        }
        best.map(|(j, _)| j)
    }

    /// y . a - p at a column.
    fn excess(&self, dual: &[DoubleDouble], j: u16, step: u16) -> f64 {
        let cost = DoubleDouble::from(if j < step { -1.0 } else { 0.0 });
        let terms = dual.iter().zip(self.entries(j));
        terms.fold(cost, |sum, (&y, &a)| sum + y * DoubleDouble::from(a)).to_f64()
    }

    /// Largest y . a - p over the support, basic columns left out as far as the entering one is concerned.
    ///
    /// Doubles say which columns come into question.
    fn largest_excess(&self, dual: &[DoubleDouble], step: u16, basis: &[u16]) -> (f64, u16) {
        let y: Vec<f64> = dual.iter().map(|value| value.to_f64()).collect();
        let size: f64 = y.iter().zip(&self.largest).map(|(y, a)| y.abs() * a).sum::<f64>() + 1.0;
        let error = (2 * y.len() + 4) as f64 * f64::EPSILON * size;
        let rough: Vec<f64> = (0..self.columns.depths() as u16)
            .map(|j| {
                let cost = if j < step { -1.0 } else { 0.0 };
                y.iter().zip(self.entries(j)).fold(cost, |sum: f64, (y, a)| sum + y * a)
            })
            .collect();
        let most = rough.iter().fold(f64::NEG_INFINITY, |most: f64, &value| most.max(value));
        let mut best = (f64::NEG_INFINITY, 0);
        for (j, &value) in rough.iter().enumerate() {
            // A NaN comes into question too.
            if value < most - 2.0 * error {
                continue;
            }
            let exact = self.excess(dual, j as u16, step);
            if exact > best.0 && (exact <= GAIN || !basis.contains(&(j as u16))) || exact.is_nan() {
                best = (exact, j as u16);
            }
        }
        best
    }
}
