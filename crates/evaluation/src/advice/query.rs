//! The question that is put to every application: the cheapest candidate within a tolerance, or the most accurate within a
//! budget, and its neighbours.

use super::race::{Course, Estimate, Race, Standing};
use crate::error::EvaluationError;
use crate::run::Progress;
use serde::Serialize;

/// What is accepted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    /// Largest mean error; without it what suits the scene.
    pub(super) tolerance: Option<f64>,
    /// Largest share of what doing nothing errs by.
    pub(super) relative: f64,
    /// Whether the most accurate is wanted, of those that a budget has left, and not the cheapest.
    pub(super) most_accurate: bool,
    /// Receivers that a candidate in the answer has seen, at least.
    pub(super) shown: usize,
}

/// Without a tolerance this much more is accepted than the most accurate candidate errs by: less than what tells one
/// technique from the next in most scenes ...
const SLACK: f64 = 1.25;

/// ... but one step of an 8-bit display is always accepted, for nobody sees less.
const VISIBLE: f64 = 1.0 / 255.0;

/// What is better errs at least a tenth less.
const BETTER: f64 = 0.9;

/// Candidates whose errors differ by less than a tenth ...
const NEAR_ERROR: f64 = 1.1;

/// ... and whose costs differ by less than a quarter are near ties: the model of cost knows no better.
const NEAR_COST: f64 = 1.25;

/// Near ties that are named.
const MOST_TIES: usize = 4;

/// The answer, in numbers of arms or whatever stands for them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer<C> {
    /// Largest mean error that is accepted: as given, or 1.25 times what the most accurate candidate reaches for certain, one
    /// step of an 8-bit display at least.
    pub tolerance: f64,
    /// Whether it was given.
    pub tolerance_is_given: bool,
    /// Largest accepted share of what doing nothing errs by.
    pub relative: f64,
    /// The tolerance that the most accurate candidate meets for certain.
    pub reachable: Option<f64>,
    /// The cheapest that meets the tolerance and errs no more than the accepted share of doing nothing, or with a budget and no
    /// tolerance the most accurate; `None` if none does, or if nothing is in shadow.
    pub recommendation: Option<C>,
    /// Of the cheaper ones, which do not meet both, the most accurate.
    pub next_cheaper: Option<C>,
    /// The cheapest that errs at least a tenth less, or if there is none the most accurate that errs less at all; without
    /// a recommendation the most accurate of all. `None`: of the costlier ones none erred less.
    pub next_better: Option<C>,
    /// As good as the recommended one: errors within a tenth, costs within a quarter.
    pub near_ties: Vec<C>,
    /// Cheaper than the recommended one and not refuted by all receivers that were asked.
    pub undecided: Vec<C>,
    /// Combinations that were raced.
    pub candidates: usize,
    /// Share of the work of evaluating every technique, format and size on every receiver that was done.
    pub evaluated_share: f64,
}

impl<C> Answer<C> {
    /// The same with something else in place of each candidate.
    pub(super) fn map<D>(self, mut each: impl FnMut(C) -> D) -> Answer<D> {
        Answer {
            tolerance: self.tolerance,
            tolerance_is_given: self.tolerance_is_given,
            relative: self.relative,
            reachable: self.reachable,
            recommendation: self.recommendation.map(&mut each),
            next_cheaper: self.next_cheaper.map(&mut each),
            next_better: self.next_better.map(&mut each),
            near_ties: self.near_ties.into_iter().map(&mut each).collect(),
            undecided: self.undecided.into_iter().map(&mut each).collect(),
            candidates: self.candidates,
            evaluated_share: self.evaluated_share,
        }
    }
}

/// Asks. `nothing` is what doing nothing errs by, at least; 0 where nothing is in shadow, and nothing to recommend.
pub(super) fn answered<C: Course>(
    race: &mut Race<C>,
    wanted: &Wanted,
    nothing: f64,
    progress: Progress<'_>,
) -> Result<Answer<usize>, EvaluationError> {
    let mut answer = Answer {
        tolerance: wanted.tolerance.unwrap_or(VISIBLE),
        tolerance_is_given: wanted.tolerance.is_some(),
        relative: wanted.relative,
        reachable: None,
        recommendation: None,
        next_cheaper: None,
        next_better: None,
        near_ties: Vec::new(),
        undecided: Vec::new(),
        candidates: race.course.arms().iter().map(|(_, variants)| variants).sum(),
        evaluated_share: 0.0,
    };
    if nothing > 0.0 && !race.arms.is_empty() {
        race.look(progress)?;
        let all = race.arms.len();
        let best = |race: &mut Race<C>| settled(race, wanted.shown, |race| least_error(race, 0..all));
        if wanted.tolerance.is_none()
            && let Some(best) = best(race)?
        {
            answer.tolerance = (SLACK * race.error(best).high).max(VISIBLE);
        }
        let limit = answer.tolerance.min(wanted.relative * nothing);
        let winner = if wanted.most_accurate && wanted.tolerance.is_none() {
            best(race)?.filter(|&best| race.error(best).high <= limit)
        } else {
            race.run(limit, progress)?
        };
        match winner {
            Some(winner) => {
                race.extend(winner, wanted.shown)?;
                answer.recommendation = Some(winner);
                answer.next_cheaper = settled(race, wanted.shown, |race| least_error(race, 0..winner))?;
                answer.next_better = better_than(race, winner, wanted.shown)?;
                answer.near_ties = near_ties(race, winner, wanted.shown)?;
                answer.undecided =
                    (0..winner).filter(|&arm| race.standing(arm, limit) == Standing::Open).collect();
            }
            None => answer.next_better = best(race)?,
        }
        let reached = race.arms.iter().enumerate().map(|(arm, _)| race.error(arm).high);
        answer.reachable = reached.reduce(f64::min);
    }
    let work = race.course.receivers() * race.arms.len();
    answer.evaluated_share = race.evaluations as f64 / work.max(1) as f64;
    Ok(answer)
}

/// The cheapest of the costlier arms that errs at least a tenth less than this one, else the most accurate of those that
/// err less.
fn better_than<C: Course>(
    race: &mut Race<C>,
    winner: usize,
    shown: usize,
) -> Result<Option<usize>, EvaluationError> {
    let error = race.error(winner).error;
    let errs_less = |race: &Race<C>, arm: usize, share: f64| race.error(arm).error < share * error;
    let clearly =
        settled(race, shown, |race| (winner + 1..race.arms.len()).find(|&arm| errs_less(race, arm, BETTER)))?;
    if clearly.is_some() {
        return Ok(clearly);
    }
    settled(race, shown, |race| {
        least_error(race, winner + 1..race.arms.len()).filter(|&arm| errs_less(race, arm, 1.0))
    })
}

/// Those that the winner is not clearly better than, the nearest in error first.
fn near_ties<C: Course>(
    race: &mut Race<C>,
    winner: usize,
    shown: usize,
) -> Result<Vec<usize>, EvaluationError> {
    let cost = race.arms[winner].cost;
    let within = |a: f64, b: f64, factor: f64| a <= factor * b && b <= factor * a;
    let is_near =
        |race: &Race<C>, arm: usize| within(race.error(arm).error, race.error(winner).error, NEAR_ERROR);
    let mut near = Vec::new();
    for arm in (0..race.arms.len()).filter(|&arm| arm != winner) {
        if within(race.arms[arm].cost, cost, NEAR_COST) && is_near(race, arm) {
            race.extend(arm, shown)?;
            if is_near(race, arm) {
                near.push(arm);
            }
        }
    }
    let distance = |arm: &usize| (race.error(*arm).error - race.error(winner).error).abs();
    near.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    near.truncate(MOST_TIES);
    Ok(near)
}

/// What `choose` names once it has seen enough of it: the choice may change as more is seen.
fn settled<C: Course>(
    race: &mut Race<C>,
    shown: usize,
    choose: impl Fn(&Race<C>) -> Option<usize>,
) -> Result<Option<usize>, EvaluationError> {
    let enough = shown.min(race.course.receivers()).min(race.course.most());
    while let Some(arm) = choose(race) {
        if race.arms[arm].seen >= enough {
            return Ok(Some(arm));
        }
        race.extend(arm, enough)?;
    }
    Ok(None)
}

fn least_error<C: Course>(race: &Race<C>, arms: std::ops::Range<usize>) -> Option<usize> {
    let error = |arm: usize| race.error(arm).error;
    arms.reduce(|a, b| if error(b) < error(a) { b } else { a })
}

/// An error as it is told; `nothing` is what doing nothing errs by, above 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// Mean of |estimate - truth| over the receivers seen.
    pub l1_error: f64,
    /// Lower end of its interval.
    pub l1_error_low: f64,
    /// Upper end.
    pub l1_error_high: f64,
    /// `l1_error` over what doing nothing errs by.
    pub relative_error: f64,
    /// Lower end of its interval.
    pub relative_error_low: f64,
    /// Upper end.
    pub relative_error_high: f64,
    /// Receivers seen; with all of them the interval is a point.
    pub fragments: usize,
}

impl Measured {
    pub(super) fn new(estimate: Estimate, nothing: f64) -> Self {
        let Estimate { error, low, high, receivers } = estimate;
        Self {
            l1_error: error,
            l1_error_low: low,
            l1_error_high: high,
            relative_error: error / nothing,
            relative_error_low: low / nothing,
            relative_error_high: high / nothing,
            fragments: receivers,
        }
    }
}
