//! From an experiment to its tables.

use super::bias_search::{Best, Evaluated, Fragments, evaluate, exact, failed, nothing};
use super::gains;
use super::geometry;
use super::records::{BiasRecord, CodeRecord, ComparisonRecord, GainRecord, GainSample, QuantizationRecord};
use super::settings::QuantizationExperiment;
use super::stored_technique::StoredTechnique;
use super::workload::StoredView;
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::run::Recorded;
use crate::run_directory::RecordedFile;
use crate::shards::{self, Gathered};
use crate::statistics::rounded;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::rc::Rc;

impl QuantizationExperiment {
    /// Optimises, then evaluates one way to store moments after the other.
    pub(super) fn evaluate(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        let views = StoredView::all(self)?;
        let variants = StoredTechnique::all(self)?;
        // What variants have in common, as far as it is known.
        let by_kernel: RefCell<Vec<(String, Rc<Fragments<'_>>)>> = RefCell::default();
        let fragments = |StoredTechnique { kernel_name, kernel, .. }: &StoredTechnique| {
            let known = by_kernel.borrow().iter().find(|(name, _)| name == kernel_name).cloned();
            known.map_or_else(
                || {
                    let fragments = Rc::new(Fragments::new(&views, kernel));
                    by_kernel.borrow_mut().push((kernel_name.clone(), Rc::clone(&fragments)));
                    fragments
                },
                |(_, fragments)| fragments,
            )
        };
        let exact = RefCell::new(Vec::new());
        let one = |number: usize| {
            if let Some(setting) = self.gain.get(number) {
                let (record, sample) = gains::optimised(setting, self.scenery.seed);
                return Ok(Finding::Gain(Box::new((record, sample))));
            }
            let variant = &variants[number - self.gain.len()];
            of_variant(self, variant, &fragments(variant), &exact)
                .map(|found| Finding::Variant(Box::new(found)))
        };
        let costs: Vec<u64> =
            self.gain.iter().map(|_| 1).chain(variants.iter().map(StoredTechnique::cost)).collect();
        let found = match shards::numbered(context, "gains and ways to store moments", &costs, &one)? {
            Gathered::All(found) => found,
            Gathered::Part(recorded) => return Ok(recorded),
        };
        let (mut gains, mut samples, mut tables) = (Vec::new(), Vec::new(), Tables::default());
        for finding in found {
            match finding {
                Finding::Gain(gain) => {
                    let (record, sample) = *gain;
                    gains.push(record);
                    samples.push(sample);
                }
                Finding::Variant(found) => tables.add(*found),
            }
        }
        for published in gains::all_published() {
            let record =
                gains::published(published).map_err(|error| EvaluationError::Value(error.to_string()))?;
            gains.push(record);
        }
        let mut view_rows = Vec::new();
        if let Some(variant) = variants.first() {
            let (fragments, mut first) = (fragments(variant), 0);
            for view in &views {
                let last = first + view.receivers.len();
                view_rows.push(view.record(&fragments.reference[first..last]));
                first = last;
            }
        }
        let references = match variants.first() {
            Some(first) => views.iter().flat_map(|view| view.reference_records(&first.kernel)).collect(),
            None => Vec::new(),
        };
        let comparisons = tables.comparisons(self, &variants, &views);
        let errors = gains.iter().map(|gain| &gain.error).chain(tables.records.iter().map(|row| &row.error));
        let failed = errors.filter(|error| !error.is_empty()).count();
        let trials = self.gain.len() + tables.records.len();
        let files = vec![
            RecordedFile::csv("records.csv", &tables.records)?,
            RecordedFile::csv("gains.csv", &gains)?,
            RecordedFile::csv("biases.csv", &tables.biases)?,
            RecordedFile::csv("comparison.csv", &comparisons)?,
            RecordedFile::csv("hull.csv", &geometry::hull(self.hull_points)?)?,
            RecordedFile::csv("codes.csv", &tables.codes)?,
            RecordedFile::csv("views.csv", &view_rows)?,
            RecordedFile::csv("reference.csv", &references)?,
            RecordedFile::csv("samples.csv", &samples)?,
        ];
        Ok(Recorded { files, trials, failed, complete: true })
    }
}

/// What a piece of the work has found.
#[derive(Clone, Deserialize, Serialize)]
enum Finding {
    Gain(Box<(GainRecord, GainSample)>),
    Variant(Box<Found>),
}

/// A way to store moments, and what it is compared with: every variant brings it, and the tables keep it once.
#[derive(Clone, Deserialize, Serialize)]
struct Found {
    kernel: String,
    nothing: QuantizationRecord,
    bound: String,
    exact: QuantizationRecord,
    records: Vec<QuantizationRecord>,
    biases: Vec<BiasRecord>,
    codes: Vec<CodeRecord>,
    best: Option<Best>,
}

/// G without quantisation by bound and filter, with its record.
type Exact = ((&'static str, String), Rc<(Vec<f32>, QuantizationRecord)>);

fn of_variant(
    experiment: &QuantizationExperiment,
    variant: &StoredTechnique,
    fragments: &Fragments<'_>,
    known: &RefCell<Vec<Exact>>,
) -> Result<Found, EvaluationError> {
    let key = (variant.bound_name(), variant.kernel_name.clone());
    let before = known.borrow().iter().find(|(other, _)| *other == key).map(|(_, exact)| Rc::clone(exact));
    let exact = match before {
        Some(exact) => exact,
        None => {
            let exact = Rc::new(exact(variant, fragments)?);
            known.borrow_mut().push((key, Rc::clone(&exact)));
            exact
        }
    };
    let Evaluated { records, biases, texels, best } =
        evaluate(experiment, variant, fragments, &exact.0).unwrap_or_else(|error| failed(variant, &error));
    let is_shown = variant.codes && !texels.is_empty();
    Ok(Found {
        kernel: variant.kernel_name.clone(),
        nothing: nothing(&variant.kernel_name, fragments),
        bound: variant.bound_name().to_owned(),
        exact: exact.1.clone(),
        records,
        biases,
        codes: if is_shown { geometry::codes(variant, &texels, experiment.code_bins) } else { Vec::new() },
        best,
    })
}

/// What is kept of the variants.
#[derive(Default)]
struct Tables {
    records: Vec<QuantizationRecord>,
    biases: Vec<BiasRecord>,
    codes: Vec<CodeRecord>,
    /// By variant.
    best: Vec<Option<Best>>,
    /// Kernels, and bounds with kernels, that have rows already.
    kernels: Vec<String>,
    exact: Vec<(String, String)>,
}

impl Tables {
    fn add(&mut self, found: Found) {
        if !self.kernels.contains(&found.kernel) {
            self.records.push(found.nothing);
            self.kernels.push(found.kernel.clone());
        }
        let key = (found.bound, found.kernel);
        if !self.exact.contains(&key) {
            self.records.push(found.exact);
            self.exact.push(key);
        }
        self.records.extend(found.records);
        self.biases.extend(found.biases);
        self.codes.extend(found.codes);
        self.best.push(found.best);
    }

    /// Every transform against the baseline of its store, format by format.
    fn comparisons(
        &self,
        experiment: &QuantizationExperiment,
        variants: &[StoredTechnique],
        views: &[StoredView],
    ) -> Vec<ComparisonRecord> {
        let mut records = Vec::new();
        for (variant, best) in variants.iter().zip(&self.best) {
            let Some(baseline) = &experiment.technique[variant.store].baseline else { continue };
            let other = variants.iter().zip(&self.best).find(|(other, _)| {
                (other.store, &other.format) == (variant.store, &variant.format)
                    && other.transform == *baseline
            });
            let (Some(one), Some((_, Some(other)))) = (best, other) else { continue };
            if variant.transform == *baseline {
                continue;
            }
            let differences: Vec<f64> =
                one.errors.iter().zip(&other.errors).map(|(a, b)| f64::from(*a) - f64::from(*b)).collect();
            let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
            let difference = mean(&differences);
            let squares: Vec<f64> = differences.iter().map(|d| (d - difference).powi(2)).collect();
            let l1 = |best: &Best| mean(&best.errors.iter().map(|&e| f64::from(e)).collect::<Vec<_>>());
            let mut first = 0;
            let better = |view: &&StoredView| {
                let of_view = &differences[first..first + view.receivers.len()];
                first += view.receivers.len();
                mean(of_view) < 0.0
            };
            records.push(ComparisonRecord {
                bound: variant.bound_name().to_owned(),
                format: variant.format.clone(),
                transform: variant.transform.clone(),
                baseline: baseline.clone(),
                target: one.target.name().to_owned(),
                alpha: one.alpha,
                baseline_target: other.target.name().to_owned(),
                baseline_alpha: other.alpha,
                l1_error: rounded(l1(one)),
                baseline_l1_error: rounded(l1(other)),
                difference: rounded(difference),
                standard_error: rounded((mean(&squares) / differences.len().max(1) as f64).sqrt()),
                better_views: views.iter().filter(better).count(),
                views: views.len(),
            });
        }
        records
    }
}
