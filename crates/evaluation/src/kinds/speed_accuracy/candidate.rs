//! A technique with its storage and its moment biases, ready for any map.

use super::settings::CandidateSetting;
use crate::error::EvaluationError;
use crate::kinds::quantization::published;
use quantization::{AffineTransform, DepthInterval, NumberFormat, Search, optimise};
use random_stream::Random;
use shadow_filtering::techniques::MomentBound;
use shadow_filtering::{
    FilteringError, MomentOptions, RealTime, StorageFormat, StoredTechnique, Technique, TechniqueSpec,
};

/// A technique in one format.
pub(crate) struct Candidate {
    pub(crate) name: String,
    pub(crate) format: String,
    pub(crate) stored: StoredTechnique,
    /// The same technique with each moment bias; one without where it has none.
    pub(crate) biased: Vec<(Option<f64>, Box<dyn Technique>)>,
    has_upper: bool,
    /// Operations of decoding and shading a fragment, see [`RealTime::operations`].
    pub(crate) operations: f64,
}

/// Kernels over which operations are averaged: as many as leave the mean to the third digit.
const KERNELS: u64 = 256;

/// Stream of their random numbers, apart from those of scenes.
const KERNEL_STREAM: u64 = 1 << 32;

/// Depths at which the range of a stored value is looked for; half a cell off, a cosine misses its maximum by 1e-8.
const RANGE_SAMPLES: usize = 1 << 14;

/// How far beyond them the range is stretched.
const RANGE_MARGIN: f64 = 1e-6;

impl Candidate {
    /// `place` is the key of the setting in its file.
    pub(crate) fn new(setting: &CandidateSetting, seed: u64, place: &str) -> Result<Self, EvaluationError> {
        let fail = |key: &str, reason: String| EvaluationError::Key {
            key: format!("{place}.{key}"),
            reason: format!("candidate `{}`: {reason}", setting.name),
        };
        let build = |spec: &TechniqueSpec| {
            spec.build().map_err(|error: FilteringError| fail("method", error.to_string()))
        };
        let format: NumberFormat = setting
            .format
            .parse()
            .map_err(|error: quantization::QuantizationError| fail("format", error.to_string()))?;
        let spec = in_format(&setting.method, format).map_err(|reason| fail("format", reason))?;
        let technique = build(&spec)?;
        let mut biased = Vec::new();
        for &alpha in &setting.alphas {
            let spec = with_alpha(&spec, alpha).ok_or_else(|| {
                fail("alphas", format!("alphas = {:?}: the technique has no moment bias", setting.alphas))
            })?;
            biased.push((Some(alpha), build(&spec)?));
        }
        if biased.is_empty() {
            biased.push((None, build(&spec)?));
        }
        let transform = transform(&setting.transform, &spec, technique.as_ref(), seed).map_err(|reason| {
            fail("transform", format!("transform = \"{}\": {reason}", setting.transform))
        })?;
        let stored = StoredTechnique::new(technique, transform.as_ref(), format)
            .map_err(|error| fail("format", error.to_string()))?;
        let first = biased[0].1.real_time();
        let operations = first.map_or(0.0, |first| operations(first, &stored));
        Ok(Self {
            name: setting.name.clone(),
            format: setting.format.clone(),
            stored,
            biased,
            has_upper: moment_bound(&spec).is_some(),
            operations,
        })
    }

    pub(crate) fn channels(&self) -> usize {
        self.stored.technique().channels()
    }

    /// Both bounds for a sample of the filtered map, with the moment bias of that index.
    pub(crate) fn bounds(&self, moments: &[f32], alpha: usize, z_f: f32) -> [f32; 2] {
        // `new` has refused techniques without a shader.
        self.biased[alpha].1.real_time().map_or([0.0, 1.0], |technique| technique.bounds_single(moments, z_f))
    }

    /// Whether there is an upper bound to blend with.
    pub(crate) fn has_upper(&self) -> bool {
        self.has_upper
    }
}

/// The technique with exponents checked against the format that stores it.
fn in_format(spec: &TechniqueSpec, format: NumberFormat) -> Result<TechniqueSpec, String> {
    let floats = match format {
        NumberFormat::F16 => Ok(StorageFormat::F16),
        NumberFormat::F32 => Ok(StorageFormat::F32),
        _ => Err(format!("format = \"{format}\" cannot hold exponential warps, f16 and f32 can")),
    };
    Ok(match *spec {
        TechniqueSpec::Esm { exponent, .. } => TechniqueSpec::Esm { exponent, format: floats? },
        TechniqueSpec::Evsm { positive, negative, .. } => {
            TechniqueSpec::Evsm { positive, negative, format: floats? }
        }
        ref other => other.clone(),
    })
}

fn moment_bound(spec: &TechniqueSpec) -> Option<(MomentBound, MomentOptions)> {
    Some(match *spec {
        TechniqueSpec::Hamburger2(options) => (MomentBound::Hamburger2, options),
        TechniqueSpec::Hamburger4(options) => (MomentBound::Hamburger4, options),
        TechniqueSpec::Hamburger6(options) => (MomentBound::Hamburger6, options),
        TechniqueSpec::Hamburger8(options) => (MomentBound::Hamburger8, options),
        TechniqueSpec::Hausdorff4(options) => (MomentBound::Hausdorff4, options),
        TechniqueSpec::Trigonometric4(options) => (MomentBound::Trigonometric4, options),
        _ => return None,
    })
}

fn with_alpha(spec: &TechniqueSpec, alpha: f64) -> Option<TechniqueSpec> {
    let (bound, options) = moment_bound(spec)?;
    let options = MomentOptions { alpha: Some(alpha), ..options };
    Some(match bound {
        MomentBound::Hamburger2 => TechniqueSpec::Hamburger2(options),
        MomentBound::Hamburger4 => TechniqueSpec::Hamburger4(options),
        MomentBound::Hamburger6 => TechniqueSpec::Hamburger6(options),
        MomentBound::Hamburger8 => TechniqueSpec::Hamburger8(options),
        MomentBound::Hausdorff4 => TechniqueSpec::Hausdorff4(options),
        MomentBound::Trigonometric4 => TechniqueSpec::Trigonometric4(options),
    })
}

fn transform(
    name: &str,
    spec: &TechniqueSpec,
    technique: &dyn Technique,
    seed: u64,
) -> Result<Option<AffineTransform>, String> {
    let bound = moment_bound(spec).map(|(bound, _)| bound);
    let interval = bound.map_or(DepthInterval::UNIT, DepthInterval::of_variable);
    match (name, bound) {
        ("identity", _) => Ok(None),
        ("plain", _) => plain(technique).map(Some),
        ("optimal", Some(bound)) => {
            let search = Search { seed, ..Search::default() };
            let optimum = optimise(&bound.basis(), interval, &search).map_err(|error| error.to_string())?;
            Ok(Some(optimum.transform))
        }
        ("optimal", None) => Err("needs a technique of moments".to_owned()),
        (_, Some(bound)) => {
            let (transform, of) = published(name, bound, &["identity", "plain", "optimal"])?;
            if of != interval {
                return Err(format!("is for depths in {of}, the technique stores functions on {interval}"));
            }
            Ok(Some(transform))
        }
        (_, None) => Err("known for this technique are identity and plain".to_owned()),
    }
}

/// Each value stretched to \[0, 1\] by itself.
fn plain(technique: &dyn Technique) -> Result<AffineTransform, String> {
    let m = technique.channels();
    let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; m];
    let mut b = vec![0.0; m];
    for i in 0..=RANGE_SAMPLES {
        technique.encode(i as f64 / RANGE_SAMPLES as f64, &mut b);
        for (range, &value) in ranges.iter_mut().zip(&b) {
            *range = [range[0].min(value), range[1].max(value)];
        }
    }
    let (mut matrix, mut offset) = (vec![0.0; m * m], vec![0.0; m]);
    for (i, [low, high]) in ranges.into_iter().enumerate() {
        let width = (high - low) * (1.0 + 2.0 * RANGE_MARGIN);
        matrix[i * m + i] = 1.0 / width;
        offset[i] = RANGE_MARGIN - low / width;
    }
    AffineTransform::new(matrix, offset).map_err(|error| error.to_string())
}

/// Mean over kernels of three random depths, z_f anywhere.
fn operations(technique: &dyn RealTime, stored: &StoredTechnique) -> f64 {
    let m = technique.channels();
    let mut total = 0;
    for kernel in 0..KERNELS {
        let random = &mut Random::substream(0, KERNEL_STREAM, kernel);
        let (mut b, mut sum) = (vec![0.0; m], vec![0.0; m]);
        for _ in 0..3 {
            technique.encode_single(random.unit() as f32, &mut b);
            sum.iter_mut().zip(&b).for_each(|(sum, value)| *sum += value / 3.0);
        }
        total += technique.operations(&sum, random.unit() as f32);
    }
    total as f64 / KERNELS as f64 + stored.decode_operations() as f64
}
