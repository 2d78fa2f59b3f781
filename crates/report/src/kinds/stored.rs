//! What pages ask of a technique that is stored in a map.

use crate::drawing::Family;
use evaluation::TechniqueSpec;

/// Its family, by its bound; without a map, by its name.
pub(crate) fn family(spec: Option<&TechniqueSpec>, name: &str) -> &'static str {
    let bound = spec.and_then(|spec| spec.bound).map(|bound| bound.as_str());
    Family::of(bound.unwrap_or(name)).name
}

/// How the stability experiment calls its bound with its format, and its moment bias.
pub(crate) fn stored(spec: Option<&TechniqueSpec>) -> Option<(String, Option<f64>)> {
    let spec = spec?;
    Some((format!("{}, {}", spec.moment_bound()?.name(), spec.format()), spec.alpha))
}
