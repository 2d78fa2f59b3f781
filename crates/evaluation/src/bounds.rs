//! Experiments of kind `bounds`: bounds over all fragment depths, for kernels and bases (MSM15 Figures 2 and 3).

use crate::error::EvaluationError;
use crate::kernel::{Kernel, uniform_distribution};
use crate::method::{Domain, Method, Solver, method};
use crate::run::{Progress, Recorded};
use crate::run_directory::RecordedFile;
use moment_problem::{Basis, Bounds, DepthDistribution};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Kernels with at most this many different depths are also sampled at these depths.
const FEW_DEPTHS: usize = 8;

/// Largest accepted number of fragment depths.
const MAX_DEPTHS: usize = 100_001;

/// A proved bound may pass the true value by no more than the rounding of F itself.
const PROOF_TOLERANCE: f64 = 1e-12;

/// The TOML keys of this kind, beside `kind` and `scale`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BoundsExperiment {
    /// What is asked.
    pub question: String,
    /// What is expected, written before the first run.
    pub expectation: String,
    /// Seed of rough and scattered surfaces.
    pub seed: u64,
    /// Number of fragment depths, evenly spaced from 0 to 1.
    pub depths: usize,
    /// What is timed after all errors are known.
    pub timing: Timing,
    /// The kernels.
    pub kernel: Vec<Kernel>,
    /// The figures.
    pub figure: Vec<Figure>,
}

/// Timed bounds per kernel and technique.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Timing {
    /// Fragment depths, spread over the recorded ones.
    pub depths: usize,
    /// How often each is timed.
    pub repetitions: usize,
}

/// One figure: techniques on kernels.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// File name without extension, and its name in the records.
    pub id: String,
    /// Title.
    pub title: String,
    /// Number of fragment depths in place of the experiment's.
    pub depths: Option<usize>,
    /// Kernels, one column of charts each.
    pub kernels: Vec<String>,
    /// Techniques.
    pub technique: Vec<Technique>,
    /// Arrows at fragment depths.
    #[serde(default)]
    pub mark: Vec<Mark>,
}

/// A basis, its interval and the method.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Technique {
    /// Name in records and legends.
    pub name: String,
    /// Techniques of one panel share a row of charts.
    pub panel: String,
    /// The basis as on the command line.
    pub basis: String,
    /// Admissible depths.
    #[serde(default)]
    pub interval: Domain,
    /// The solver; without it the closed form or the exchange simplex.
    pub solver: Option<Solver>,
}

/// An arrow in a chart.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Mark {
    /// Fragment depth it points at.
    pub depth: f64,
    /// Whether the shadow is right there.
    pub correct: bool,
    /// What it says.
    pub text: String,
}

/// One row of records.csv: one technique at one fragment depth. Shadow intensities are fractions of the kernel's
/// weight, depths fractions of the depth range.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct BoundsRecord {
    /// Figure id.
    pub figure: String,
    /// Kernel id.
    pub kernel: String,
    /// Technique.
    pub technique: String,
    /// Number m of stored moments.
    pub moments: usize,
    /// Fragment depth.
    pub z_f: f64,
    /// Mass strictly before z_f: PCF.
    #[serde(rename = "F")]
    pub mass_before: f64,
    /// Sharp lower bound G.
    pub lower: Option<f64>,
    /// Sharp upper bound of the mass up to and including z_f.
    pub upper: Option<f64>,
    /// Proved lower bound.
    pub lower_proved: Option<f64>,
    /// Proved upper bound.
    pub upper_proved: Option<f64>,
    /// Why the trial failed, or empty.
    pub error: String,
}

/// One row of kernels.csv: a texel.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct KernelRecord {
    /// Kernel id.
    pub kernel: String,
    /// Column of the texel.
    pub x_texel: usize,
    /// Row of the texel.
    pub y_texel: usize,
    /// Depth of the nearest surface.
    pub depth: f64,
}

/// One row of samples.csv: one timed call that computed both bounds and their certificate.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct BoundsSample {
    /// Figure id.
    pub figure: String,
    /// Kernel id.
    pub kernel: String,
    /// Technique.
    pub technique: String,
    /// Fragment depth.
    pub z_f: f64,
    /// Counts from 0.
    pub repetition: usize,
    /// Wall-clock nanoseconds on one thread.
    pub time_ns: u64,
}

/// One bound to be computed: indices into the plan.
struct Trial {
    figure: usize,
    technique: usize,
    kernel: usize,
    z_f: f64,
}

/// The experiment with its kernels evaluated and its methods prepared.
struct Plan<'a> {
    experiment: &'a BoundsExperiment,
    texels: Vec<Vec<f64>>,
    distributions: Vec<DepthDistribution>,
    /// By figure and technique.
    methods: Vec<Vec<Method>>,
    trials: Vec<Trial>,
}

impl BoundsExperiment {
    /// Rejects values that make no sense, before anything is computed.
    pub(crate) fn check(&self) -> Result<(), EvaluationError> {
        let fail = |reason: String| Err(EvaluationError::Value(reason));
        for depths in [self.depths].into_iter().chain(self.figure.iter().filter_map(|figure| figure.depths)) {
            if !(2..=MAX_DEPTHS).contains(&depths) {
                return fail(format!("depths = {depths} is not between 2 and {MAX_DEPTHS}"));
            }
        }
        for (i, kernel) in self.kernel.iter().enumerate() {
            if self.kernel[..i].iter().any(|other| other.id == kernel.id) {
                return fail(format!("kernel `{}` appears twice", kernel.id));
            }
            kernel.depths(self.seed, i)?;
        }
        for (i, figure) in self.figure.iter().enumerate() {
            if self.figure[..i].iter().any(|other| other.id == figure.id) {
                return fail(format!("figure `{}` appears twice", figure.id));
            }
            let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
            if figure.id.is_empty() || !figure.id.chars().all(plain) {
                return fail(format!("figure id `{}` is no file name of letters, digits and -", figure.id));
            }
            for id in &figure.kernels {
                self.kernel_index(id)?;
            }
            for (j, technique) in figure.technique.iter().enumerate() {
                if figure.technique[..j].iter().any(|other| other.name == technique.name) {
                    return fail(format!("technique `{}` appears twice in one figure", technique.name));
                }
                technique.basis()?;
            }
        }
        Ok(())
    }

    fn kernel_index(&self, id: &str) -> Result<usize, EvaluationError> {
        let index = self.kernel.iter().position(|kernel| kernel.id == id);
        index.ok_or_else(|| EvaluationError::Value(format!("kernel `{id}` is not defined")))
    }

    fn plan(&self) -> Result<Plan<'_>, EvaluationError> {
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
            methods.push(settings.technique.iter().map(Technique::method).collect::<Result<Vec<_>, _>>()?);
            for id in &settings.kernels {
                let kernel = self.kernel_index(id)?;
                let depths = self.fragment_depths(settings, &distributions[kernel]);
                for technique in 0..settings.technique.len() {
                    trials.extend(depths.iter().map(|&z_f| Trial { figure, technique, kernel, z_f }));
                }
            }
        }
        Ok(Plan { experiment: self, texels, distributions, methods, trials })
    }

    /// The uniform grid, the depths that the figure points at, and those of a kernel that has only a few.
    fn fragment_depths(&self, figure: &Figure, z: &DepthDistribution) -> Vec<f64> {
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
    pub(crate) fn run(&self, progress: Progress<'_>) -> Result<Recorded, EvaluationError> {
        let plan = self.plan()?;
        let done = AtomicUsize::new(0);
        let records: Vec<BoundsRecord> = plan
            .trials
            .par_iter()
            .map(|trial| {
                let record = plan.record(trial);
                progress(done.fetch_add(1, Ordering::Relaxed) + 1, plan.trials.len());
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

impl Technique {
    /// The basis.
    pub fn basis(&self) -> Result<Basis, EvaluationError> {
        self.basis.parse().map_err(|error: moment_problem::BasisError| self.failure(error.into()))
    }

    fn method(&self) -> Result<Method, EvaluationError> {
        method(&self.basis()?, self.interval, self.solver).map_err(|error| self.failure(error))
    }

    fn failure(&self, source: moment_problem::MomentError) -> EvaluationError {
        EvaluationError::Technique { technique: self.name.clone(), source }
    }
}

impl Plan<'_> {
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
        let Timing { depths, repetitions } = self.experiment.timing;
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
