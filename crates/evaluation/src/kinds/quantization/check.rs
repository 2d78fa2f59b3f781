//! What is checked of the settings before anything runs.

use super::settings::QuantizationExperiment;
use super::stored_technique::StoredTechnique;
use crate::error::EvaluationError;
use crate::experiment::keys::{at_least, in_key, not_empty};
use crate::experiment::kind::{Settings, evaluated_on_scenes};
use crate::fragments::check_bias;
use moment_problem::Basis;

impl Settings for QuantizationExperiment {
    const KIND: &'static str = "quantization";
    const ON_SCENES: bool = true;
    const IS_DIVISIBLE: bool = true;

    fn check(&self) -> Result<(), EvaluationError> {
        let fail = |key: &str, reason: String| Err(EvaluationError::Key { key: key.to_owned(), reason });
        self.scenery.check(!self.technique.is_empty())?;
        at_least([
            ("workload", self.workload, 1),
            ("hull_points", self.hull_points, 2),
            ("code_bins", self.code_bins, 2),
        ])?;
        self.alphas.check()?;
        let kernel = self.scenery.filter()?;
        check_bias(&self.bias, "bias")?;
        for (i, gain) in self.gain.iter().enumerate() {
            let key = format!("gain[{i}].basis");
            if let Err(error) = gain.basis.parse::<Basis>() {
                return fail(&key, format!("basis = `{}`: {error}", gain.basis));
            }
            if gain.starts == Some(0) {
                let key = format!("gain[{i}].starts");
                return fail(&key, format!("{key} = 0 finds nothing"));
            }
        }
        for (i, store) in self.technique.iter().enumerate() {
            let place = format!("technique[{i}]");
            not_empty([
                (&format!("{place}.method.transforms"), store.method.transforms.is_empty()),
                (&format!("{place}.method.formats"), store.method.formats.is_empty()),
                (&format!("{place}.targets"), store.targets.is_empty()),
            ])?;
            if let Some(baseline) =
                store.baseline.as_ref().filter(|name| !store.method.transforms.contains(name))
            {
                let key = format!("{place}.baseline");
                return fail(&key, format!("{key} = \"{baseline}\" is none of the transforms"));
            }
            let own = self.kernel_of(store).build().map_err(in_key(&format!("{place}.kernel")))?;
            if own.size() > kernel.size() {
                let key = format!("{place}.kernel.size");
                let reason = format!("{key} = {} exceeds kernel.size = {}", own.size(), kernel.size());
                return fail(&key, reason);
            }
        }
        StoredTechnique::check(self)
    }

    evaluated_on_scenes!();
}
