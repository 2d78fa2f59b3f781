//! The primal simplex method, one program a lane, with an explicit inverse.

use super::Work;
use super::factors::Factors;
use super::lanes::{LaneValues, Lanes, MAX_LANES, Mask, Quad, unrolled};

/// Every so many columns are priced first; the best of them is improved in halving steps.
const COARSE: usize = 8;

/// Pivots of one program; what needs more goes to the exact route.
const MAX_PIVOTS: u8 = 60;

/// A column enters if it improves the dual function by more than this: far below the tolerance of the certificate.
const GAIN: f64 = 1e-9;

/// Weights are negative below minus this times the size of their row of the inverse, see the certificate's tolerance.
const WEIGHT_TOLERANCE: f64 = 3e-14;

/// A weight that was negative is in order above minus this. The certificate looks at it again.
const REPAIRED: f64 = 1e-13;

/// Pivot elements below this share of the largest one are rounding, for rows in order and for rows to be repaired.
const PIVOT_TOLERANCE: f64 = 1e-11;
/// See [`PIVOT_TOLERANCE`].
const REPAIR_TOLERANCE: f64 = 1e-9;

/// How columns are priced first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pricing {
    /// Every eighth column, then halving steps, then the neighbours of the basic columns.
    Coarse,
    /// All columns.
    Full,
}

/// Improves the bases of the programs in `list` until no column enters.
#[inline(always)]
pub(super) fn pivots<V: Lanes, const D: usize, const R: usize>(
    work: &mut Work<'_, R>,
    list: &[u32],
    pricing: Pricing,
) {
    let all = (1u32 << V::COUNT) - 1;
    let no = V::Mask::of(0);
    let (zero, one) = (V::zero(), V::splat(1.0));
    let table = work.table;
    let last = V::splat((table.len() - 1) as f64);
    let mut given = [LaneValues([0.0; MAX_LANES]); R];
    for (lanes, column) in given.iter_mut().zip(work.spread()) {
        *lanes = LaneValues([f64::from(column); MAX_LANES]);
    }
    let mut steps = LaneValues([1.0; MAX_LANES]);
    let mut b = [LaneValues([0.0; MAX_LANES]); 4];
    let (mut program, mut count) = ([0u32; MAX_LANES], [0u8; MAX_LANES]);
    let mut x = [zero; R];
    let mut weights = [zero; R];
    // Row r: the constant, then the factors of the moments.
    let mut inverse = [[zero; R]; R];
    let mut negative = [no; R];
    let (mut live, mut next) = (0u32, 0);
    loop {
        let free = (all & !live).count_ones() as usize;
        if next < list.len() && (free >= V::COUNT / 2 || live == 0) {
            let mut fresh = 0u32;
            let mut idle = all & !live;
            while idle != 0 && next < list.len() {
                let lane = idle.trailing_zeros() as usize % MAX_LANES;
                idle &= idle - 1;
                fresh |= 1 << lane;
                let at = list[next] as usize;
                (program[lane], count[lane]) = (list[next], 0);
                steps.0[lane] = f64::from(work.steps[at]);
                for r in 0..R {
                    given[r].0[lane] = f64::from(work.supports[at][r]);
                }
                for i in 0..4 {
                    b[i].0[lane] = work.moments[at].0[i];
                }
                next += 1;
            }
            live |= fresh;
            let new = V::Mask::of(fresh);
            unrolled!(r < R, {
                x[r] = V::select(new, V::load(&given[r]), x[r]);
            });
            let mut moments = [zero; 4];
            unrolled!(i < 4, {
                moments[i] = V::load(&b[i]);
            });
            begin::<V, D, R>(new, table, &x, &moments, &mut inverse, &mut weights, &mut negative);
        }
        if live == 0 {
            return;
        }
        let step = V::load(&steps);
        let mut repairing = negative[0];
        unrolled!(r < R, {
            repairing = repairing | negative[r];
        });
        // The dual vector of the costs, or of minus the weights that are negative.
        let mut y = [zero; R];
        let mut any = no;
        let cost = V::select(repairing, V::splat(-1.0), one);
        unrolled!(r < R, {
            let on = (repairing & negative[r]) | (!repairing & x[r].less(step));
            any = any | on;
            let factor = V::select(on, cost, zero);
            unrolled!(i < R, {
                y[i] = factor.mul_add(inverse[r][i], y[i]);
            });
        });
        let front = V::select(repairing, zero, step);
        let (mut best, mut at) = search::<V, R>(table, &y, front, step, repairing, pricing);
        if pricing == Pricing::Coarse {
            let none = best.less(V::splat(GAIN)) & !repairing & any;
            if none.bits() & live != 0 {
                unrolled!(r < R, {
                    let below = zero.max(x[r] - one);
                    let above = (x[r] + one).min(last);
                    consider::<V, R>(table, &y, front, none, below, &mut best, &mut at);
                    consider::<V, R>(table, &y, front, none, above, &mut best, &mut at);
                });
            }
        }
        let mut go = any & best.at_least(V::splat(GAIN));
        let column = V::gather(table, at);
        let mut direction = [zero; R];
        let mut size = zero;
        unrolled!(r < R, {
            let mut sum = inverse[r][0];
            unrolled!(i < D, {
                sum = inverse[r][i + 1].mul_add(column[i], sum);
            });
            direction[r] = sum;
            size = size.max(sum.abs());
        });
        // The first weight in order that reaches 0, unless the last one in disorder does before.
        let (mut level, mut leaving) = (V::splat(1e300), V::splat(-1.0));
        let (mut far, mut repaired) = (V::splat(-1.0), V::splat(-1.0));
        let (floor, depth) = (size * V::splat(PIVOT_TOLERANCE), size * V::splat(-REPAIR_TOLERANCE));
        unrolled!(r < R, {
            let ratio = weights[r] / direction[r];
            let blocks = !negative[r] & floor.less(direction[r]) & ratio.less(level);
            level = V::select(blocks, ratio, level);
            leaving = V::select(blocks, V::splat(r as f64), leaving);
            let mends = negative[r] & direction[r].less(depth) & far.less(ratio);
            far = V::select(mends, ratio, far);
            repaired = V::select(mends, V::splat(r as f64), repaired);
        });
        let mends = repaired.at_least(zero) & far.less(level);
        leaving = V::select(mends, repaired, leaving);
        level = V::select(mends, far, level);
        go = go & leaving.at_least(zero);
        let mut going = go.bits() & live;
        let mut each = going;
        while each != 0 {
            let lane = each.trailing_zeros() as usize % MAX_LANES;
            each &= each - 1;
            count[lane] += 1;
            if count[lane] > MAX_PIVOTS {
                going &= !(1 << lane);
            }
        }
        work.pivots += u64::from(going.count_ones());
        let go = V::Mask::of(going);
        let mut pivot = direction[0];
        let mut row = inverse[0];
        unrolled!(r < R, {
            if r > 0 {
                let is_it = leaving.equal(V::splat(r as f64));
                pivot = V::select(is_it, direction[r], pivot);
                unrolled!(i < R, {
                    row[i] = V::select(is_it, inverse[r][i], row[i]);
                });
            }
        });
        // Lanes that do not pivot subtract nothing.
        let reciprocal = V::select(go, one / pivot, zero);
        let level = V::select(go, level, zero);
        unrolled!(r < R, {
            let is_it = go & leaving.equal(V::splat(r as f64));
            let moving = V::select(go, direction[r], zero);
            let factor = V::select(is_it, zero - reciprocal, moving * reciprocal);
            let weight = level.neg_mul_add(moving, weights[r]);
            let fine = !negative[r] | V::splat(-REPAIRED).less(weight);
            let weight = V::select(fine, zero.max(weight), weight);
            negative[r] = negative[r] & !fine & !is_it;
            weights[r] = V::select(is_it, level, weight);
            x[r] = V::select(is_it, at, x[r]);
            unrolled!(i < R, {
                let kept = V::select(is_it, zero, inverse[r][i]);
                inverse[r][i] = factor.neg_mul_add(row[i], kept);
            });
        });
        let mut finished = live & !going;
        if finished != 0 {
            let mut columns = [LaneValues([0.0; MAX_LANES]); R];
            unrolled!(r < R, {
                x[r].store(&mut columns[r]);
            });
            while finished != 0 {
                let lane = finished.trailing_zeros() as usize % MAX_LANES;
                finished &= finished - 1;
                let support = &mut work.supports[program[lane] as usize];
                for r in 0..R {
                    support[r] = columns[r].0[lane] as u16;
                }
                support.sort_unstable();
                live &= !(1 << lane);
            }
        }
    }
}

/// Inverse and weights of new lanes.
#[inline(always)]
fn begin<V: Lanes, const D: usize, const R: usize>(
    new: V::Mask,
    table: &[Quad],
    x: &[V; R],
    moments: &[V; 4],
    inverse: &mut [[V; R]; R],
    weights: &mut [V; R],
    negative: &mut [V::Mask; R],
) {
    let (zero, one) = (V::zero(), V::splat(1.0));
    let factors = Factors::<V, D>::new(table, x);
    // Columns of C^-1.
    let mut columns = [[zero; D]; D];
    unrolled!(i < D, {
        let mut unit = [zero; D];
        unit[i] = one;
        factors.solve(&mut unit);
        columns[i] = unit;
    });
    unrolled!(r < R, {
        let mut row = [zero; R];
        let mut constant = if r == 0 { one } else { zero };
        unrolled!(i < D, {
            let before = if r > 0 { columns[i][r - 1] } else { zero };
            let after = if r < D { columns[i][r] } else { zero };
            row[i + 1] = before - after;
            constant = row[i + 1].neg_mul_add(factors.base[i], constant);
        });
        row[0] = constant;
        let (mut weight, mut size) = (constant, constant.abs());
        unrolled!(i < D, {
            weight = row[i + 1].mul_add(moments[i], weight);
            size = size + row[i + 1].abs();
        });
        let below = weight.less(size * V::splat(-WEIGHT_TOLERANCE));
        negative[r] = (new & below) | (!new & negative[r]);
        let weight = V::select(below, weight, zero.max(weight));
        weights[r] = V::select(new, weight, weights[r]);
        unrolled!(i < R, {
            inverse[r][i] = V::select(new, row[i], inverse[r][i]);
        });
    });
}

/// y . a - p at columns that the lanes name.
#[inline(always)]
fn gain<V: Lanes, const R: usize>(table: &[Quad], y: &[V; R], front: V, at: V) -> V {
    let column = V::gather(table, at);
    let mut sum = V::select(at.less(front), y[0] - V::splat(1.0), y[0]);
    unrolled!(i < R, {
        if i > 0 {
            sum = y[i].mul_add(column[i - 1], sum);
        }
    });
    sum
}

/// Takes a column if it is better, in lanes of `mask`.
#[inline(always)]
fn consider<V: Lanes, const R: usize>(
    table: &[Quad],
    y: &[V; R],
    front: V,
    mask: V::Mask,
    column: V,
    best: &mut V,
    at: &mut V,
) {
    let value = gain::<V, R>(table, y, front, column);
    let better = mask & best.less(value);
    *best = V::select(better, value, *best);
    *at = V::select(better, column, *at);
}

/// The column that improves the dual function most, or one that is near it.
#[inline(always)]
fn search<V: Lanes, const R: usize>(
    table: &[Quad],
    y: &[V; R],
    front: V,
    step: V,
    repairing: V::Mask,
    pricing: Pricing,
) -> (V, V) {
    let (zero, one) = (V::zero(), V::splat(1.0));
    let last = V::splat((table.len() - 1) as f64);
    let (mut best, mut at) = (V::splat(-1e300), zero);
    let before = y[0] - one;
    let stride = match pricing {
        Pricing::Coarse => COARSE,
        Pricing::Full => 1,
    };
    let mut number = zero;
    let every = V::splat(stride as f64);
    for column in table.iter().step_by(stride) {
        let mut sums = [V::select(number.less(front), before, y[0]), zero];
        unrolled!(i < R, {
            if i == 2 {
                sums[1] = y[2] * V::splat(column.0[1]);
            } else if i > 0 {
                sums[(i + 1) % 2] = y[i].mul_add(V::splat(column.0[i - 1]), sums[(i + 1) % 2]);
            }
        });
        let value = sums[0] + sums[1];
        let better = best.less(value);
        best = best.max(value);
        at = V::select(better, number, at);
        number = number + every;
    }
    if pricing == Pricing::Coarse {
        consider::<V, R>(table, y, front, !repairing, step.min(last), &mut best, &mut at);
        consider::<V, R>(table, y, front, !repairing, zero.max(step - one), &mut best, &mut at);
        let mut half = COARSE / 2;
        while half > 0 {
            let distance = V::splat(half as f64);
            let (below, above) = (zero.max(at - distance), (at + distance).min(last));
            let (low, high) = (gain::<V, R>(table, y, front, below), gain::<V, R>(table, y, front, above));
            let better = best.less(low);
            best = V::select(better, low, best);
            at = V::select(better, below, at);
            let better = best.less(high);
            best = V::select(better, high, best);
            at = V::select(better, above, at);
            half /= 2;
        }
    }
    (best, at)
}
