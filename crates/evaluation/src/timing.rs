//! Clocks run where nothing else does.

use crate::error::EvaluationError;
use graphics_device::AdapterName;
use serde::{Deserialize, Serialize};
use shadow_renderer::DeviceLimits;
use std::time::Instant;

/// Timings on one thread.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TimingSetting {
    /// How often everything is timed.
    pub repetitions: usize,
}

/// One row of samples.csv: a timing on one thread.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct TimedSample {
    /// Technique.
    pub technique: String,
    /// What was timed: `filter`, `sum` (encoding, then filtering or summing a map), `shade`, `rays` and the like.
    pub stage: String,
    /// Texels, receivers or rays.
    pub items: usize,
    /// Counts from 0.
    pub repetition: usize,
    /// Wall-clock nanoseconds for all items.
    pub time_ns: u64,
}

impl TimedSample {
    /// What began at `begin` and ends now.
    pub(crate) fn since(
        begin: Instant,
        technique: &str,
        stage: &str,
        items: usize,
        repetition: usize,
    ) -> Self {
        Self {
            technique: technique.to_owned(),
            stage: stage.to_owned(),
            items,
            repetition,
            time_ns: u64::try_from(begin.elapsed().as_nanos()).unwrap_or(u64::MAX),
        }
    }
}

/// What `work` returns, on one thread of its own.
pub(crate) fn alone<T: Send>(
    work: impl FnOnce() -> Result<T, EvaluationError> + Send,
) -> Result<T, EvaluationError> {
    let fail = |error: rayon::ThreadPoolBuildError| EvaluationError::Threads {
        threads: 1,
        reason: error.to_string(),
    };
    rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(fail)?.install(work)
}

/// Takes what was timed: technique, stage, items and when it began.
pub(crate) type Push<'a> = &'a mut dyn FnMut(&str, &str, usize, Instant);

/// What is timed in rounds, on one thread of its own.
pub(crate) fn rounds(
    repetitions: usize,
    mut round: impl FnMut(Push<'_>) -> Result<(), EvaluationError> + Send,
) -> Result<Vec<TimedSample>, EvaluationError> {
    alone(|| {
        let mut samples = Vec::new();
        for repetition in 0..repetitions {
            round(&mut |technique, stage, items, begin| {
                samples.push(TimedSample::since(begin, technique, stage, items, repetition));
            })?;
        }
        Ok(samples)
    })
}

/// The row of gpu.csv.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct GpuRecord {
    /// Name of the adapter; empty without one.
    pub adapter: String,
    /// `DiscreteGpu`, `IntegratedGpu`, `VirtualGpu`, `Cpu` or `Other`.
    pub device_type: String,
    /// Driver.
    pub driver: String,
    /// Graphics interface.
    pub api: String,
    /// `timed`, or why not, or why it stopped.
    pub status: String,
    /// Combinations that this adapter could not render.
    pub skipped: usize,
    /// The last of these, with the reason.
    pub last_skipped: String,
    /// Bytes read and written in a second by a copy, in the same run; empty where it was not measured.
    #[serde(default)]
    pub bytes_per_second: Option<f64>,
    /// Fused multiply-adds of single floats in a second by compute shaders.
    #[serde(default)]
    pub multiply_adds_per_second: Option<f64>,
}

impl GpuRecord {
    /// An adapter about to be timed.
    pub(crate) fn of(adapter: &AdapterName) -> Self {
        Self {
            adapter: adapter.name.clone(),
            device_type: adapter.device_type.clone(),
            driver: adapter.driver.clone(),
            api: adapter.api.clone(),
            ..Self::default()
        }
    }

    /// Measures what it can do at most; nothing is known where that fails.
    pub(crate) fn measure_limits(&mut self) {
        let limits = DeviceLimits::measure().ok().flatten();
        self.bytes_per_second = limits.map(|limits| limits.bytes_per_second);
        self.multiply_adds_per_second = limits.map(|limits| limits.multiply_adds_per_second);
    }

    /// Whether its times say nothing about graphics processors.
    pub fn is_software(&self) -> bool {
        self.device_type == "Cpu"
    }
}
