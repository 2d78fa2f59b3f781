//! Which storage, bias and blend a technique gets, and what it was measured to err by.

use super::{applications, head, input};
use crate::outcome::Failure;
use anyhow::Context;
use evaluation::{CandidateSetting, Choice, SpeedAccuracyExperiment, SpeedAccuracyRecord, TechniqueSpec};
use quantization::{NumberFormat, published::Published};
use shadow_filtering::{BoundName, DepthBias, Kernel, RealTime, Technique};
use std::path::Path;

/// Best rows of the newest recorded run of `speed-accuracy`, all scenes together; empty where the runs are left out.
const RECORDS: &str = include_str!(concat!(env!("OUT_DIR"), "/speed_accuracy.csv"));

/// Name of that run.
pub(super) const RUN: &str = env!("MSM_SPEED_ACCURACY_RUN");

/// The row of calling everything lit.
const NOTHING: &str = "always lit";

/// Formats from the one that frames use to the largest.
const PREFERRED: [NumberFormat; 3] = [NumberFormat::Unorm16, NumberFormat::F16, NumberFormat::F32];

/// A technique with everything that its file says.
pub(super) struct Preset {
    /// As on the command line.
    pub key: String,
    pub technique: Technique,
    pub spec: TechniqueSpec,
    pub kernel: Kernel,
    pub leak_reduction: f64,
    pub bias: DepthBias,
    /// Where alpha comes from.
    pub why: String,
    pub measured: Option<SpeedAccuracyRecord>,
    /// What calling everything lit errs by on the same fragments.
    pub nothing: Option<f64>,
    /// For `msm advise`: the scene and the error on it.
    pub advised: Option<String>,
}

fn records() -> Result<Vec<SpeedAccuracyRecord>, Failure> {
    let mut reader = csv::Reader::from_reader(RECORDS.as_bytes());
    Ok(reader.deserialize().collect::<Result<_, _>>().context("the embedded records")?)
}

/// A name is that of a bound, or the first word of a technique of the experiment: `vsm` in 16 bits is a biased bound.
fn is_called(candidate: &CandidateSetting, key: &str) -> bool {
    let first = candidate.name.split([' ', ',']).next().unwrap_or_default().to_lowercase();
    candidate.method.bound.is_some_and(|bound| bound.as_str() == key) || first == key
}

/// Bounds that have a shader.
fn with_shader(candidates: &[CandidateSetting]) -> Vec<&'static str> {
    let has_shader = |name: &BoundName| {
        let own = candidates.iter().find(|candidate| candidate.method.bound == Some(*name));
        let spec = own.map_or_else(|| TechniqueSpec { bound: Some(*name), ..Default::default() }, single);
        spec.draft().is_ok_and(|technique| technique.real_time().and_then(RealTime::shader).is_some())
    };
    BoundName::all().filter(has_shader).map(BoundName::as_str).collect()
}

/// The first technique of a candidate's sweep.
fn single(candidate: &CandidateSetting) -> TechniqueSpec {
    candidate.method.sweep().into_iter().next().unwrap_or_default()
}

fn unknown(key: &str, candidates: &[CandidateSetting]) -> Failure {
    let known = with_shader(candidates);
    let exists = BoundName::all().any(|name| name.as_str() == key);
    let problem = if exists { "has no shader" } else { "is no technique" };
    input(format!(
        "`{key}` {problem} (with a shader: {}; parts of applications: {})",
        known.join(", "),
        applications::NAMES.join(", ")
    ))
}

impl Preset {
    /// From a name; without a format the smallest on record, without a bias the best on record.
    pub(super) fn of(key: &str, format: Option<NumberFormat>, alpha: Option<f64>) -> Result<Self, Failure> {
        let experiment = SpeedAccuracyExperiment::of_candidates(None, None)?;
        if !with_shader(&experiment.technique).contains(&key) {
            return Err(unknown(key, &experiment.technique));
        }
        if let Some(alpha) = alpha.filter(|alpha| !(0.0..=1.0).contains(alpha)) {
            return Err(input(format!("--alpha {alpha}: a bias lies between 0 and 1")));
        }
        let called: Vec<_> = experiment.technique.iter().filter(|one| is_called(one, key)).collect();
        let stored: Vec<NumberFormat> = called.iter().map(|one| one.method.format()).collect();
        let default = PREFERRED.into_iter().find(|format| stored.contains(format));
        let format = format.or(default).unwrap_or(NumberFormat::F32);
        let records = records()?;
        let size = records.iter().map(|row| row.size).max().unwrap_or_default();
        let record = |one: &CandidateSetting| {
            let name = one.method.format().name();
            let mut rows = records.iter().filter(|row| row.size == size);
            rows.find(|row| row.technique == one.name && row.format == name)
        };
        let error = |one: &CandidateSetting| record(one).map_or(f64::INFINITY, |row| row.l1_error);
        let in_format = called.iter().filter(|one| one.method.format() == format);
        let chosen = in_format.min_by(|a, b| error(a).total_cmp(&error(b)));
        let (mut spec, row) = match chosen {
            Some(one) => (single(one), record(one)),
            None => (in_other_format(key, &called, format, alpha)?, None),
        };
        let mut row = row.filter(|row| alpha.is_none() || row.alpha == alpha).cloned();
        spec.alpha = alpha.or(row.as_ref().and_then(|row| row.alpha)).or(spec.alpha);
        spec.beta = row.as_ref().map_or(spec.beta, |row| row.beta);
        let why = match (alpha, &row, spec.alpha) {
            (None, Some(_), Some(_)) => {
                "of those tried, the one that errs least on the recorded scenes".to_owned()
            }
            (Some(_), _, _) => "as given".to_owned(),
            (None, _, _) => "not needed".to_owned(),
        };
        let bias = row.as_ref().map(|row| DepthBias { texels: row.bias_texels, slopes: row.bias_slopes });
        Self::new(key, spec, &experiment, Self::nothing_of(&records, size), why).map(|preset| Self {
            leak_reduction: row.as_ref().map_or(0.0, |row| row.leak_reduction),
            bias: bias.unwrap_or_default(),
            measured: row.take(),
            ..preset
        })
    }

    /// What `msm advise` recommends.
    pub(super) fn advised(choice: &Choice, candidates: Option<&Path>) -> Result<Self, Failure> {
        let experiment = SpeedAccuracyExperiment::of_candidates(candidates, None)?;
        let is_choice = |one: &&CandidateSetting| {
            one.name == choice.technique
                && one.method.format().name() == choice.format
                && one.method.transform() == choice.transform
        };
        let candidate = experiment.technique.iter().find(is_choice);
        let candidate =
            candidate.ok_or_else(|| input(format!("no candidate is called {}", choice.technique)))?;
        let spec = TechniqueSpec { alpha: choice.alpha, beta: choice.beta, ..single(candidate) };
        let key = candidate.method.bound.map_or("technique", BoundName::as_str).to_owned();
        let why = "the one that `msm advise` found best on the scene".to_owned();
        let preset = Self::new(&key, spec, &experiment, None, why)?;
        let mut kernels = experiment.divisors.iter().filter_map(|&divisor| experiment.kernel(divisor).ok());
        let kernel = kernels.find(|kernel| kernel.size() == choice.kernel_size);
        let kernel =
            kernel.ok_or_else(|| input(format!("no map size has a kernel of {}", choice.kernel_size)))?;
        let error = format!(
            "{:.2} % ({:.2} to {:.2}) on the scene that `msm advise` was asked about, with a {size}x{size} map",
            100.0 * choice.error.l1_error,
            100.0 * choice.error.l1_error_low,
            100.0 * choice.error.l1_error_high,
            size = choice.size,
        );
        Ok(Self {
            leak_reduction: choice.leak_reduction,
            bias: DepthBias { texels: choice.bias_texels, slopes: choice.bias_slopes },
            kernel,
            advised: Some(error),
            ..preset
        })
    }

    fn new(
        key: &str,
        spec: TechniqueSpec,
        experiment: &SpeedAccuracyExperiment,
        nothing: Option<f64>,
        why: String,
    ) -> Result<Self, Failure> {
        let fail = |error: shadow_filtering::FilteringError| input(error.to_string());
        let technique = spec.build().map_err(fail)?;
        technique.check_real_time().map_err(fail)?;
        Ok(Self {
            key: key.to_owned(),
            technique,
            spec,
            kernel: experiment.kernel(1).map_err(fail)?,
            leak_reduction: 0.0,
            bias: DepthBias::default(),
            why,
            measured: None,
            nothing,
            advised: None,
        })
    }

    fn nothing_of(records: &[SpeedAccuracyRecord], size: u32) -> Option<f64> {
        let mut rows = records.iter().filter(|row| row.technique == NOTHING && row.size == size);
        rows.next().map(|row| row.l1_error)
    }

    pub(super) fn format_name(&self) -> String {
        self.spec.format().name()
    }

    pub(super) fn published(&self) -> Option<&'static Published> {
        Published::named(self.spec.transform())
    }

    pub(super) fn facts(&self) -> head::Facts {
        head::Facts::of(self)
    }
}

/// Storage for a format that the experiment does not have: that of another one of its like, else each value stretched.
fn in_other_format(
    key: &str,
    called: &[&CandidateSetting],
    format: NumberFormat,
    alpha: Option<f64>,
) -> Result<TechniqueSpec, Failure> {
    let bound: BoundName =
        key.parse().map_err(|error: shadow_filtering::FilteringError| input(error.to_string()))?;
    let own = called.iter().find(|one| one.method.bound == Some(bound));
    let mut spec =
        own.map_or_else(|| TechniqueSpec { bound: Some(bound), ..Default::default() }, |one| single(one));
    let is_fixed = |format: NumberFormat| !matches!(format, NumberFormat::F16 | NumberFormat::F32);
    let alike = called
        .iter()
        .find(|one| one.method.bound == Some(bound) && is_fixed(one.method.format()) == is_fixed(format));
    spec.transform = match (alike, is_fixed(format), bound.moments()) {
        (Some(one), _, _) => one.method.transform.clone(),
        (None, false, _) => None,
        (None, true, Some(_)) => Some("plain".to_owned()),
        (None, true, None) => Some("sampled".to_owned()),
    };
    spec.format = Some(format);
    spec.alpha = None;
    if bound.moments().is_some() && alpha.is_none() {
        let recorded: Vec<String> = called.iter().map(|one| one.method.format().name()).collect();
        return Err(input(format!(
            "no bias of {key} in {format} is on record: give --alpha, or one of the formats {}",
            recorded.join(", ")
        )));
    }
    Ok(spec)
}
