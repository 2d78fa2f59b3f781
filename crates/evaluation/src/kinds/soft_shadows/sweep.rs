//! One parameter varied on its own: what it does to the error, and where a method breaks.

use super::method::MethodSetting;
use super::records::SweepRecord;
use super::settings::{SoftShadowsExperiment, SoftTechnique};
use super::statistics::{WIDTHS, width_class};
use super::view::{SoftView, truths};
use crate::error::EvaluationError;
use crate::fragments::spread;
use crate::statistics::{percentile, rounded};
use applications::field::Table;
use applications::soft_shadow::{AreaTruth, SoftReceiver, SoftShadow};
use rayon::prelude::*;
use scenes::{AreaLight, Outline};
use serde::{Deserialize, Serialize};

/// A parameter with its values.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SweepValues {
    /// Weight of the receiver in the average blocker depth.
    Epsilon(Vec<f64>),
    /// alpha.
    MomentBias(Vec<f64>),
    /// N over the texels of the largest region.
    Region(Vec<f64>),
    /// How sums are held.
    Table(Vec<Table>),
    /// Share of blockers above which a receiver is in the umbra.
    Umbra(Vec<f64>),
    /// Angular size of the light in both directions; its truth is found anew.
    Degrees(Vec<f64>),
}

/// One parameter varied.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// Name in records.
    pub id: String,
    /// Names of techniques.
    pub techniques: Vec<String>,
    /// Name of the light.
    pub light: String,
    /// The parameter.
    pub values: SweepValues,
}

/// An answer may differ from that of exact moments by a step of an image.
pub(super) const VISIBLE: f64 = 1.0 / 255.0;

/// A changed method, and the light where that is what changes.
struct Variant {
    technique: usize,
    setting: String,
    value: Option<f64>,
    method: MethodSetting,
    degrees: Option<f64>,
}

/// One receiver under one variant.
#[derive(Clone, Copy, Deserialize, Serialize)]
struct Trial {
    class: usize,
    /// `None` where the query was refused.
    answer: Option<f64>,
    truth: f64,
    exact: f64,
}

/// With an exponent where that is shorter.
fn written(value: f64) -> String {
    if value == 0.0 || value >= 1e-3 { format!("{value}") } else { format!("{value:e}") }
}

/// Trials of all variants of all sweeps, by sweep and variant.
#[derive(Clone, Default, Deserialize, Serialize)]
pub(super) struct Sweeps {
    trials: Vec<Vec<Vec<Trial>>>,
}

impl Sweep {
    fn variants(&self, techniques: &[usize], all: &[SoftTechnique]) -> Vec<Variant> {
        let of = |&technique: &usize| {
            let base = &all[technique].method;
            let numbers = |values: &[f64], change: &dyn Fn(f64) -> MethodSetting| -> Vec<Variant> {
                let variant = |&value: &f64| Variant {
                    technique,
                    setting: written(value),
                    value: Some(value),
                    method: change(value),
                    degrees: None,
                };
                values.iter().map(variant).collect()
            };
            match &self.values {
                SweepValues::Epsilon(values) => {
                    numbers(values, &|value| MethodSetting { epsilon: Some(value), ..base.clone() })
                }
                SweepValues::MomentBias(values) => {
                    numbers(values, &|value| MethodSetting { moment_bias: Some(value), ..base.clone() })
                }
                SweepValues::Region(values) => {
                    numbers(values, &|value| MethodSetting { region: Some(value), ..base.clone() })
                }
                SweepValues::Umbra(values) => {
                    numbers(values, &|value| MethodSetting { umbra: Some(value), ..base.clone() })
                }
                SweepValues::Table(tables) => {
                    let variant = |&table: &Table| Variant {
                        technique,
                        setting: format!("{table:?}").to_lowercase(),
                        value: None,
                        method: MethodSetting { table, ..base.clone() },
                        degrees: None,
                    };
                    tables.iter().map(variant).collect()
                }
                SweepValues::Degrees(values) => {
                    let mut variants = numbers(values, &|_| base.clone());
                    variants.iter_mut().for_each(|variant| variant.degrees = variant.value);
                    variants
                }
            }
        };
        techniques.iter().flat_map(of).collect()
    }

    pub(super) fn check(&self, all: &[SoftTechnique], place: &str) -> Result<(), EvaluationError> {
        let key = format!("{place}.values");
        let techniques: Vec<usize> =
            (0..all.len()).filter(|&i| self.techniques.contains(&all[i].name)).collect();
        let variants = self.variants(&techniques, all);
        if variants.is_empty() {
            return Err(EvaluationError::key(key, format!("sweep `{}` has no values", self.id)));
        }
        for variant in variants {
            let name = &all[variant.technique].name;
            if let Some(degrees) = variant.degrees {
                AreaLight::sun(Outline::Rectangle, [degrees; 2]).map_err(|error| {
                    EvaluationError::key(key.as_str(), format!("sweep `{}`: {error}", self.id))
                })?;
            }
            variant.method.check(name, "").map_err(|error| {
                EvaluationError::key(key.as_str(), format!("sweep `{}`: {error}", self.id))
            })?;
        }
        Ok(())
    }
}

impl Sweeps {
    /// Trials of later views behind those of earlier ones.
    pub(super) fn merge(&mut self, later: &Self) {
        self.trials.resize_with(self.trials.len().max(later.trials.len()), Vec::new);
        for (mine, theirs) in self.trials.iter_mut().zip(&later.trials) {
            mine.resize_with(mine.len().max(theirs.len()), Vec::new);
            mine.iter_mut().zip(theirs).for_each(|(mine, theirs)| mine.extend(theirs));
        }
    }

    /// Adds all sweeps of a view under a light. `classes` and `truth` are those of all fragments.
    pub(super) fn add(
        &mut self,
        experiment: &SoftShadowsExperiment,
        (view, light): (&SoftView<'_>, usize),
        (truth, known, widths): (&AreaTruth, &[f64], &[f64]),
    ) -> Result<(), EvaluationError> {
        let sweeps = experiment.sweep.iter().enumerate();
        self.trials.resize_with(experiment.sweep.len(), Vec::new);
        let area_light = experiment.light[light].of(view.light, &format!("light[{light}]"))?;
        let lit = view.lit(&area_light, truth);
        for (index, sweep) in sweeps {
            let place = format!("sweep[{index}]");
            if experiment.lit_by(&sweep.light, &place)? != light {
                continue;
            }
            let techniques = experiment.named(&sweep.techniques, &place)?;
            let variants = sweep.variants(&techniques, &experiment.technique);
            self.trials[index].resize_with(variants.len(), Vec::new);
            let chosen = spread(view.points[0].len(), experiment.sweep_fragments);
            let receivers: Vec<SoftReceiver> =
                chosen.iter().map(|&i| view.receiver(&view.points[0][i], &experiment.bias[0])).collect();
            let facts: Vec<(f64, usize)> =
                chosen.iter().map(|&i| (known[i], width_class(widths[i]))).collect();
            let mut before: Option<(f64, Vec<(f64, usize)>)> = None;
            for (trials, variant) in self.trials[index].iter_mut().zip(&variants) {
                let Some(degrees) = variant.degrees else {
                    trials.extend(tried(&lit, &receivers, &facts, &variant.method)?);
                    continue;
                };
                let outline = lit.light.outline;
                let sized = AreaLight::sun(outline, [degrees; 2])
                    .map_err(|error| EvaluationError::key(place.as_str(), error.to_string()))?;
                let lit = view.lit(&sized, truth);
                // Techniques come one after the other, and the truth is that of the light alone.
                let facts = match before.take() {
                    Some((same, facts)) if same == degrees => facts,
                    Some(_) | None => {
                        let found = truths(&lit, &receivers);
                        let classified = receivers.par_iter().map(|receiver| view.classified(&lit, receiver));
                        let widths: Vec<f64> = classified.map(|(width, _)| width).collect();
                        let facts = found.iter().zip(&widths);
                        facts.map(|(found, &width)| (found.fraction, width_class(width))).collect()
                    }
                };
                trials.extend(tried(&lit, &receivers, &facts, &variant.method)?);
                before = Some((degrees, facts));
            }
        }
        Ok(())
    }

    /// The rows, by sweep, variant and class.
    pub(super) fn records(
        &self,
        experiment: &SoftShadowsExperiment,
    ) -> Result<Vec<SweepRecord>, EvaluationError> {
        let mut records = Vec::new();
        for (index, (sweep, trials)) in experiment.sweep.iter().zip(&self.trials).enumerate() {
            let techniques = experiment.named(&sweep.techniques, &format!("sweep[{index}].techniques"))?;
            let variants = sweep.variants(&techniques, &experiment.technique);
            for (variant, trials) in variants.iter().zip(trials) {
                for class in [None].into_iter().chain((0..WIDTHS.len()).map(Some)) {
                    let members: Vec<Trial> = trials
                        .iter()
                        .filter(|trial| class.is_none_or(|class| trial.class == class))
                        .copied()
                        .collect();
                    let name = class.map_or("all", |class| WIDTHS[class]);
                    let technique = &experiment.technique[variant.technique].name;
                    records.push(record((&sweep.id, technique, variant, name), &members));
                }
            }
        }
        Ok(records)
    }
}

/// A method at all receivers.
fn tried(
    lit: &SoftShadow<'_>,
    receivers: &[SoftReceiver],
    facts: &[(f64, usize)],
    method: &MethodSetting,
) -> Result<Vec<Trial>, EvaluationError> {
    // A table that cannot be made refuses every query.
    let prepared = method.prepare(lit.map, &lit.penumbra).ok();
    let fail = |error: String| EvaluationError::Value(format!("exact moments: {error}"));
    let exact = method.exact().prepare(lit.map, &lit.penumbra).map_err(|error| fail(error.to_string()))?;
    let one = |(receiver, &(truth, class)): (&SoftReceiver, &(f64, usize))| {
        let answer = prepared.as_ref().and_then(|method| method.estimate(lit, receiver).ok());
        let exact = exact.estimate(lit, receiver).map_err(|error| fail(error.to_string()))?;
        Ok(Trial { class, answer, truth, exact })
    };
    receivers.par_iter().zip(facts).map(one).collect()
}

fn record((sweep, technique, variant, class): (&str, &str, &Variant, &str), trials: &[Trial]) -> SweepRecord {
    let valid = |answer: f64| (0.0..=1.0).contains(&answer);
    let answered: Vec<(f64, &Trial)> = trials
        .iter()
        .filter_map(|trial| Some((trial.answer.filter(|&answer| valid(answer))?, trial)))
        .collect();
    let count = answered.len().max(1) as f64;
    let mut errors: Vec<f64> = answered.iter().map(|(answer, trial)| (answer - trial.truth).abs()).collect();
    errors.sort_by(f64::total_cmp);
    let change = |(answer, trial): &(f64, &Trial)| (answer - trial.exact).abs();
    SweepRecord {
        sweep: sweep.to_owned(),
        technique: technique.to_owned(),
        setting: variant.setting.clone(),
        value: variant.value,
        class: class.to_owned(),
        receivers: trials.len(),
        mean_error: rounded(errors.iter().sum::<f64>() / count),
        signed_mean: rounded(
            answered.iter().map(|(answer, trial)| answer - trial.truth).sum::<f64>() / count,
        ),
        p95: rounded(percentile(&errors, 0.95)),
        refused: trials.iter().filter(|trial| trial.answer.is_none()).count(),
        not_finite: trials.iter().filter(|trial| trial.answer.is_some_and(|answer| !valid(answer))).count(),
        changed: answered.iter().filter(|one| change(one) > VISIBLE).count(),
        mean_change: rounded(answered.iter().map(change).sum::<f64>() / count),
        largest_change: rounded(answered.iter().map(change).fold(0.0, f64::max)),
    }
}
