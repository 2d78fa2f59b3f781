//! Keys that the kinds which sample the light have in common.

use crate::error::EvaluationError;
use crate::experiment::keys::{refuse, unique};
use scenes::{AreaLight, LightView};
use serde::{Deserialize, Serialize};

/// The light of a view, larger or smaller.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ScaledLight {
    /// Name in records.
    pub name: String,
    /// Its sides over those of the view's light.
    pub scale: f64,
}

/// Largest side of a frame: every frame of every path is shaded.
pub(crate) const MAX_FRAME_SIDE: u32 = 2048;

impl ScaledLight {
    /// The light of a view at this scale; refuses views whose light is not in space.
    pub(crate) fn of(&self, view: &LightView) -> Result<LightView, EvaluationError> {
        let AreaLight::Local { outline, centre, half_axes } = view.light else {
            let reason = format!(
                "view `{}` has no light in space (its light is {}): maps are seen from its points",
                view.name, view.light
            );
            return refuse("views", reason);
        };
        let half_axes = half_axes.map(|axis| axis.map(|c| self.scale * c));
        let light = AreaLight::local(outline, centre, half_axes);
        let light = light.map_err(|error| {
            EvaluationError::key("light", format!("light `{}` of view `{}`: {error}", self.name, view.name))
        })?;
        Ok(LightView::new(view.name.clone(), light, view.direction))
    }

    /// Rejects scales that make no light.
    pub(crate) fn check_all(lights: &[Self]) -> Result<(), EvaluationError> {
        unique(("light", "name", "light"), lights.iter().map(|light| light.name.as_str()))?;
        for (i, light) in lights.iter().enumerate() {
            if !(light.scale > 0.0 && light.scale <= 1000.0) {
                let reason =
                    format!("light `{}`: scale = {} does not lie in (0, 1000]", light.name, light.scale);
                return refuse(format!("light[{i}].scale"), reason);
            }
        }
        Ok(())
    }
}

/// Rejects fields of view that show nothing.
pub(crate) fn check_zoom(zoom: f64) -> Result<(), EvaluationError> {
    if !(0.1..=100.0).contains(&zoom) {
        return refuse("zoom", format!("zoom = {zoom} does not lie in [0.1, 100]"));
    }
    Ok(())
}
