//! A technique with its storage and its moment biases, ready for any map.

use crate::error::EvaluationError;
use crate::experiment::keys::in_key;
use moment_problem::MomentBound;
use quantization::Search;
use random_stream::Random;
use shadow_filtering::{FilteringError, RealTime, Technique, TechniqueSpec};

/// A technique in one format.
pub(crate) struct Candidate {
    pub(crate) name: String,
    pub(crate) format: String,
    /// With each moment bias, one without where there is none; all store the same map.
    pub(crate) biased: Vec<(Option<f64>, Technique)>,
    /// Operations of decoding and shading a fragment, see [`RealTime::operations`].
    pub(crate) operations: f64,
}

/// Kernels over which operations are averaged: as many as leave the mean to the third digit.
const KERNELS: u64 = 256;

/// Stream of their random numbers, apart from those of scenes.
const KERNEL_STREAM: u64 = 1 << 32;

impl Candidate {
    /// `place` is the key of the technique in its file.
    pub(crate) fn new(
        (name, method): (&str, &TechniqueSpec),
        seed: u64,
        place: &str,
    ) -> Result<Self, EvaluationError> {
        let fail = |error: FilteringError| match in_key(&format!("{place}.method"))(error) {
            EvaluationError::Key { key, reason } => {
                EvaluationError::Key { key, reason: format!("technique `{name}`: {reason}") }
            }
            other => other,
        };
        let search = Search { seed, ..Search::default() };
        method.check_storage(&["alphas", "transform", "format"]).map_err(fail)?;
        let build = |spec: TechniqueSpec| -> Result<(Option<f64>, Technique), FilteringError> {
            let technique = spec.build_with(&search)?;
            technique.check_real_time()?;
            Ok((spec.alpha, technique))
        };
        let biased: Result<Vec<_>, _> = method.sweep().into_iter().map(build).collect();
        let biased = biased.map_err(fail)?;
        let operations = biased[0].1.real_time().map_or(0.0, |first| operations(first, &biased[0].1));
        Ok(Self { name: name.to_owned(), format: method.format().name(), biased, operations })
    }

    /// What the map is stored and filtered by, with the first moment bias.
    pub(crate) fn technique(&self) -> &Technique {
        &self.biased[0].1
    }

    pub(crate) fn channels(&self) -> usize {
        self.technique().channels()
    }

    /// Both bounds for a sample of the filtered map, with the moment bias of that index.
    pub(crate) fn bounds(&self, moments: &[f32], alpha: usize, z_f: f32) -> [f32; 2] {
        // `new` has refused techniques without a shader, and only these fail.
        self.biased[alpha].1.bounds(moments, z_f).map_or([0.0, 1.0], |pair| [pair.lower, pair.upper])
    }

    /// Whether there is an upper bound to blend with.
    pub(crate) fn has_upper(&self) -> bool {
        self.technique().bound().has_upper()
    }
}

/// Mean over kernels of three random depths, z_f anywhere.
fn operations(bound: &dyn RealTime, technique: &Technique) -> f64 {
    let m = technique.channels();
    let mut total = 0;
    for kernel in 0..KERNELS {
        let random = &mut Random::substream(0, KERNEL_STREAM, kernel);
        let (mut b, mut sum) = (vec![0.0; m], vec![0.0; m]);
        for _ in 0..3 {
            technique.evaluate(random.unit() as f32, &mut b);
            sum.iter_mut().zip(&b).for_each(|(sum, value)| *sum += value / 3.0);
        }
        total += bound.operations(&sum, random.unit() as f32);
    }
    total as f64 / KERNELS as f64 + technique.decode_operations() as f64
}

/// Operations of the bound of moments, for one fragment.
pub(crate) fn moment_operations(bound: MomentBound) -> f64 {
    // Without a storage of its own a bound is always built.
    let technique = TechniqueSpec::from(bound).build().ok();
    technique.and_then(|technique| Some(operations(technique.real_time()?, &technique))).unwrap_or_default()
}
