//! From an experiment to its tables.

use super::bias_search::{Best, Evaluated, Fragments, evaluate, exact, failed};
use super::gains;
use super::geometry;
use super::records::{ComparisonRecord, QuantizationRecord};
use super::settings::QuantizationExperiment;
use super::stored_technique::StoredTechnique;
use super::workload::StoredView;
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::run::Recorded;
use crate::run_directory::RecordedFile;
use crate::statistics::rounded;

impl QuantizationExperiment {
    /// Optimises, then evaluates one way to store moments after the other.
    pub(super) fn evaluate(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        let views = StoredView::all(self)?;
        let variants = StoredTechnique::all(self)?;
        let total = self.gain.len() + variants.len();
        let (mut gains, mut samples) = (Vec::new(), Vec::new());
        for (done, setting) in self.gain.iter().enumerate() {
            let (record, sample) = gains::optimised(setting, self.scenery.seed);
            gains.push(record);
            samples.push(sample);
            (context.progress)(done + 1, total);
        }
        for published in gains::all_published() {
            let record =
                gains::published(published).map_err(|error| EvaluationError::Value(error.to_string()))?;
            gains.push(record);
        }
        let mut tables = Tables::default();
        let mut by_kernel: Vec<(String, Fragments<'_>)> = Vec::new();
        for (done, variant) in variants.iter().enumerate() {
            let known = by_kernel.iter().position(|(name, _)| *name == variant.kernel_name);
            let place = known.unwrap_or_else(|| {
                let fragments = Fragments::new(&views, &variant.kernel);
                by_kernel.push((variant.kernel_name.clone(), fragments));
                by_kernel.len() - 1
            });
            tables.add(self, variant, &by_kernel[place].1)?;
            (context.progress)(self.gain.len() + done + 1, total);
        }
        let mut view_rows = Vec::new();
        if let Some((_, fragments)) = by_kernel.first() {
            let mut first = 0;
            for view in &views {
                let last = first + view.receivers.len();
                view_rows.push(view.record(&fragments.reference[first..last]));
                first = last;
            }
        }
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
            RecordedFile::csv("samples.csv", &samples)?,
        ];
        Ok(Recorded { files, trials, failed, complete: true })
    }
}

/// What is kept of the variants.
#[derive(Default)]
struct Tables {
    records: Vec<QuantizationRecord>,
    biases: Vec<super::records::BiasRecord>,
    codes: Vec<super::records::CodeRecord>,
    /// By variant.
    best: Vec<Option<Best>>,
    /// G without quantisation by bound and filter.
    exact: Vec<((&'static str, String), Vec<f32>)>,
}

impl Tables {
    fn add(
        &mut self,
        experiment: &QuantizationExperiment,
        variant: &StoredTechnique,
        fragments: &Fragments<'_>,
    ) -> Result<(), EvaluationError> {
        let key = (variant.bound_name(), variant.kernel_name.clone());
        let known = self.exact.iter().position(|(known, _)| *known == key);
        let place = match known {
            Some(place) => place,
            None => {
                let (intensities, record) = exact(variant, fragments)?;
                self.records.push(record);
                self.exact.push((key, intensities));
                self.exact.len() - 1
            }
        };
        let exact = &self.exact[place].1;
        let Evaluated { records, biases, texels, best } =
            evaluate(experiment, variant, fragments, exact).unwrap_or_else(|error| failed(variant, &error));
        self.records.extend(records);
        self.biases.extend(biases);
        self.best.push(best);
        if variant.codes && !texels.is_empty() {
            self.codes.extend(geometry::codes(variant, &texels, experiment.code_bins));
        }
        Ok(())
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
