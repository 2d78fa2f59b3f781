//! Parts that techniques play in what papers claim. Names may change; a claim asks for a role.

use crate::error::EvaluationError;

/// Something that an experiment can give a role by the key `role`.
pub trait Role {
    /// Its role, if it has one.
    fn role(&self) -> Option<&str>;
}

/// The one with this role.
pub fn with_role<'a, T: Role>(all: &'a [T], role: &str) -> Option<&'a T> {
    all.iter().find(|one| one.role() == Some(role))
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
