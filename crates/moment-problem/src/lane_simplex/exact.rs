//! Programs that double precision cannot certify: the simplex method in double-double from the basis that was found.

use super::pairs::{MAX_RANK, Pair, PairFactors, Vector};
use super::width::{Width, add_product};
use crate::arithmetic::{DoubleDouble, Real};
use crate::fast_simplex::{SupportColumns, SupportDistribution, exact_bound};

/// Share of a full-support distribution that is mixed in while pivoting, so that kernels of few depths are not degenerate;
/// final values are computed without it.
const PERTURBATION: f64 = 1e-24;

/// A column enters if it improves the dual function by more than this.
const GAIN: f64 = 1e-13;

/// Pivot elements below this share of the largest are rounding.
const PIVOT_TOLERANCE: f64 = 1e-18;

/// Pivots from the basis that was found; beyond these the method starts afresh.
const MAX_PIVOTS: usize = 200;

/// Roundings of sums of products in double-double, relative.
const ROUNDING: f64 = 1e-30;

/// Wider gaps than this are tried from another start: a tenth of what a search tolerates, a million times what is usual.
const NARROW: f64 = 1e-7;

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
        let gap = |bound: &ExactBound| bound.lower - bound.proved;
        let slowly = |hint: &[u16]| {
            let (bound, vertex) = exact_bound(self.columns, kernel, (step, mass_before), hint).ok()?;
            let support = vertex.support[..self.columns.rank()].to_vec();
            Some(ExactBound { lower: bound.lower, proved: bound.lower_proved, support })
        };
        let mut best = self.near(kernel, step, mass_before, support);
        // From columns that are nearly dependent a walk may end with a dual vector of large entries, whose rounding proves little;
        // another start ends elsewhere.
        for hint in [support, &[]] {
            if best.as_ref().is_some_and(|bound| gap(bound) <= NARROW) {
                break;
            }
            best = best.into_iter().chain(slowly(hint)).min_by(|a, b| gap(a).total_cmp(&gap(b)));
        }
        best
    }

    fn near(
        &self,
        kernel: &SupportDistribution,
        step: u16,
        mass_before: f64,
        support: &[u16],
    ) -> Option<ExactBound> {
        if self.columns.rank() > MAX_RANK {
            return None;
        }
        Width::widest().walk(self, &Start { kernel, step, mass_before, support })
    }

    /// The simplex method from a start.
    #[inline(always)]
    pub(super) fn walk(&self, start: &Start<'_>) -> Option<ExactBound> {
        let Start { kernel, step, mass_before, support } = *start;
        let rank = self.columns.rank();
        let mut target = Vector::default();
        for (&j, &weight) in kernel.indices().iter().zip(kernel.weights()) {
            for (sum, &a) in target.iter_mut().zip(self.entries(j)) {
                *sum = sum.plus(Pair::of(weight).times(Pair::of(a)));
            }
        }
        let mut perturbed = target;
        for (value, &extra) in perturbed.iter_mut().zip(&self.perturbation) {
            *value = value.plus(extra.into());
        }
        let mut basis = [0u16; MAX_RANK];
        basis[..rank].copy_from_slice(support.get(..rank)?);
        let depths = self.columns.depths();
        let mut scratch = vec![0.0; 3 * depths];
        let (excesses, scratch) = scratch.split_at_mut(depths);
        let (sizes, errors) = scratch.split_at_mut(depths);
        for _ in 0..MAX_PIVOTS {
            let mut matrix = [[0.0; MAX_RANK]; MAX_RANK];
            let mut costs = Vector::default();
            for r in 0..rank {
                costs[r] = Pair::of(if basis[r] < step { 1.0 } else { 0.0 });
                for (row, &a) in matrix.iter_mut().zip(self.entries(basis[r])) {
                    row[r] = a;
                }
            }
            let factors = PairFactors::new(rank, &matrix)?;
            let weights = factors.solve(&perturbed);
            let dual = factors.solve_transposed(&costs);
            self.products(&dual, step, excesses, errors);
            let mut least = 0;
            for r in 1..rank {
                if weights[r].high < weights[least].high {
                    least = r;
                }
            }
            if weights[least].high < 0.0 {
                // A column takes its place that keeps the dual vector feasible, if it is (dual simplex method).
                let mut unit = Vector::default();
                unit[least] = Pair::of(1.0);
                self.products(&factors.solve_transposed(&unit), 0, sizes, errors);
                basis[least] = repairing(sizes, excesses, &basis[..rank])?;
                continue;
            }
            let mut excess = 0.0f64;
            let mut entering = None;
            let mut most = GAIN;
            for (j, &value) in excesses.iter().enumerate() {
                excess = excess.max(value);
                // Basic columns price out to rounding only.
                if value > most && !basis[..rank].contains(&(j as u16)) {
                    (most, entering) = (value, Some(j as u16));
                }
            }
            if let Some(entering) = entering {
                let mut column = Vector::default();
                for (value, &a) in column.iter_mut().zip(self.entries(entering)) {
                    *value = Pair::of(a);
                }
                let direction = factors.solve(&column);
                let largest = direction.iter().fold(0.0f64, |largest, d| largest.max(d.high.abs()));
                let mut leaving = None;
                let mut level = f64::INFINITY;
                for r in 0..rank {
                    let ratio = weights[r].high / direction[r].high;
                    if direction[r].high > PIVOT_TOLERANCE * largest && ratio < level {
                        (level, leaving) = (ratio, Some(r));
                    }
                }
                basis[leaving?] = entering;
                continue;
            }
            let mut value = Pair::default();
            let mut size = 0.0;
            for r in 0..rank {
                value = value.plus(dual[r].times(target[r]));
                size += dual[r].high.abs();
            }
            let proved = (value.high - excess - 2.0 * ROUNDING * size).max(0.0);
            // A NaN is in no comparison, but in the size.
            if !(size.is_finite() && value.high.is_finite()) {
                return None;
            }
            let mut support = basis[..rank].to_vec();
            support.sort_unstable();
            // The objective of the optimal weights is the same number.
            let lower = value.high.clamp(0.0, mass_before.max(proved));
            return Some(ExactBound { lower, proved, support });
        }
        None
    }

    /// y . a over the support, less 1 before `step`.
    #[inline(always)]
    fn products(&self, y: &Vector, step: u16, values: &mut [f64], errors: &mut [f64]) {
        values.fill(0.0);
        values[..usize::from(step).min(self.columns.depths())].fill(-1.0);
        errors.fill(0.0);
        for (y, row) in y.iter().zip(&self.rows) {
            add_product((y.high, y.low), (row, &self.none), values, errors);
        }
        for (value, error) in values.iter_mut().zip(errors) {
            *value += *error;
        }
    }
}

/// Where the walk begins.
pub(super) struct Start<'a> {
    kernel: &'a SupportDistribution,
    step: u16,
    mass_before: f64,
    support: &'a [u16],
}

/// The least ratio of slack and size among columns whose size is negative.
#[inline(always)]
fn repairing(sizes: &[f64], excesses: &[f64], basis: &[u16]) -> Option<u16> {
    let mut floor = 0.0f64;
    for &size in sizes {
        floor = floor.min(size);
    }
    let floor = PIVOT_TOLERANCE * floor;
    let mut best = None;
    let mut least = f64::INFINITY;
    for (j, (&size, &excess)) in sizes.iter().zip(excesses).enumerate() {
        if size < floor {
            let ratio = (-excess).max(0.0) / -size;
            if ratio < least && !basis.contains(&(j as u16)) {
                (least, best) = (ratio, Some(j as u16));
            }
        }
    }
    best
}
