//! From settings to rankings, and what they have in common.

use super::records::{ClassRecord, FollowedRecord, VariationRecord};
use super::settings::{BASE, RankingMapExperiment, Variation};
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::kinds::search::{STEPS, Subsets, Sweep, Workload, class};
use crate::run::Recorded;
use crate::run_directory::RecordedFile;
use crate::shards::{self, Gathered};
use crate::statistics::rounded_to;
use moment_problem::BasisFunction;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Every candidate under one of the settings.
#[derive(Clone, Debug, Deserialize, Serialize)]
struct Judged {
    fragments: usize,
    programs: u64,
    exact: u64,
    uncertified: u64,
    power_error: f64,
    /// Numbers of power and trigonometric moments among the candidates.
    always: Vec<u32>,
    /// By number of the candidate; nothing where all its functions are constant on the support.
    errors: Vec<Option<f64>>,
}

/// Candidates in the order of their errors.
struct Ranking {
    /// Numbers of candidates, the least error first; those without an error are left out.
    order: Vec<usize>,
    /// By number: the place from 1; equal errors share the mean of their places.
    places: Vec<Option<f64>>,
}

impl RankingMapExperiment {
    /// Judges all candidates under all settings, the file's own first.
    pub(super) fn evaluate(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        let base = Variation { name: BASE.to_owned(), axis: "none".to_owned(), ..Variation::default() };
        let all: Vec<&Variation> = std::iter::once(&base).chain(&self.variation).collect();
        let costs: Vec<u64> = all.iter().map(|variation| self.cost(variation)).collect();
        let one = |number: usize| self.judged(all[number]);
        let judged = match shards::numbered(context, "settings", &costs, &one)? {
            Gathered::All(judged) => judged,
            Gathered::Part(recorded) => return Ok(recorded),
        };
        let functions = self.search(&base).functions()?;
        let subsets = Subsets::new(functions.len(), self.order);
        let rankings: Vec<Ranking> = judged.iter().map(|judged| Ranking::new(&judged.errors)).collect();
        let names = Names { functions: &functions, subsets: &subsets };
        let followed = self.followed(&judged[0], &rankings[0]);
        let (mut records, mut follow, mut classes) = (Vec::new(), Vec::new(), Vec::new());
        for (variation, (judged, ranking)) in all.iter().zip(judged.iter().zip(&rankings)) {
            records.push(self.record(variation, (judged, ranking), &rankings[0], &names));
            let error = |number: usize| rounded_to(judged.errors[number].unwrap_or_default(), STEPS);
            for &number in &followed {
                if let Some(rank) = ranking.order.iter().position(|&other| other == number) {
                    let (variation, basis) = (variation.name.clone(), names.basis(number));
                    follow.push(FollowedRecord { variation, basis, rank: rank + 1, l1_error: error(number) });
                }
            }
            let mut known: Vec<&str> = Vec::new();
            for (rank, &number) in ranking.order.iter().enumerate() {
                let class = names.class(number);
                if !known.contains(&class) {
                    known.push(class);
                    let (variation, basis) = (variation.name.clone(), names.basis(number));
                    let class = class.to_owned();
                    let (rank, l1_error) = (rank + 1, error(number));
                    classes.push(ClassRecord { variation, class, basis, rank, l1_error });
                }
            }
        }
        let failed = records.iter().filter(|record| !record.error.is_empty()).count();
        let trials = records.len();
        let files = vec![
            RecordedFile::csv("records.csv", &records)?,
            RecordedFile::csv("followed.csv", &follow)?,
            RecordedFile::csv("classes.csv", &classes)?,
        ];
        Ok(Recorded { files, trials, failed, complete: true })
    }

    /// What settings cost beside each other: kernels and candidates are the same, columns grow with the cells, and one scene of
    /// several has a part of the fragments.
    fn cost(&self, variation: &Variation) -> u64 {
        let scenes = if variation.scene.is_some() { 1 } else { self.scenery.scenes.len().max(1) };
        (scenes * (256 + variation.cells.unwrap_or(self.cells))) as u64
    }

    fn judged(&self, variation: &Variation) -> Result<Judged, EvaluationError> {
        let search = self.search(variation);
        let workload = Workload::prepare(&search)?;
        let sweep = Sweep::new(&search, &workload, workload.members)?;
        let numbers = sweep.subsets[0].len();
        let findings: Vec<_> =
            (0..numbers).into_par_iter().map(|number| sweep.find(0, 0, number as u32)).collect();
        let sum = |of: fn(&crate::kinds::search::Verdict) -> u32| {
            findings.iter().map(|finding| u64::from(of(&finding.verdict))).sum()
        };
        Ok(Judged {
            fragments: workload.views.iter().map(|view| view.sampled).sum(),
            programs: sum(|verdict| verdict.programs),
            exact: sum(|verdict| verdict.exact),
            uncertified: sum(|verdict| verdict.uncertified),
            power_error: sweep.controls[0][0].verdict.error,
            always: sweep.always(0),
            errors: findings
                .iter()
                .map(|finding| (!finding.is_rejected(self.order)).then_some(finding.verdict.error))
                .collect(),
        })
    }

    /// Candidates that are followed: power and trigonometric moments, then the best.
    fn followed(&self, base: &Judged, ranking: &Ranking) -> Vec<usize> {
        let mut followed: Vec<usize> = base.always.iter().map(|&number| number as usize).collect();
        let rest = ranking.order.iter().filter(|number| !base.always.contains(&(**number as u32)));
        followed.extend(rest.take(self.follow));
        followed
    }

    fn record(
        &self,
        variation: &Variation,
        (judged, ranking): (&Judged, &Ranking),
        base: &Ranking,
        names: &Names<'_>,
    ) -> VariationRecord {
        let error = |number: usize| judged.errors[number].unwrap_or_default();
        let best = ranking.order.first().copied();
        let least = best.map_or(0.0, error);
        let first = base.order.first().filter(|&&number| judged.errors[number].is_some());
        let regret = first.filter(|_| least > 0.0).map_or(0.0, |&first| error(first) / least - 1.0);
        let (own, theirs) = (ranking.best(self.best), base.best(self.best));
        let kept = theirs.iter().filter(|number| own.contains(number)).count();
        let round = |value: f64| rounded_to(value, STEPS);
        VariationRecord {
            axis: variation.axis.clone(),
            variation: variation.name.clone(),
            fragments: judged.fragments,
            candidates: ranking.order.len(),
            programs: judged.programs,
            exact: judged.exact,
            uncertified: judged.uncertified,
            power_error: round(judged.power_error),
            best: best.map(|number| names.basis(number)).unwrap_or_default(),
            best_error: round(least),
            median_error: round(
                ranking.order.get(ranking.order.len() / 2).map_or(0.0, |&number| error(number)),
            ),
            correlation: round(correlation(ranking, base, &base.order)),
            best_correlation: round(correlation(ranking, base, theirs)),
            kept: round(kept as f64 / theirs.len().max(1) as f64),
            regret: round(regret),
            error: match (best, judged.uncertified) {
                (None, _) => "no candidate has an error".to_owned(),
                (Some(_), 0) => String::new(),
                (Some(_), uncertified) => format!("{uncertified} programs without a certificate"),
            },
        }
    }
}

/// What candidates are called.
struct Names<'a> {
    functions: &'a [BasisFunction],
    subsets: &'a Subsets,
}

impl Names<'_> {
    fn functions(&self, number: usize) -> Vec<&BasisFunction> {
        self.subsets.subset(number).into_iter().map(|member| &self.functions[member]).collect()
    }

    fn basis(&self, number: usize) -> String {
        self.functions(number).iter().map(|function| function.name()).collect::<Vec<_>>().join(", ")
    }

    fn class(&self, number: usize) -> &'static str {
        class(&self.functions(number))
    }
}

impl Ranking {
    fn new(errors: &[Option<f64>]) -> Self {
        let mut known: Vec<(f64, usize)> =
            errors.iter().enumerate().filter_map(|(number, error)| Some(((*error)?, number))).collect();
        known.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut places = vec![None; errors.len()];
        let mut before = 0;
        for equal in known.chunk_by(|a, b| a.0 == b.0) {
            let place = before as f64 + 0.5 * (equal.len() + 1) as f64;
            equal.iter().for_each(|&(_, number)| places[number] = Some(place));
            before += equal.len();
        }
        Self { order: known.into_iter().map(|(_, number)| number).collect(), places }
    }

    fn best(&self, count: usize) -> &[usize] {
        &self.order[..count.min(self.order.len())]
    }
}

/// Spearman's correlation over some candidates: that of their places among each other. 1 where one of the rankings cannot tell
/// them apart.
fn correlation(a: &Ranking, b: &Ranking, among: &[usize]) -> f64 {
    let places = |ranking: &Ranking| -> Vec<Option<f64>> {
        let kept: Vec<Option<f64>> = among.iter().map(|&number| ranking.places[number]).collect();
        Ranking::new(&kept).places
    };
    let pairs: Vec<(f64, f64)> =
        places(a).into_iter().zip(places(b)).filter_map(|(a, b)| Some((a?, b?))).collect();
    let count = pairs.len().max(1) as f64;
    let (mean_a, mean_b) =
        pairs.iter().fold((0.0, 0.0), |(a, b), pair| (a + pair.0 / count, b + pair.1 / count));
    let (mut product, mut squares) = (0.0, [0.0, 0.0]);
    for (a, b) in pairs {
        let (a, b) = (a - mean_a, b - mean_b);
        product += a * b;
        squares[0] += a * a;
        squares[1] += b * b;
    }
    let size = (squares[0] * squares[1]).sqrt();
    if size > 0.0 { product / size } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranking(errors: &[f64]) -> Ranking {
        Ranking::new(&errors.iter().map(|&error| (error >= 0.0).then_some(error)).collect::<Vec<_>>())
    }

    #[test]
    fn equal_errors_share_a_place() {
        let ranked = ranking(&[0.3, 0.1, 0.1, -1.0, 0.2]);
        assert_eq!(ranked.order, [1, 2, 4, 0]);
        assert_eq!(ranked.places, [Some(4.0), Some(1.5), Some(1.5), None, Some(3.0)]);
    }

    #[test]
    fn correlation_is_spearmans() {
        let a = ranking(&[0.1, 0.2, 0.3, 0.4, 0.5]);
        let all = [0, 1, 2, 3, 4];
        assert!((correlation(&a, &ranking(&[1.0, 2.0, 3.0, 4.0, 9.0]), &all) - 1.0).abs() < 1e-15);
        assert!((correlation(&a, &ranking(&[5.0, 4.0, 3.0, 2.0, 1.0]), &all) + 1.0).abs() < 1e-15);
        // 1 - 6 (1 + 1) / (5 (25 - 1)) for two neighbours that have changed places.
        let swapped = ranking(&[0.2, 0.1, 0.3, 0.4, 0.5]);
        assert!((correlation(&a, &swapped, &all) - 0.9).abs() < 1e-15);
        assert!((correlation(&a, &swapped, &[0, 1]) + 1.0).abs() < 1e-15);
        assert_eq!(correlation(&a, &ranking(&[1.0, 1.0, 1.0, 1.0, 1.0]), &all), 1.0);
    }
}
