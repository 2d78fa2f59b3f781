//! Names of techniques, and the parts that they play in what papers claim. Names may change; a claim asks for a role.

use crate::error::EvaluationError;
use crate::experiment::keys::{places_of, unique};

/// Something that an experiment can give a role by the key `role`.
pub trait Role {
    /// Its name in records and legends.
    fn name(&self) -> &str;

    /// Its role, if it has one.
    fn role(&self) -> Option<&str>;
}

/// [`Role`] of something with the keys `name` and `role`.
macro_rules! plays_a_role {
    ($player:ty) => {
        impl $crate::role::Role for $player {
            fn name(&self) -> &str {
                &self.name
            }

            fn role(&self) -> Option<&str> {
                self.role.as_deref()
            }
        }
    };
}
pub(crate) use plays_a_role;

/// The one with this role.
pub fn with_role<'a, T: Role>(all: &'a [T], role: &str) -> Option<&'a T> {
    all.iter().find(|one| one.role() == Some(role))
}

/// Refuses a name or a role that two bear.
pub(crate) fn check_names<T: Role>(all: &[T], key: &str) -> Result<(), EvaluationError> {
    check_roles(all, key)?;
    unique((key, "name", "technique"), all.iter().map(T::name))
}

/// Where the techniques of these names stand, at least one; `key` is where they were named.
pub(crate) fn named<T: Role>(all: &[T], names: &[String], key: &str) -> Result<Vec<usize>, EvaluationError> {
    places_of(all.iter().map(T::name), ("technique", names), key)
}

/// Refuses a role that two play.
pub(crate) fn check_roles<T: Role>(all: &[T], key: &str) -> Result<(), EvaluationError> {
    for (i, one) in all.iter().enumerate() {
        if let Some(role) = one.role()
            && with_role(&all[..i], role).is_some()
        {
            let key = format!("{key}[{i}].role");
            return Err(EvaluationError::Key { key, reason: format!("role `{role}` is given twice") });
        }
    }
    Ok(())
}
