//! Newton's method for points of contact, from the optima of two other bases.

use super::Work;
use super::factors::{Factors, WeightTolerances};
use super::lanes::{LaneValues, Lanes, MAX_LANES, Mask, Quad, unrolled};

/// How often a guess is corrected before it is given up.
const MAX_SHIFTS: u8 = 6;

/// Bases in all lanes, in memory, since lanes are filled one by one.
struct State<const R: usize> {
    x: [LaneValues; R],
    step: LaneValues,
    b: [LaneValues; 4],
}

/// What one step of Newton's method says, by lane.
struct Step {
    /// The weights are in order; such a lane is left as it is.
    good: u32,
    /// Columns were moved.
    moved: u32,
    /// Objective of the weights.
    value: LaneValues,
}

impl<const R: usize> State<R> {
    fn new(work: &Work<'_, R>) -> Self {
        let none = LaneValues([0.0; MAX_LANES]);
        let mut x = [none; R];
        for (lanes, column) in x.iter_mut().zip(work.spread()) {
            *lanes = LaneValues([f64::from(column); MAX_LANES]);
        }
        Self { x, step: none, b: [none; 4] }
    }

    #[inline(always)]
    fn set_program(&mut self, lane: usize, work: &Work<'_, R>, program: usize) {
        self.step.0[lane] = f64::from(work.steps[program]);
        for i in 0..4 {
            self.b[i].0[lane] = work.moments[program].0[i];
        }
    }

    #[inline(always)]
    fn set_support(&mut self, lane: usize, support: &[u16; R]) {
        for r in 0..R {
            self.x[r].0[lane] = f64::from(support[r]);
        }
    }

    #[inline(always)]
    fn support(&self, lane: usize) -> [u16; R] {
        let mut support = [0; R];
        for r in 0..R {
            support[r] = self.x[r].0[lane] as u16;
        }
        support
    }

    /// One step in all lanes.
    #[inline(always)]
    fn advance<V: Lanes, const D: usize>(
        &mut self,
        table: &[Quad],
        tolerances: WeightTolerances,
        live: u32,
    ) -> Step {
        let mut x = [V::zero(); R];
        unrolled!(r < R, {
            x[r] = V::load(&self.x[r]);
        });
        let mut moments = [V::zero(); 4];
        unrolled!(i < 4, {
            moments[i] = V::load(&self.b[i]);
        });
        let step = V::load(&self.step);
        let factors = Factors::<V, D>::new(table, &x);
        let weights: [V; R] = factors.weights(&moments);
        let infeasible = factors.signs(&weights, tolerances).negative;
        let good = live & !infeasible.bits();
        let mut value = V::zero();
        unrolled!(r < R, {
            value = value + V::select(x[r].less(step), weights[r], V::zero());
        });
        let mut moved = 0;
        if live & !good != 0 {
            let last = V::splat((table.len() - 1) as f64);
            moved = shift(infeasible, &mut x, &weights, step, last).bits();
            unrolled!(r < R, {
                x[r].store(&mut self.x[r]);
            });
        }
        let mut values = LaneValues([0.0; MAX_LANES]);
        value.store(&mut values);
        Step { good, moved, value: values }
    }
}

/// A feasible basis for every program near one of its guesses, or the first guess where there is none.
#[inline(always)]
pub(super) fn newton<V: Lanes, const D: usize, const R: usize>(work: &mut Work<'_, R>) {
    let count = work.count();
    let all = (1u32 << V::COUNT) - 1;
    let mut state = State::new(work);
    let (mut program, mut shifts, mut guess) = ([0usize; MAX_LANES], [0u8; MAX_LANES], [0u8; MAX_LANES]);
    let (mut live, mut next) = (0u32, 0);
    loop {
        let mut idle = all & !live;
        while idle != 0 && next < count {
            let lane = idle.trailing_zeros() as usize % MAX_LANES;
            idle &= idle - 1;
            live |= 1 << lane;
            (program[lane], shifts[lane], guess[lane]) = (next, 0, 0);
            state.set_program(lane, work, next);
            state.set_support(lane, &work.guesses[0][next]);
            next += 1;
        }
        if live == 0 {
            return;
        }
        let Step { good, moved, .. } = state.advance::<V, D>(work.table, work.weight_tolerances, live);
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
                state.set_support(lane, &work.guesses[1][at]);
                continue;
            }
            work.supports[at] = if is_good { state.support(lane) } else { work.guesses[0][at] };
            live &= !(1 << lane);
        }
    }
}

/// No seed.
pub(super) const NONE: u32 = u32::MAX;

/// Newton's method from the optima of similar programs that are solved already, two for each; of these bases and the present
/// one the feasible one with the least objective is taken.
#[inline(always)]
pub(super) fn from_seeds<V: Lanes, const D: usize, const R: usize>(
    work: &mut Work<'_, R>,
    list: &[(u32, [u32; 2])],
) {
    let all = (1u32 << V::COUNT) - 1;
    let mut state = State::new(work);
    let mut place = [0usize; MAX_LANES];
    let (mut shifts, mut tried) = ([0u8; MAX_LANES], [0u8; MAX_LANES]);
    let mut best = [(f64::INFINITY, [0u16; R]); MAX_LANES];
    let (mut live, mut next) = (0u32, 0);
    loop {
        let mut idle = all & !live;
        while idle != 0 && next < list.len() {
            let lane = idle.trailing_zeros() as usize % MAX_LANES;
            idle &= idle - 1;
            live |= 1 << lane;
            let program = list[next].0 as usize;
            (place[lane], shifts[lane], tried[lane]) = (next, 0, 0);
            best[lane] = (f64::INFINITY, work.supports[program]);
            state.set_program(lane, work, program);
            state.set_support(lane, &work.supports[program]);
            next += 1;
        }
        if live == 0 {
            return;
        }
        let Step { good, moved, value } = state.advance::<V, D>(work.table, work.weight_tolerances, live);
        let mut each = live;
        while each != 0 {
            let lane = each.trailing_zeros() as usize % MAX_LANES;
            each &= each - 1;
            let is_good = good >> lane & 1 == 1;
            shifts[lane] += 1;
            let is_over = is_good || moved >> lane & 1 == 0 || tried[lane] == 0 || shifts[lane] >= MAX_SHIFTS;
            if !is_over {
                continue;
            }
            if is_good && value.0[lane] < best[lane].0 {
                best[lane] = (value.0[lane], state.support(lane));
            }
            let (program, seeds) = list[place[lane]];
            let mut seed = NONE;
            while seed == NONE && usize::from(tried[lane]) < seeds.len() {
                seed = seeds[usize::from(tried[lane])];
                tried[lane] += 1;
            }
            if seed == NONE {
                work.supports[program as usize] = best[lane].1;
                live &= !(1 << lane);
            } else {
                shifts[lane] = 0;
                let support = work.supports[seed as usize];
                state.set_support(lane, &support);
            }
        }
    }
}

/// Moves pairs of neighbouring columns with a negative weight to their centre of mass, and replaces a pair without mass by
/// both ends of the support, in lanes of `mask`. True where something moved; elsewhere nothing changes.
#[inline(always)]
fn shift<V: Lanes, const R: usize>(mask: V::Mask, x: &mut [V; R], w: &[V; R], step: V, last: V) -> V::Mask {
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
