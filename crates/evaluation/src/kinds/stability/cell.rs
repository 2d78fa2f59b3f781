//! All inputs of a cell on all methods.

use super::exact;
use super::input::{Input, Moments};
use super::method::{Answer, Prepared, Start};
use super::tally::{BOUND_TOLERANCE, LogHistogram, Tally};
use moment_problem::MomentBound;
use moment_problem::arithmetic::DoubleDouble;
use serde::{Deserialize, Serialize};

/// Orders whose moment matrices are looked at.
pub(crate) const PIVOT_ORDERS: [usize; 3] = [4, 6, 8];

/// What is the same for all cells.
pub(crate) struct StabilityPlan {
    pub(crate) methods: Vec<Prepared>,
    /// Moment biases of each method, its own first.
    pub(crate) alphas: Vec<Vec<f64>>,
    /// For each method the first one that has the same exact bound.
    pub(crate) problems: Vec<usize>,
}

/// What went wrong.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Failure {
    Error,
    Violated,
    Outside,
    NotFinite,
}

impl Failure {
    pub(crate) const ALL: [Self; 4] = [Self::Error, Self::Violated, Self::Outside, Self::NotFinite];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Violated => "violated",
            Self::Outside => "outside",
            Self::NotFinite => "not finite",
        }
    }
}

/// The worst input of a method for one failure.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct Worst {
    /// How bad it is.
    pub(crate) size: f64,
    pub(crate) value: Option<f64>,
    pub(crate) exact_biased: f64,
    pub(crate) exact: Option<f64>,
    pub(crate) input: Input,
}

/// Results of a cell, or of several.
#[derive(Clone, Deserialize, Serialize)]
pub(crate) struct Outcome {
    /// By method and alpha.
    pub(crate) tallies: Vec<Vec<Tally>>,
    /// By method and failure.
    pub(crate) worst: Vec<[Option<Worst>; 4]>,
    /// By method; only those that are checked are counted.
    pub(crate) checks: Vec<Check>,
    /// By order.
    pub(crate) pivots: [LogHistogram; 3],
}

/// Inputs whose exact bound is not computed.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub(crate) struct Check {
    pub(crate) inputs: u64,
    pub(crate) not_finite: u64,
    pub(crate) outside: u64,
    pub(crate) violated: u64,
    pub(crate) largest_excess: f64,
}

impl Check {
    fn add(&mut self, Answer { lower, upper }: &Answer, allowed: f64) {
        self.inputs += 1;
        let (Some(lower), Some(upper)) = (*lower, *upper) else {
            self.not_finite += 1;
            return;
        };
        self.outside += u64::from(!(0.0 <= lower && lower <= upper && upper <= 1.0));
        self.violated += u64::from(lower - allowed > BOUND_TOLERANCE);
        self.largest_excess = self.largest_excess.max(lower - allowed);
    }

    fn merge(&mut self, other: &Self) {
        self.inputs += other.inputs;
        self.not_finite += other.not_finite;
        self.outside += other.outside;
        self.violated += other.violated;
        self.largest_excess = self.largest_excess.max(other.largest_excess);
    }
}

impl Outcome {
    pub(crate) fn new(plan: &StabilityPlan) -> Self {
        Self {
            tallies: plan.alphas.iter().map(|alphas| vec![Tally::default(); alphas.len()]).collect(),
            worst: vec![const { [const { None }; 4] }; plan.methods.len()],
            checks: vec![Check::default(); plan.methods.len()],
            pivots: Default::default(),
        }
    }

    /// Adds the results of a later cell.
    pub(crate) fn merge(&mut self, later: &Self) {
        for (mine, theirs) in self.tallies.iter_mut().flatten().zip(later.tallies.iter().flatten()) {
            mine.merge(theirs);
        }
        for (mine, theirs) in self.worst.iter_mut().flatten().zip(later.worst.iter().flatten()) {
            if let Some(theirs) = theirs {
                keep(mine, theirs.size, || theirs.clone());
            }
        }
        self.checks.iter_mut().zip(&later.checks).for_each(|(mine, theirs)| mine.merge(theirs));
        self.pivots.iter_mut().zip(&later.pivots).for_each(|(mine, theirs)| mine.merge(theirs));
    }

    /// All methods at all their biases.
    pub(crate) fn evaluate(&mut self, plan: &StabilityPlan, input: &Input) {
        let moments = Moments::<DoubleDouble>::exact(input);
        let front = input.mass_before();
        for (histogram, order) in self.pivots.iter_mut().zip(PIVOT_ORDERS) {
            histogram.add(exact::smallest_pivot(input, order));
        }
        let mut unbiased: Vec<(MomentBound, Option<f64>)> = Vec::new();
        // By method: the exact bounds at its biases.
        let mut biased: Vec<Vec<(f64, f64)>> = vec![Vec::new(); plan.methods.len()];
        for (i, method) in plan.methods.iter().enumerate() {
            let exact = match unbiased.iter().find(|(bound, _)| *bound == method.bound) {
                Some(&(_, exact)) => exact,
                None => {
                    let exact = exact::lower(method.bound, input, &moments);
                    unbiased.push((method.bound, exact));
                    exact
                }
            };
            let b = method.moments(&moments);
            let z_f = method.depth(input);
            let stored = method.stored(b);
            let start = stored.as_ref().map_or(Start::Exact(b), Start::Stored);
            for (step, &alpha) in plan.alphas[i].iter().enumerate() {
                let known = &mut biased[plan.problems[i]];
                let exact_biased = match known.iter().find(|(known, _)| *known == alpha) {
                    Some(&(_, exact)) => exact,
                    None => {
                        let unbiased = exact.filter(|_| alpha == 0.0);
                        let value = unbiased.unwrap_or_else(|| method.exact_biased(b, z_f, alpha));
                        known.push((alpha, value));
                        value
                    }
                };
                let value = method.answer(start, z_f, alpha).lower;
                self.tallies[i][step].add(value, front + alpha, exact_biased, exact);
                if step == 0 {
                    let worst = |size: f64| Worst { size, value, exact_biased, exact, input: input.clone() };
                    self.note(i, (value, exact_biased, front + alpha), worst);
                }
            }
        }
    }

    /// Keeps an input that is worse than those before.
    fn note(
        &mut self,
        method: usize,
        (value, exact, allowed): (Option<f64>, f64, f64),
        worst: impl Fn(f64) -> Worst,
    ) {
        for (place, failure) in self.worst[method].iter_mut().zip(Failure::ALL) {
            let size = match (failure, value) {
                (Failure::NotFinite, None) => 1.0,
                (_, None) | (Failure::NotFinite, _) => continue,
                (Failure::Error, Some(value)) => (value.clamp(0.0, 1.0) - exact).abs(),
                (Failure::Violated, Some(value)) => value.clamp(0.0, 1.0) - allowed,
                (Failure::Outside, Some(value)) => (value - 1.0).max(-value),
            };
            let least = if failure == Failure::Error { 0.0 } else { BOUND_TOLERANCE };
            if size > least {
                keep(place, size, || worst(size));
            }
        }
    }

    /// Our forms at their own biases, against F.
    pub(crate) fn check(&mut self, plan: &StabilityPlan, input: &Input) {
        let moments = Moments::<f64>::plain(input);
        let front = input.mass_before();
        for (method, check) in plan.methods.iter().zip(&mut self.checks) {
            if method.is_checked() {
                let start = Start::Plain(method.moments(&moments));
                let answer = method.answer(start, method.depth(input), method.alpha);
                check.add(&answer, front + method.alpha);
            }
        }
    }
}

fn keep(place: &mut Option<Worst>, size: f64, worst: impl FnOnce() -> Worst) {
    if place.as_ref().is_none_or(|known| size > known.size) {
        *place = Some(worst());
    }
}
