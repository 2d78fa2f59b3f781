//! Racing candidates on growing samples until the cheapest that meets a tolerance is certain.
//!
//! All fragments of all views are shuffled once; a candidate looks at the first 2^r blocks of them in its round r, so that
//! earlier work is kept and the last round has seen every fragment. The intervals are those of Bardenet and Maillard (2015, Theorem 4,
//! "Concentration inequalities for sampling without replacement"): errors lie in \[0, 1\], nothing else is assumed. All
//! intervals of a race hold together with probability [`CONFIDENCE`].

use super::scenery::{FreeParameters, SceneView, SpeedPlan};
use crate::error::EvaluationError;
use crate::statistics::Sums;
use random_stream::Random;

/// Fragments of the first round: as few as make the widest candidates stand apart.
const FIRST_ROUND: usize = 4096;

/// Probability that all intervals of a race hold.
pub(crate) const CONFIDENCE: f64 = 0.999;

/// Stream of random numbers of the shuffle, apart from those of samples.
const SHUFFLE_STREAM: u64 = 1 << 33;

/// An error with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Estimate {
    pub(crate) error: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) fragments: usize,
}

/// A candidate at one map size.
pub(crate) struct Arm {
    pub(crate) candidate: usize,
    pub(crate) divisor: usize,
    pub(crate) cost: f64,
    pub(crate) variants: Vec<FreeParameters>,
    /// By variant.
    sums: Vec<Sums>,
    /// Variants that may still be the best of the arm.
    live: Vec<usize>,
}

/// The race.
pub(crate) struct Race<'a> {
    plan: &'a SpeedPlan<'a>,
    views: &'a [SceneView],
    /// By cost, ascending.
    pub(crate) arms: Vec<Arm>,
    shuffled: Vec<(u32, u32)>,
    truth: Vec<f32>,
    /// ln(5 / delta) for one interval.
    log_term: f64,
    pub(crate) evaluations: usize,
}

/// Where an arm stands.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Standing {
    Meets,
    Fails,
    Open,
}

impl<'a> Race<'a> {
    pub(crate) fn new(plan: &'a SpeedPlan<'a>, views: &'a [SceneView]) -> Self {
        let mut arms = Vec::new();
        for candidate in 0..plan.candidates.len() {
            for divisor in 0..plan.kernels.len() {
                if views.iter().all(|view| view.maps[divisor].is_some()) {
                    let variants = plan.variants(candidate);
                    arms.push(Arm {
                        candidate,
                        divisor,
                        cost: plan.cost(candidate, divisor).total(),
                        sums: vec![Sums::default(); variants.len()],
                        live: (0..variants.len()).collect(),
                        variants,
                    });
                }
            }
        }
        arms.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let fragments = views.iter().enumerate().flat_map(|(view, of)| {
            (0..of.receivers.len()).map(move |fragment| (view as u32, fragment as u32))
        });
        let mut shuffled: Vec<(u32, u32)> = fragments.collect();
        let random = &mut Random::substream(plan.experiment.scenery.seed, SHUFFLE_STREAM, 0);
        for i in (1..shuffled.len()).rev() {
            let other = (random.unit() * (i + 1) as f64) as usize;
            shuffled.swap(i, other.min(i));
        }
        let rounds = 1 + shuffled.len().div_ceil(FIRST_ROUND).next_power_of_two().ilog2();
        let intervals: usize = arms.iter().map(|arm| arm.sums.len()).sum::<usize>() * rounds as usize;
        let log_term = (5.0 * intervals as f64 / (1.0 - CONFIDENCE)).ln();
        Self { plan, views, arms, shuffled, truth: Vec::new(), log_term, evaluations: 0 }
    }

    /// All fragments there are.
    pub(crate) fn fragments(&self) -> usize {
        self.shuffled.len()
    }

    /// The cheapest arm that meets the tolerance, or `None` if none does; `progress` hears of arms that are decided.
    ///
    /// All cheaper arms have to be refuted, whatever the order, and costlier ones need no more than a first look. So arms
    /// are decided one after another, the cheapest first.
    pub(crate) fn run(
        &mut self,
        tolerance: f64,
        progress: &dyn Fn(usize, usize),
    ) -> Result<Option<usize>, EvaluationError> {
        let arms = self.arms.len();
        for arm in 0..arms {
            self.extend(arm, FIRST_ROUND)?;
            progress(arm + 1, 2 * arms);
        }
        for arm in 0..arms {
            // With all fragments seen, nothing is open.
            while self.standing(arm, tolerance) == Standing::Open {
                self.extend(arm, 2 * self.arms[arm].seen())?;
            }
            progress(arms + arm + 1, 2 * arms);
            if self.standing(arm, tolerance) == Standing::Meets {
                return Ok(Some(arm));
            }
        }
        Ok(None)
    }

    /// Lets an arm see the first `upto` fragments.
    pub(crate) fn extend(&mut self, arm: usize, upto: usize) -> Result<(), EvaluationError> {
        let upto = upto.min(self.shuffled.len());
        self.reveal(upto);
        let (from, live) = (self.arms[arm].seen(), self.arms[arm].live.clone());
        if upto <= from {
            return Ok(());
        }
        let variants: Vec<FreeParameters> =
            live.iter().map(|&variant| self.arms[arm].variants[variant]).collect();
        let place = (self.arms[arm].candidate, self.arms[arm].divisor);
        // View by view; within a view in the order of the map, for the sake of its caches.
        let mut order: Vec<usize> = (from..upto).collect();
        order.sort_unstable_by_key(|&i| self.shuffled[i]);
        let mut rest = order.as_slice();
        while let Some(&first) = rest.first() {
            let view = self.shuffled[first].0;
            let count = rest.partition_point(|&i| self.shuffled[i].0 == view);
            let (group, others) = rest.split_at(count);
            rest = others;
            let fragments: Vec<u32> = group.iter().map(|&i| self.shuffled[i].1).collect();
            let truth: Vec<f32> = group.iter().map(|&i| self.truth[i]).collect();
            let view = &self.views[view as usize];
            let sums = self.plan.sums(place, view, (&fragments, &truth), &variants)?;
            for (&variant, more) in live.iter().zip(&sums) {
                self.arms[arm].sums[variant].add(more);
            }
            self.evaluations += fragments.len();
        }
        let least = live.iter().map(|&v| self.estimate(arm, v).high).fold(f64::INFINITY, f64::min);
        let kept: Vec<usize> = live.into_iter().filter(|&v| self.estimate(arm, v).low <= least).collect();
        self.arms[arm].live = kept;
        Ok(())
    }

    /// Computes F of the first fragments.
    fn reveal(&mut self, upto: usize) {
        let from = self.truth.len();
        if upto <= from {
            return;
        }
        self.truth.resize(upto, 0.0);
        for (view, of) in self.views.iter().enumerate() {
            let places: Vec<usize> = (from..upto).filter(|&i| self.shuffled[i].0 as usize == view).collect();
            let fragments: Vec<u32> = places.iter().map(|&i| self.shuffled[i].1).collect();
            for (i, truth) in places.into_iter().zip(self.plan.reference(of, &fragments)) {
                self.truth[i] = truth;
            }
        }
    }

    fn standing(&self, arm: usize, tolerance: f64) -> Standing {
        let estimates = || self.arms[arm].live.iter().map(|&variant| self.estimate(arm, variant));
        if estimates().any(|estimate| estimate.high <= tolerance) {
            Standing::Meets
        } else if estimates().all(|estimate| estimate.low > tolerance) {
            Standing::Fails
        } else {
            Standing::Open
        }
    }

    /// The variant with the least error so far.
    pub(crate) fn best_variant(&self, arm: usize) -> (usize, Estimate) {
        let estimates = self.arms[arm].live.iter().map(|&variant| (variant, self.estimate(arm, variant)));
        let better = |a: (usize, Estimate), b: (usize, Estimate)| if b.1.error < a.1.error { b } else { a };
        // The variant of the least upper end is always live.
        estimates.reduce(better).unwrap_or((0, self.estimate(arm, 0)))
    }

    /// Mean error of a variant with its interval.
    pub(crate) fn estimate(&self, arm: usize, variant: usize) -> Estimate {
        let sums = self.arms[arm].sums[variant];
        let (n, all) = (sums.count as f64, self.shuffled.len() as f64);
        if sums.count == 0 {
            return Estimate { error: 1.0, low: 0.0, high: 1.0, fragments: 0 };
        }
        let error = sums.mean();
        let half = if sums.count == self.shuffled.len() {
            0.0
        } else {
            let rest = if 2.0 * n <= all { 1.0 - (n - 1.0) / all } else { (1.0 - n / all) * (1.0 + 1.0 / n) };
            // 7 / 3 + 3 / sqrt 2
            const KAPPA: f64 = 4.454_653_676_892_976;
            sums.deviation() * (2.0 * rest * self.log_term / n).sqrt() + KAPPA * self.log_term / n
        };
        let (low, high) = ((error - half).max(0.0), (error + half).min(1.0));
        Estimate { error, low, high, fragments: sums.count }
    }
}

impl Arm {
    /// Fragments seen by the variants that are live.
    pub(crate) fn seen(&self) -> usize {
        self.live.first().map_or(0, |&variant| self.sums[variant].count)
    }
}
