//! Bounds over all fragment depths, in parallel; some of them timed alone.

use super::kernel::uniform_distribution;
use super::records::{BoundsRecord, BoundsSample, KernelRecord};
use super::settings::{BoundsExperiment, BoundsFigure, BoundsTechnique, BoundsTiming};
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::run::Recorded;
use crate::run_directory::RecordedFile;
use moment_problem::BoundMethod;
use moment_problem::{Bounds, DepthDistribution};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Kernels with at most this many different depths are also sampled at these depths.
const FEW_DEPTHS: usize = 8;

/// A proved bound may pass the true value by no more than the rounding of F itself.
const PROOF_TOLERANCE: f64 = 1e-12;

/// One bound to be computed: indices into the plan.
struct Trial {
    figure: usize,
    technique: usize,
    kernel: usize,
    z_f: f64,
}

/// The experiment with its kernels evaluated and its methods prepared.
struct BoundsPlan<'a> {
    experiment: &'a BoundsExperiment,
    texels: Vec<Vec<f64>>,
    distributions: Vec<DepthDistribution>,
    /// By figure and technique.
    methods: Vec<Vec<BoundMethod>>,
    trials: Vec<Trial>,
}

impl BoundsExperiment {
    fn plan(&self) -> Result<BoundsPlan<'_>, EvaluationError> {
        let mut texels = Vec::new();
        let mut distributions = Vec::new();
        for (i, kernel) in self.kernel.iter().enumerate() {
            let depths = kernel.depths(self.seed, i)?;
            distributions.push(uniform_distribution(&depths)?);
            texels.push(depths);
        }
        let mut methods = Vec::new();
        let mut trials = Vec::new();
        for (figure, settings) in self.figure.iter().enumerate() {
            methods
                .push(settings.technique.iter().map(BoundsTechnique::method).collect::<Result<Vec<_>, _>>()?);
            for id in &settings.kernels {
                let kernel = self.kernel_index(id)?;
                let depths = self.fragment_depths(settings, &distributions[kernel]);
                for technique in 0..settings.technique.len() {
                    trials.extend(depths.iter().map(|&z_f| Trial { figure, technique, kernel, z_f }));
                }
            }
        }
        Ok(BoundsPlan { experiment: self, texels, distributions, methods, trials })
    }

    /// The uniform grid, the depths that the figure points at, and those of a kernel that has only a few.
    fn fragment_depths(&self, figure: &BoundsFigure, z: &DepthDistribution) -> Vec<f64> {
        let count = figure.depths.unwrap_or(self.depths);
        let cells = (count - 1) as f64;
        let mut depths: Vec<f64> = (0..count).map(|i| i as f64 / cells).collect();
        depths.extend(figure.mark.iter().map(|mark| mark.depth));
        if z.depths().len() <= FEW_DEPTHS {
            depths.extend(z.depths());
        }
        depths.sort_by(f64::total_cmp);
        depths.dedup();
        depths
    }

    /// Computes all bounds in parallel, then times some alone.
    pub(super) fn evaluate(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        let plan = self.plan()?;
        let done = AtomicUsize::new(0);
        let records: Vec<BoundsRecord> = plan
            .trials
            .par_iter()
            .map(|trial| {
                let record = plan.record(trial);
                (context.progress)(done.fetch_add(1, Ordering::Relaxed) + 1, plan.trials.len());
                record
            })
            .collect();
        let samples = plan.time(&records);
        let files = vec![
            RecordedFile::csv("records.csv", &records)?,
            RecordedFile::csv("samples.csv", &samples)?,
            RecordedFile::csv("kernels.csv", &plan.kernel_records())?,
        ];
        let failed = records.iter().filter(|record| !record.error.is_empty()).count();
        Ok(Recorded { files, trials: records.len(), failed, complete: true })
    }
}

impl BoundsPlan<'_> {
    fn bounds(&self, trial: &Trial) -> Result<Bounds, moment_problem::MomentError> {
        let method = &self.methods[trial.figure][trial.technique];
        method.bounds_of(&self.distributions[trial.kernel], trial.z_f)
    }

    fn record(&self, trial: &Trial) -> BoundsRecord {
        let figure = &self.experiment.figure[trial.figure];
        let technique = &figure.technique[trial.technique];
        let z = &self.distributions[trial.kernel];
        let (mass_before, mass_up_to) = (z.cdf(trial.z_f), z.cdf_inclusive(trial.z_f));
        let mut record = BoundsRecord {
            figure: figure.id.clone(),
            kernel: self.experiment.kernel[trial.kernel].id.clone(),
            technique: technique.name.clone(),
            moments: self.methods[trial.figure][trial.technique].basis().len(),
            z_f: trial.z_f,
            mass_before,
            lower: None,
            upper: None,
            lower_proved: None,
            upper_proved: None,
            error: String::new(),
        };
        match self.bounds(trial) {
            Err(error) => record.error = error.to_string(),
            Ok(bounds) => {
                let (lower, upper) = (bounds.certificate.lower_proved, bounds.certificate.upper_proved);
                record.lower = Some(bounds.lower + 0.0);
                record.upper = Some(bounds.upper);
                record.lower_proved = Some(lower + 0.0);
                record.upper_proved = Some(upper);
                // The distribution itself is a counterexample to any bound that it breaks.
                if lower > mass_before + PROOF_TOLERANCE || upper < mass_up_to - PROOF_TOLERANCE {
                    record.error = format!(
                        "proved bounds {lower} and {upper} contradict the kernel's {mass_before} and {mass_up_to}"
                    );
                }
            }
        }
        record
    }

    /// Timed one after the other; failed trials are left out.
    fn time(&self, records: &[BoundsRecord]) -> Vec<BoundsSample> {
        let BoundsTiming { depths, repetitions } = self.experiment.timing;
        let mut samples = Vec::new();
        let same =
            |a: &Trial, b: &Trial| (a.figure, a.technique, a.kernel) == (b.figure, b.technique, b.kernel);
        let mut start = 0;
        for group in self.trials.chunk_by(same) {
            for i in 0..depths.min(group.len()) {
                let index = (2 * i + 1) * group.len() / (2 * depths.min(group.len()));
                let (trial, record) = (&group[index], &records[start + index]);
                if !record.error.is_empty() {
                    continue;
                }
                for repetition in 0..repetitions {
                    let begin = Instant::now();
                    let bounds = std::hint::black_box(self.bounds(trial));
                    let time_ns = u64::try_from(begin.elapsed().as_nanos()).unwrap_or(u64::MAX);
                    if bounds.is_err() {
                        continue;
                    }
                    samples.push(BoundsSample {
                        figure: record.figure.clone(),
                        kernel: record.kernel.clone(),
                        technique: record.technique.clone(),
                        z_f: record.z_f,
                        repetition,
                        time_ns,
                    });
                }
            }
            start += group.len();
        }
        samples
    }

    fn kernel_records(&self) -> Vec<KernelRecord> {
        let mut records = Vec::new();
        for (kernel, depths) in self.experiment.kernel.iter().zip(&self.texels) {
            records.extend(depths.iter().enumerate().map(|(texel, &depth)| KernelRecord {
                kernel: kernel.id.clone(),
                x_texel: texel % kernel.size,
                y_texel: texel / kernel.size,
                depth,
            }));
        }
        records
    }
}
