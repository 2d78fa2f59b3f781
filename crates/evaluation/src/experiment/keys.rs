//! Which key of an experiment a mistake is about.

use crate::error::EvaluationError;
use shadow_filtering::FilteringError;

impl EvaluationError {
    /// A value that makes no sense, under a key such as `technique[3].method.exponent`.
    pub(crate) fn key(key: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::Key { key: key.into(), reason: reason.into() }
    }
}

/// Refuses what stands under a key.
pub(crate) fn refuse<T>(key: impl Into<String>, reason: impl Into<String>) -> Result<T, EvaluationError> {
    Err(EvaluationError::key(key, reason))
}

/// Rejects a list that holds a name twice; `list` is its key, `what` an item of it.
pub(crate) fn unique<'a>(
    (list, name, what): (&str, &str, &str),
    names: impl Iterator<Item = &'a str>,
) -> Result<(), EvaluationError> {
    let mut known = std::collections::HashSet::new();
    for (i, value) in names.enumerate() {
        if !known.insert(value) {
            let reason = format!("{what} `{value}` appears twice");
            return Err(EvaluationError::key(format!("{list}[{i}].{name}"), reason));
        }
    }
    Ok(())
}

/// Checks the items of a list, each under its key.
pub(crate) fn each<T>(
    list: &str,
    items: &[T],
    check: impl Fn(&T, &str) -> Result<(), EvaluationError>,
) -> Result<(), EvaluationError> {
    items.iter().enumerate().try_for_each(|(i, item)| check(item, &format!("{list}[{i}]")))
}

/// Where the item of a name stands among those `known`; `key` is where it was named.
pub(crate) fn place_of<'a>(
    mut known: impl Iterator<Item = &'a str>,
    (what, name): (&str, &str),
    key: &str,
) -> Result<usize, EvaluationError> {
    known
        .position(|known| known == name)
        .ok_or_else(|| EvaluationError::key(key, format!("{key}: {what} `{name}` is not defined")))
}

/// Where several items stand, at least one.
pub(crate) fn places_of<'a>(
    known: impl Iterator<Item = &'a str> + Clone,
    (what, names): (&str, &[String]),
    key: &str,
) -> Result<Vec<usize>, EvaluationError> {
    if names.is_empty() {
        return Err(EvaluationError::key(key, format!("{key} is empty")));
    }
    names.iter().map(|name| place_of(known.clone(), (what, name), key)).collect()
}

/// Rejects counts that are too small; each with its key and the least that makes sense.
pub(crate) fn at_least<const N: usize>(counts: [(&str, usize, usize); N]) -> Result<(), EvaluationError> {
    match counts.into_iter().find(|(_, value, least)| value < least) {
        Some((key, value, least)) => {
            Err(EvaluationError::key(key, format!("{key}: {value} is less than {least}")))
        }
        None => Ok(()),
    }
}

/// Rejects lists without an entry; each with its key.
pub(crate) fn not_empty<const N: usize>(lists: [(&str, bool); N]) -> Result<(), EvaluationError> {
    match lists.into_iter().find(|(_, is_empty)| *is_empty) {
        Some((key, _)) => Err(EvaluationError::key(key, format!("{key} is empty"))),
        None => Ok(()),
    }
}

/// Rejects what cannot be the name of a file on every system.
pub(crate) fn file_name(key: &str, what: &str, id: &str) -> Result<(), EvaluationError> {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if !id.is_empty() && id.chars().all(plain) {
        return Ok(());
    }
    Err(EvaluationError::key(key, format!("{what} id `{id}` is no file name of letters, digits and -")))
}

/// The words of a name, in lower case with hyphens between them.
pub(crate) fn words(text: &str) -> String {
    let words: Vec<String> = text
        .split(|c: char| !c.is_ascii_alphanumeric())
        .filter(|word| !word.is_empty())
        .map(str::to_ascii_lowercase)
        .collect();
    words.join("-")
}

/// The error with its key below `place`, the empty one being the top of the file.
pub(crate) fn in_key(place: &str) -> impl Fn(FilteringError) -> EvaluationError {
    move |error| {
        let inner = match &error {
            FilteringError::Parameter { key, .. } => key,
            FilteringError::Basis(_) => "basis",
            FilteringError::Length { .. }
            | FilteringError::NotFinite { .. }
            | FilteringError::Quantization(_)
            | FilteringError::Moments(_) => "",
        };
        let dot = if place.is_empty() || inner.is_empty() { "" } else { "." };
        let colon = if place.is_empty() { "" } else { ": " };
        EvaluationError::Key { key: format!("{place}{dot}{inner}"), reason: format!("{place}{colon}{error}") }
    }
}
