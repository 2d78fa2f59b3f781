//! The experiment with its techniques built, and the application that it measures.

use super::settings::{FilterableExperiment, FilterableTechnique};
use super::view::View;
use crate::error::EvaluationError;
use applications::{HardShadow, ShadowMethod};
use shadow_filtering::Kernel;

/// The experiment with everything that does not depend on a view.
pub(crate) struct FilterablePlan<'a> {
    pub(crate) experiment: &'a FilterableExperiment,
    pub(crate) kernel: Kernel,
    pub(crate) methods: Vec<ShadowMethod>,
}

impl FilterablePlan<'_> {
    /// The application on a view under a bias.
    pub(crate) fn hard_shadow<'a>(&'a self, view: &'a View, bias: usize) -> HardShadow<'a> {
        HardShadow {
            map: &view.map,
            kernel: &self.kernel,
            texel_depth: view.texel_depth,
            bias: self.experiment.bias[bias],
            plane_limit: self.experiment.scenery.plane_limit,
        }
    }
}

impl FilterableExperiment {
    pub(super) fn plan(&self) -> Result<FilterablePlan<'_>, EvaluationError> {
        let kernel = self.scenery.filter()?;
        let methods = self.technique.iter().map(FilterableTechnique::prepared).collect::<Result<_, _>>()?;
        Ok(FilterablePlan { experiment: self, kernel, methods })
    }
}
