//! What is checked of the settings before anything runs.

use super::method::Prepared;
use super::settings::{Shape, Span, StabilityExperiment};
use crate::error::EvaluationError;
use crate::experiment::keys::{at_least, in_key, unique};
use crate::experiment::kind::{Settings, evaluated_on_scenes};
use crate::role::check_names;

/// Most cells along a knob.
const MAX_CELLS: usize = 64;

impl Settings for StabilityExperiment {
    const KIND: &'static str = "stability";
    const ON_SCENES: bool = true;
    const IS_DIVISIBLE: bool = true;

    fn check(&self) -> Result<(), EvaluationError> {
        let fail = |key: &str, reason: String| Err(EvaluationError::Key { key: key.to_owned(), reason });
        if !(1..=MAX_CELLS).contains(&self.cells) {
            return fail("cells", format!("cells = {} is not between 1 and {MAX_CELLS}", self.cells));
        }
        self.scenery.check(self.family.iter().any(|family| family.shape == Shape::Scenes))?;
        at_least([
            ("draws", self.draws, 1),
            ("family", self.family.len(), 1),
            ("technique", self.technique.len(), 1),
            ("timing.inputs", self.timing.inputs, 1),
            ("timing.repetitions", self.timing.repetitions, 1),
        ])?;
        self.alphas.check()?;
        self.bias.check().map_err(in_key("bias"))?;
        unique(("family", "name", "family"), self.family.iter().map(|family| family.name.as_str()))?;
        for (i, family) in self.family.iter().enumerate() {
            for (knob, Span { from, to }) in [("x", family.x), ("y", family.y)] {
                if !(from > 0.0 && from < to && to <= 1.0) {
                    let key = format!("family[{i}].{knob}");
                    return fail(&key, format!("{key}: from = {from}, to = {to} are no part of (0, 1]"));
                }
            }
        }
        check_names(&self.technique, "technique")?;
        for (i, method) in self.technique.iter().enumerate() {
            Prepared::new(method, &format!("technique[{i}]"))?;
        }
        Ok(())
    }

    evaluated_on_scenes!();
}
