//! What a basis proves: its dual vector over the whole support, and its weights.

use super::Work;
use super::factors::Factors;
use super::lanes::{LaneValues, Lanes, MAX_LANES, Mask, Quad, unrolled};

/// Programs of two vectors share the columns as they are loaded.
const GROUPS: usize = 2;

/// Rounding of p = 1, and of the subtractions at the end.
const LEAST_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Rounding beyond this, more than any bound, proves nothing; what stays below it is far from overflow.
const LARGEST_ROUNDING: f64 = 1.0;

/// A basis in every lane.
#[derive(Clone, Copy)]
struct Basis<V: Lanes, const D: usize> {
    y: [V; D],
    y0: V,
    /// y_0 + y . b.
    dual_value: V,
    /// Objective of the weights, negative ones left out.
    value: V,
    /// Error of the dual function and of its value by rounding.
    rounding: V,
    infeasible: V::Mask,
    doubtful: V::Mask,
    /// No column is in front of the step: y = 0.
    empty: V::Mask,
    step: V,
    front: V,
    back: V,
}

impl<V: Lanes, const D: usize> Basis<V, D> {
    #[inline(always)]
    fn new<const R: usize>(work: &Work<'_, R>, programs: &[u32; MAX_LANES]) -> Self {
        let mut x = [LaneValues([0.0; MAX_LANES]); R];
        let mut moments = [LaneValues([0.0; MAX_LANES]); 4];
        let [mut steps, mut norms] = [LaneValues([0.0; MAX_LANES]); 2];
        for lane in 0..V::COUNT {
            let at = programs[lane] as usize;
            for r in 0..R {
                x[r].0[lane] = f64::from(work.supports[at][r]);
            }
            for i in 0..4 {
                moments[i].0[lane] = work.moments[at].0[i];
            }
            steps.0[lane] = f64::from(work.steps[at]);
            norms.0[lane] = work.norms[at];
        }
        let step = V::load(&steps);
        let mut columns = [V::zero(); R];
        unrolled!(r < R, {
            columns[r] = V::load(&x[r]);
        });
        let mut b = [V::zero(); 4];
        unrolled!(i < 4, {
            b[i] = V::load(&moments[i]);
        });
        let factors = Factors::<V, D>::new(work.table, &columns);
        let weights: [V; R] = factors.weights(&b);
        let mut costs = [V::zero(); R];
        let mut value = V::zero();
        unrolled!(r < R, {
            costs[r] = V::select(columns[r].less(step), V::splat(1.0), V::zero());
            value = costs[r].mul_add(V::zero().max(weights[r]), value);
        });
        let (y0, y) = factors.dual(&costs);
        let signs = factors.signs(&weights, work.weight_tolerances);
        let mut dual_value = y0;
        let of_moments = V::load(&norms) * V::splat(work.errors.moment);
        let mut rounding = y0.abs().mul_add(V::splat(work.errors.mass), V::splat(LEAST_ROUNDING));
        unrolled!(i < D, {
            dual_value = y[i].mul_add(b[i], dual_value);
            let of_row = of_moments + V::splat(work.errors.rows[i]);
            let factor = b[i].abs().mul_add(V::splat(work.errors.value), of_row);
            rounding = y[i].abs().mul_add(factor, rounding);
        });
        Self {
            y,
            y0,
            dual_value,
            value,
            rounding,
            infeasible: signs.negative,
            doubtful: signs.doubtful,
            empty: !V::zero().less(costs[0]),
            step,
            front: V::splat(-1e300),
            back: V::splat(-1e300),
        }
    }

    /// y . a.
    #[inline(always)]
    fn product(&self, column: &[V; 4]) -> V {
        // Two sums at a time, for the length of the chain.
        let mut sums = [self.y[0] * column[0], V::zero()];
        unrolled!(i < D, {
            if i == 1 {
                sums[1] = self.y[1] * column[1];
            } else if i > 1 {
                sums[i % 2] = self.y[i].mul_add(column[i], sums[i % 2]);
            }
        });
        sums[0] + sums[1]
    }
}

#[inline(always)]
fn splat<V: Lanes>(column: &Quad) -> [V; 4] {
    let mut values = [V::zero(); 4];
    unrolled!(i < 4, {
        values[i] = V::splat(column.0[i]);
    });
    values
}

/// Certifies the bases of the programs in `list`. Those that another basis may do better for are appended to `open`, those
/// whose basis is optimal but proves too little in double precision to `rest`.
#[inline(always)]
pub(super) fn certify<V: Lanes, const D: usize, const R: usize>(
    work: &mut Work<'_, R>,
    list: &[u32],
    open: &mut Vec<u32>,
    rest: &mut Vec<u32>,
) {
    let width = GROUPS * V::COUNT;
    for group in list.chunks(width) {
        let mut programs = [[group[group.len() - 1]; MAX_LANES]; GROUPS];
        let (mut least, mut largest) = (usize::MAX, 0);
        for (i, &program) in group.iter().enumerate() {
            programs[i / V::COUNT][i % V::COUNT] = program;
            let step = usize::from(work.steps[program as usize]);
            (least, largest) = (least.min(step), largest.max(step));
        }
        let mut bases = [Basis::<V, D>::new(work, &programs[0]), Basis::<V, D>::new(work, &programs[1])];
        let table = work.table;
        let (least, largest) = (least.min(table.len()), largest.min(table.len()));
        for column in &table[..least] {
            let column = splat::<V>(column);
            unrolled!(u < GROUPS, {
                bases[u].front = bases[u].front.max(bases[u].product(&column));
            });
        }
        for (j, column) in table[least..largest].iter().enumerate() {
            let column = splat::<V>(column);
            let number = V::splat((least + j) as f64);
            unrolled!(u < GROUPS, {
                let product = bases[u].product(&column);
                let before = number.less(bases[u].step);
                bases[u].front = V::select(before, bases[u].front.max(product), bases[u].front);
                bases[u].back = V::select(before, bases[u].back, bases[u].back.max(product));
            });
        }
        for column in &table[largest..] {
            let column = splat::<V>(column);
            unrolled!(u < GROUPS, {
                bases[u].back = bases[u].back.max(bases[u].product(&column));
            });
        }
        for (u, basis) in bases.iter().enumerate() {
            let zero = V::zero();
            let excess = zero.max(basis.y0 + (basis.front - V::splat(1.0)).max(basis.back));
            let lacking = V::select(basis.empty, zero, excess);
            let rounding = V::select(basis.empty, zero, basis.rounding);
            let sound = rounding.less(V::splat(LARGEST_ROUNDING));
            let proved = zero.max(V::select(basis.empty, zero, basis.dual_value) - lacking - rounding);
            let proved = V::select(sound, proved, zero);
            let value = V::select(basis.empty, zero, basis.value);
            let (infeasible, doubtful) = (basis.infeasible.bits(), basis.doubtful.bits());
            let unsound = (!sound).bits();
            let [mut lacks, mut proofs, mut values] = [LaneValues([0.0; MAX_LANES]); 3];
            lacking.store(&mut lacks);
            proved.store(&mut proofs);
            value.store(&mut values);
            let tolerance = work.tolerance;
            for lane in 0..group.len().saturating_sub(u * V::COUNT).min(V::COUNT) {
                let program = programs[u][lane];
                let at = program as usize;
                let mass = work.masses[at];
                let proved = proofs.0[lane];
                // No bound exceeds F, and none is below what is proved.
                let bound = values.0[lane].max(proved).min(mass);
                let is_infeasible = infeasible >> lane & 1 == 1;
                let is_sharp = !is_infeasible && bound - proved <= tolerance;
                let is_doubtful = doubtful >> lane & 1 == 1;
                // With the kernel's weights a basis attains F; what else it seems to attain is rounding.
                let is_known = !is_doubtful || (bound >= mass - tolerance && work.is_distribution_of(at));
                let settled = proved >= mass - tolerance || (is_sharp && is_known);
                work.lower[at] = bound;
                work.proved[at] = proved.min(bound);
                if !settled {
                    let hopeless =
                        !is_infeasible && unsound >> lane & 1 == 0 && lacks.0[lane] <= 0.5 * tolerance;
                    if hopeless { rest.push(program) } else { open.push(program) }
                }
            }
        }
    }
}
