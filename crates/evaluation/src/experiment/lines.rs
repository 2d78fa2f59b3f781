//! The line of an experiment's file that a mistake is about.
//!
//! The file is read a second time, in a form that keeps positions; this happens only when something is wrong.

use super::kind::{Given, Keys, Settings};
use super::{Experiment, Scale};
use crate::error::EvaluationError;
use crate::kinds::KINDS;
use serde::de::IntoDeserializer;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The 1-based line of the mistake that reading the file at a scale reports.
pub(crate) fn of_mistake(source: &str, scale: Scale) -> Option<usize> {
    let (kind, table) = merged(source, scale)?;
    match KINDS.iter().find(|known| known.name == kind) {
        Some(kind) => (kind.line_of_mistake)(source, &table),
        None => of_key(source, "kind"),
    }
}

/// The 1-based line on which the value of a key such as `scale.quick` begins.
pub(crate) fn of_key(source: &str, key: &str) -> Option<usize> {
    find(&DeTable::parse(source).ok()?.into_inner(), key).map(|span| line(source, &span))
}

/// The same for one kind of settings, from all keys but `kind`.
pub(super) fn mistake<T: Settings>(source: &str, table: &DeTable<'_>) -> Option<usize> {
    let keys = Keys::split::<T>(table.clone(), |table, keys| {
        let mut taken = DeTable::new();
        taken.extend(keys.iter().filter_map(|&key| table.remove_entry(key)));
        taken
    });
    let given: Result<Given<T>, _> =
        keys.read(|table| Spanned::new(0..source.len(), table).into_deserializer());
    match given {
        Err(error) => error.span().map(|span| line(source, &span)),
        Ok(given) => match given.own.check() {
            Err(EvaluationError::Key { key, .. }) => find(table, &key).map(|span| line(source, &span)),
            Err(_) | Ok(()) => None,
        },
    }
}

impl Experiment {
    /// Adds the file's line to a mistake that shows only when scenes are known.
    pub(crate) fn located(&self, error: EvaluationError, scale: Scale) -> EvaluationError {
        let EvaluationError::Key { key, reason } = error else { return error };
        let position = merged(&self.source, scale).and_then(|(_, table)| {
            // Scenes of the command line stand on no line.
            let scenes = table.get("scenes").and_then(|list| list.get_ref().as_array());
            let named = scenes.is_some_and(|list| {
                list.iter().filter_map(|scene| scene.get_ref().as_str()).eq(self.scenes())
            });
            if key.starts_with("scenes") && !named { None } else { find(&table, &key) }
        });
        match position {
            Some(span) => {
                let (name, line) = (&self.name, line(&self.source, &span));
                EvaluationError::Value(if reason.starts_with(&key) {
                    format!("{name}.toml: line {line}: {reason}")
                } else {
                    format!("{name}.toml: line {line}: {key}: {reason}")
                })
            }
            None => EvaluationError::Value(reason),
        }
    }
}

/// The kind and the remaining keys at a scale.
fn merged(source: &str, scale: Scale) -> Option<(String, DeTable<'_>)> {
    let mut table = DeTable::parse(source).ok()?.into_inner();
    if let Some(DeValue::Table(mut scales)) = table.remove("scale").map(Spanned::into_inner)
        && let Some(DeValue::Table(changes)) =
            scale.tables().iter().find_map(|name| scales.remove(*name)).map(Spanned::into_inner)
    {
        merge(&mut table, changes);
    }
    let kind = table.remove("kind")?;
    Some((kind.get_ref().as_str()?.to_owned(), table))
}

/// As when the experiment is resolved: tables are merged, everything else replaced.
fn merge<'a>(base: &mut DeTable<'a>, changes: DeTable<'a>) {
    for (key, change) in changes {
        match (base.get_mut(key.get_ref().as_ref()).map(Spanned::get_mut), change) {
            (Some(DeValue::Table(inner)), change) if change.get_ref().is_table() => {
                if let DeValue::Table(changes) = change.into_inner() {
                    merge(inner, changes);
                }
            }
            (_, change) => {
                base.insert(key, change);
            }
        }
    }
}

/// The place of a key such as `technique[3].method.exponent`, or of the innermost table around it that exists.
fn find(table: &DeTable<'_>, key: &str) -> Option<Range<usize>> {
    let mut steps = key.split(['.', '[', ']']).filter(|step| !step.is_empty());
    let mut value = table.get(steps.next()?)?;
    for step in steps {
        let inner = match (value.get_ref(), step.parse::<usize>()) {
            (DeValue::Table(inner), _) => inner.get(step),
            (DeValue::Array(list), Ok(index)) => list.get(index),
            _ => None,
        };
        match inner {
            Some(inner) => value = inner,
            None => break,
        }
    }
    Some(value.span())
}

fn line(source: &str, span: &Range<usize>) -> usize {
    source.as_bytes()[..span.start.min(source.len())].iter().filter(|&&byte| byte == b'\n').count() + 1
}
