//! Racing candidates on growing samples until the cheapest that meets a tolerance is certain.
//!
//! All receivers of all views are shuffled once; a candidate looks at the first 2^r blocks of them in its round r, so that
//! earlier work is kept and the last round has seen every receiver. The intervals are those of Bardenet and Maillard (2015, Theorem 4,
//! "Concentration inequalities for sampling without replacement"): errors lie in \[0, 1\], nothing else is assumed. All
//! intervals of a race hold together with probability [`CONFIDENCE`].

use crate::error::EvaluationError;
use crate::statistics::Sums;
use random_stream::Random;
use rayon::prelude::*;
use std::ops::Range;

/// Receivers of the first round: as few as make the widest candidates stand apart.
pub(super) const FIRST_ROUND: usize = 4096;

/// Probability that all intervals of a race hold.
pub(super) const CONFIDENCE: f64 = 0.999;

/// Stream of random numbers of the shuffle, apart from those of samples.
const SHUFFLE_STREAM: u64 = 1 << 33;

/// What is raced: candidates, each at a cost and with variants of equal cost, on receivers in a random order.
pub(super) trait Course {
    /// Cost and number of variants of each candidate, by cost, ascending.
    fn arms(&self) -> Vec<(f64, usize)>;

    /// Receivers there are.
    fn receivers(&self) -> usize;

    /// Receivers that are asked at most; beyond them, what is open stays open.
    fn most(&self) -> usize {
        self.receivers()
    }

    /// Sums of estimate - truth over a range of the shuffled receivers, for some variants of a candidate.
    fn sums(
        &mut self,
        arm: usize,
        range: Range<usize>,
        variants: &[usize],
    ) -> Result<Vec<Sums>, EvaluationError>;
}

/// An error with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Estimate {
    pub(super) error: f64,
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) receivers: usize,
}

/// A candidate.
pub(super) struct Arm {
    pub(super) cost: f64,
    /// Shuffled receivers that the live variants have seen.
    pub(super) seen: usize,
    /// By variant.
    sums: Vec<Sums>,
    /// Variants that may still be the best of the arm.
    live: Vec<usize>,
}

/// The race.
pub(super) struct Race<C> {
    pub(super) course: C,
    /// By cost, ascending.
    pub(super) arms: Vec<Arm>,
    /// ln(5 / delta) for one interval.
    log_term: f64,
    pub(super) evaluations: usize,
}

/// Where an arm stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Standing {
    Meets,
    Fails,
    Open,
}

/// Numbers of views and receivers in a random order, each once; `counts` are receivers by view.
pub(super) fn shuffled(counts: impl Iterator<Item = usize>, seed: u64) -> Vec<(u32, u32)> {
    let all = counts.enumerate().flat_map(|(view, count)| (0..count).map(move |i| (view as u32, i as u32)));
    let mut shuffled: Vec<(u32, u32)> = all.collect();
    let random = &mut Random::substream(seed, SHUFFLE_STREAM, 0);
    for i in (1..shuffled.len()).rev() {
        let other = (random.unit() * (i + 1) as f64) as usize;
        shuffled.swap(i, other.min(i));
    }
    shuffled
}

/// A range of shuffled receivers view by view, within a view in the order of the map, for the sake of its caches: each view
/// with places in the shuffled order.
pub(super) fn by_view(shuffled: &[(u32, u32)], range: Range<usize>) -> Vec<(usize, Vec<usize>)> {
    let mut order: Vec<usize> = range.collect();
    order.sort_unstable_by_key(|&i| shuffled[i]);
    order
        .chunk_by(|&a, &b| shuffled[a].0 == shuffled[b].0)
        .map(|group| (shuffled[group[0]].0 as usize, group.to_vec()))
        .collect()
}

/// Adds what `of_chunk` says of places, chunk by chunk of a fixed size and in their order: sums do not depend on the number of
/// threads.
pub(super) fn add_chunks(
    sums: &mut [Sums],
    places: &[usize],
    chunk: usize,
    of_chunk: impl Fn(&[usize]) -> Vec<Sums> + Send + Sync,
) {
    let chunks: Vec<Vec<Sums>> = places.par_chunks(chunk).map(of_chunk).collect();
    for chunk in &chunks {
        sums.iter_mut().zip(chunk).for_each(|(sums, more)| sums.add(more));
    }
}

impl<C: Course> Race<C> {
    pub(super) fn new(course: C) -> Self {
        let arm = |(cost, variants): (f64, usize)| Arm {
            cost,
            seen: 0,
            sums: vec![Sums::default(); variants],
            live: (0..variants).collect(),
        };
        let arms: Vec<Arm> = course.arms().into_iter().map(arm).collect();
        let rounds = 1 + course.most().div_ceil(FIRST_ROUND).next_power_of_two().ilog2();
        let intervals: usize = arms.iter().map(|arm| arm.sums.len()).sum::<usize>() * rounds as usize;
        let log_term = (5.0 * intervals as f64 / (1.0 - CONFIDENCE)).ln();
        Self { course, arms, log_term, evaluations: 0 }
    }

    /// Lets every arm see the first receivers.
    pub(super) fn look(&mut self, progress: &dyn Fn(usize, usize)) -> Result<(), EvaluationError> {
        let arms = self.arms.len();
        for arm in 0..arms {
            self.extend(arm, FIRST_ROUND)?;
            progress(arm + 1, 2 * arms);
        }
        Ok(())
    }

    /// The cheapest arm that meets the tolerance, or `None` if none does for certain; `progress` hears of arms that are
    /// decided.
    ///
    /// All cheaper arms have to be refuted, whatever the order, and costlier ones need no more than a first look. So arms
    /// are decided one after another, the cheapest first.
    pub(super) fn run(
        &mut self,
        tolerance: f64,
        progress: &dyn Fn(usize, usize),
    ) -> Result<Option<usize>, EvaluationError> {
        let arms = self.arms.len();
        for arm in 0..arms {
            let standing = self.decided(arm, tolerance)?;
            progress(arms + arm + 1, 2 * arms);
            if standing == Standing::Meets {
                return Ok(Some(arm));
            }
        }
        Ok(None)
    }

    /// Where an arm stands once it has seen enough; open only where it has seen all it may.
    pub(super) fn decided(&mut self, arm: usize, tolerance: f64) -> Result<Standing, EvaluationError> {
        loop {
            let standing = self.standing(arm, tolerance);
            if standing != Standing::Open || self.arms[arm].seen >= self.limit() {
                return Ok(standing);
            }
            self.extend(arm, (2 * self.arms[arm].seen).max(FIRST_ROUND))?;
        }
    }

    fn limit(&self) -> usize {
        self.course.most().min(self.course.receivers())
    }

    /// Lets an arm see the first `upto` receivers.
    pub(super) fn extend(&mut self, arm: usize, upto: usize) -> Result<(), EvaluationError> {
        let upto = upto.min(self.limit());
        let (from, live) = (self.arms[arm].seen, self.arms[arm].live.clone());
        if upto <= from {
            return Ok(());
        }
        let sums = self.course.sums(arm, from..upto, &live)?;
        for (&variant, more) in live.iter().zip(&sums) {
            self.arms[arm].sums[variant].add(more);
        }
        self.arms[arm].seen = upto;
        self.evaluations += upto - from;
        let least = live.iter().map(|&v| self.estimate(arm, v).high).fold(f64::INFINITY, f64::min);
        let kept: Vec<usize> = live.into_iter().filter(|&v| self.estimate(arm, v).low <= least).collect();
        self.arms[arm].live = kept;
        Ok(())
    }

    pub(super) fn standing(&self, arm: usize, tolerance: f64) -> Standing {
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
    pub(super) fn best_variant(&self, arm: usize) -> (usize, Estimate) {
        let estimates = self.arms[arm].live.iter().map(|&variant| (variant, self.estimate(arm, variant)));
        let better = |a: (usize, Estimate), b: (usize, Estimate)| if b.1.error < a.1.error { b } else { a };
        // The variant of the least upper end is always live.
        estimates.reduce(better).unwrap_or((0, self.estimate(arm, 0)))
    }

    /// Its error.
    pub(super) fn error(&self, arm: usize) -> Estimate {
        self.best_variant(arm).1
    }

    /// Mean error of a variant with its interval.
    pub(super) fn estimate(&self, arm: usize, variant: usize) -> Estimate {
        let sums = self.arms[arm].sums[variant];
        let (n, all) = (sums.count as f64, self.course.receivers() as f64);
        if sums.count == 0 {
            return Estimate { error: 1.0, low: 0.0, high: 1.0, receivers: 0 };
        }
        let error = sums.mean();
        let half = if self.arms[arm].seen == self.course.receivers() {
            0.0
        } else {
            let rest = if 2.0 * n <= all { 1.0 - (n - 1.0) / all } else { (1.0 - n / all) * (1.0 + 1.0 / n) };
            // 7 / 3 + 3 / sqrt 2
            const KAPPA: f64 = 4.454_653_676_892_976;
            sums.deviation() * (2.0 * rest * self.log_term / n).sqrt() + KAPPA * self.log_term / n
        };
        let (low, high) = ((error - half).max(0.0), (error + half).min(1.0));
        Estimate { error, low, high, receivers: sums.count }
    }
}
