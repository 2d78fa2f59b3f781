//! Newton's method for points of contact, from the optima of two other bases.

use super::Work;
use super::factors::Factors;
use super::lanes::{LaneValues, Lanes, MAX_LANES, Mask, unrolled};

/// How often a guess is corrected before it is given up.
const MAX_SHIFTS: u8 = 6;

/// A feasible basis for every program near one of its guesses, or the first guess where there is none.
#[inline(always)]
pub(super) fn newton<V: Lanes, const D: usize, const R: usize>(work: &mut Work<'_, R>) {
    let count = work.count();
    let all = (1u32 << V::COUNT) - 1;
    let spread = work.spread();
    let mut x = [LaneValues([0.0; MAX_LANES]); R];
    for r in 0..R {
        x[r] = LaneValues([f64::from(spread[r]); MAX_LANES]);
    }
    let mut step = LaneValues([0.0; MAX_LANES]);
    let mut b = [LaneValues([0.0; MAX_LANES]); 4];
    let (mut program, mut shifts, mut guess) = ([0usize; MAX_LANES], [0u8; MAX_LANES], [0u8; MAX_LANES]);
    let (mut live, mut next) = (0u32, 0);
    loop {
        let mut idle = all & !live;
        while idle != 0 && next < count {
            let lane = idle.trailing_zeros() as usize % MAX_LANES;
            idle &= idle - 1;
            live |= 1 << lane;
            (program[lane], shifts[lane], guess[lane]) = (next, 0, 0);
            step.0[lane] = f64::from(work.steps[next]);
            for r in 0..R {
                x[r].0[lane] = f64::from(work.guesses[0][next][r]);
            }
            for i in 0..4 {
                b[i].0[lane] = work.moments[next].0[i];
            }
            next += 1;
        }
        if live == 0 {
            return;
        }
        let mut xs = [V::zero(); R];
        unrolled!(r < R, {
            xs[r] = V::load(&x[r]);
        });
        let mut moments = [V::zero(); 4];
        unrolled!(i < 4, {
            moments[i] = V::load(&b[i]);
        });
        let factors = Factors::<V, D>::new(work.table, &xs);
        let weights: [V; R] = factors.weights(&moments);
        let infeasible = factors.is_infeasible(&weights);
        let good = live & !infeasible.bits();
        let mut moved = 0;
        if live & !good != 0 {
            let last = V::splat((work.table.len() - 1) as f64);
            moved = shift(infeasible, &mut xs, &weights, V::load(&step), last).bits();
            unrolled!(r < R, {
                xs[r].store(&mut x[r]);
            });
        }
        let mut finished = good | (live & !moved);
        let mut rest = live & !finished;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize % MAX_LANES;
            rest &= rest - 1;
            shifts[lane] += 1;
            if shifts[lane] >= MAX_SHIFTS {
                finished |= 1 << lane;
            }
        }
        while finished != 0 {
            let lane = finished.trailing_zeros() as usize % MAX_LANES;
            finished &= finished - 1;
            let at = program[lane];
            let is_good = good >> lane & 1 == 1;
            if !is_good && guess[lane] == 0 {
                (guess[lane], shifts[lane]) = (1, 0);
                for r in 0..R {
                    x[r].0[lane] = f64::from(work.guesses[1][at][r]);
                }
                continue;
            }
            for r in 0..R {
                work.supports[at][r] =
                    if is_good { x[r].0[lane] as u16 } else { work.guesses[0][at][r] };
            }
            live &= !(1 << lane);
        }
    }
}

/// Moves pairs of neighbouring columns with a negative weight to their centre of mass, and replaces a pair without mass by
/// both ends of the support, in lanes of `mask`. True where something moved; elsewhere nothing changes.
#[inline(always)]
fn shift<V: Lanes, const R: usize>(
    mask: V::Mask,
    x: &mut [V; R],
    w: &[V; R],
    step: V,
    last: V,
) -> V::Mask {
    let (zero, one, no) = (V::zero(), V::splat(1.0), V::Mask::of(0));
    let (mut first, mut second) = ([no; R], [no; R]);
    unrolled!(r < R, {
        if r + 1 < R {
            let pair = x[r + 1].equal(x[r] + one) & !x[r].equal(step) & !(x[r] + one).equal(step);
            first[r] = pair & !second[r];
            second[r + 1] = first[r];
        }
    });
    let (mut moved, mut failed) = (no, no);
    let mut wrong = V::splat(-1.0);
    let mut before = V::splat(-1.0);
    let mut to = *x;
    unrolled!(r < R, {
        let single = !first[r] & !second[r];
        failed = failed | (single & before.at_least(x[r]));
        before = V::select(single, x[r], before);
        if r + 1 < R {
            let mass = w[r] + w[r + 1];
            let negative = first[r] & (w[r].less(zero) | w[r + 1].less(zero));
            let positive = zero.less(mass);
            let left = x[r].less(step);
            let low = V::select(left, zero, step + one);
            let high = V::select(left, step - V::splat(2.0), last - one);
            let go = negative & positive;
            failed = failed | (go & high.less(low));
            let centre = (x[r] + w[r + 1] / mass).floor();
            // A centre that is no number becomes the lower end.
            let centre = low.max(centre).min(high);
            let target = V::select(go, centre, x[r]);
            moved = moved | (go & !target.equal(x[r]));
            let empty = negative & !positive;
            failed = failed | (empty & wrong.at_least(zero));
            wrong = V::select(empty, V::splat(r as f64), wrong);
            failed = failed | (first[r] & before.at_least(target));
            to[r] = V::select(first[r], target, to[r]);
            to[r + 1] = V::select(first[r], target + one, to[r + 1]);
            before = V::select(first[r], target + one, before);
        }
    });
    // The last one is read by nobody.
    let _ = before;
    let dropped = wrong.at_least(zero);
    if dropped.bits() != 0 {
        failed = failed | (dropped & (to[0].equal(zero) | to[R - 1].equal(last)));
        let old = to;
        unrolled!(r < R, {
            if r > 0 && r + 1 < R {
                let replaced = V::select(wrong.at_least(V::splat(r as f64)), old[r - 1], old[r + 1]);
                to[r] = V::select(dropped, replaced, to[r]);
            }
        });
        to[0] = V::select(dropped, zero, to[0]);
        to[R - 1] = V::select(dropped, last, to[R - 1]);
        moved = moved | dropped;
    }
    let done = mask & moved & !failed;
    unrolled!(r < R, {
        x[r] = V::select(done, to[r], x[r]);
    });
    done
}
