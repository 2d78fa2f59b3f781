//! Transforms of stored values by their names in experiments.

use crate::basis::AnyBasis;
use crate::error::FilteringError;
use crate::spec::TechniqueSpec;
use quantization::published::{ALL, Published};
use quantization::{AffineTransform, QuantizationError, Search, optimise, plain};

/// Depths at which the range of a stored value is looked for; half a cell off, a cosine misses its maximum by 1e-8.
const RANGE_SAMPLES: usize = 1 << 14;

/// How far beyond them the range is stretched.
const RANGE_MARGIN: f64 = 1e-6;

/// Transforms that are not constants.
const COMPUTED: [&str; 4] = ["identity", "plain", "sampled", "optimal"];

/// The published transform that a technique names, if it names one.
pub(crate) fn published(spec: &TechniqueSpec) -> Result<Option<&'static Published>, FilteringError> {
    let name = spec.transform();
    if COMPUTED.contains(&name) {
        return Ok(None);
    }
    let fail = |reason: String| FilteringError::parameter("transform", name, reason);
    let published = Published::named(name).ok_or_else(|| {
        let known: Vec<&str> = COMPUTED.into_iter().chain(ALL.iter().map(|p| p.name)).collect();
        fail(format!("unknown transform (known: {})", known.join(", ")))
    })?;
    match spec.moment_bound() {
        Some(bound) if !bound.is_trigonometric() => Ok(Some(published)),
        Some(_) | None => Err(fail("is a transform of power moments".to_owned())),
    }
}

/// The transform of a technique with that basis; the identity in place of a computed one without a search.
pub(crate) fn transform(
    spec: &TechniqueSpec,
    basis: &dyn AnyBasis,
    search: Option<&Search>,
) -> Result<AffineTransform, FilteringError> {
    let name = spec.transform();
    let moments = || {
        let missing = || FilteringError::parameter("transform", name, "needs a technique of moments");
        Ok::<_, FilteringError>((spec.moment_bound().ok_or_else(missing)?, spec.stored_range()?.interval()))
    };
    let computed = match name {
        "identity" => return Ok(AffineTransform::identity(basis.channels())),
        "sampled" => search.map(|_| sampled(basis)),
        "plain" => {
            let (bound, interval) = moments()?;
            search.map(|_| plain(&bound.basis(), interval))
        }
        "optimal" => {
            let (bound, interval) = moments()?;
            search.map(|search| optimise(&bound.basis(), interval, search)?.transform_on(interval))
        }
        _ => published(spec)?.map(|published| published.transform()),
    };
    Ok(computed.unwrap_or_else(|| Ok(AffineTransform::identity(basis.channels())))?)
}

/// Each value stretched to \[0, 1\] by itself, by its range at samples.
fn sampled(basis: &dyn AnyBasis) -> Result<AffineTransform, QuantizationError> {
    let m = basis.channels();
    let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; m];
    let mut b = vec![0.0; m];
    for i in 0..=RANGE_SAMPLES {
        basis.evaluate_double(i as f64 / RANGE_SAMPLES as f64, &mut b);
        for (range, &value) in ranges.iter_mut().zip(&b) {
            *range = [range[0].min(value), range[1].max(value)];
        }
    }
    let widths = ranges.iter().map(|[low, high]| (high - low) * (1.0 + 2.0 * RANGE_MARGIN));
    let offset = ranges.iter().zip(widths.clone()).map(|([low, _], width)| RANGE_MARGIN - low / width);
    AffineTransform::diagonal(widths.clone().map(|width| 1.0 / width).collect(), offset.collect())
}
