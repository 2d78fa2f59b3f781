//! A method as an experiment writes it down, and as it is prepared for a camera.

use super::shot::{Maps, Shot};
use crate::error::EvaluationError;
use crate::experiment::keys::in_key;
use crate::kinds::soft_shadows::Precision;
use applications::Estimate;
use applications::scattering::{
    Blending, ExactPrefixes, Jitter, Marched, Prefiltered, RectifiedMap, SingleScattering, Spacing,
    StoredPrefixes, ViewRay,
};
use serde::{Deserialize, Serialize};
use shadow_filtering::{FilteringError, Technique, TechniqueSpec};

/// A method: ray marching with `steps`, prefix sums of what is `stored`, or without either those of exact distributions.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ScatteringMethod {
    /// Samples a ray.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steps: Option<usize>,
    /// How they are moved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub jitter: Option<Jitter>,
    /// What a texel of the rectified map holds, and the bound that reads it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stored: Option<TechniqueSpec>,
    /// GDC16's blend by the angle to the light in place of the technique's beta.
    #[serde(default)]
    pub adaptive: bool,
    /// Whether the shadow map is filtered while it is resampled.
    #[serde(default)]
    pub filtered: bool,
    /// How far apart samples are taken to be.
    #[serde(default)]
    pub spacing: Spacing,
    /// Depths are stored from `margin` to 1 - `margin`.
    #[serde(default)]
    pub margin: f64,
    /// Guard band in place of the experiment's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub guard_band: Option<f64>,
    /// Numbers that sums and bounds are computed with.
    #[serde(default)]
    pub precision: Precision,
}

/// A method on one camera.
pub(super) enum Prepared<'a> {
    Marched(Marched),
    Exact(ExactPrefixes<'a>),
    Double(Prefiltered<'a, f64>),
    Single(Prefiltered<'a, f32>),
}

/// Bits of a depth of the shadow map that rays are marched through.
const DEPTH_BITS: usize = 16;

impl ScatteringMethod {
    /// Rejects what cannot be prepared; `place` is the method's key.
    pub(super) fn check(&self, name: &str, place: &str) -> Result<(), EvaluationError> {
        let fail = |key: &str, reason: String| {
            Err(EvaluationError::key(format!("{place}.{key}"), format!("technique `{name}`: {reason}")))
        };
        if let Some(steps) = self.steps {
            let of_prefixes = [
                ("stored", self.stored.is_some()),
                ("adaptive", self.adaptive),
                ("filtered", self.filtered),
                ("spacing", self.spacing != Spacing::default()),
                ("margin", self.margin != 0.0),
                ("guard_band", self.guard_band.is_some()),
                ("precision", self.precision != Precision::Double),
            ];
            if let Some((key, _)) = of_prefixes.into_iter().find(|(_, is_given)| *is_given) {
                return fail(key, format!("{key} is for prefix sums, not for {steps} steps"));
            }
            return if steps > 0 { Ok(()) } else { fail("steps", "0 steps are none".to_owned()) };
        }
        if self.jitter.is_some() {
            return fail("jitter", "jitter moves steps, of which there are none".to_owned());
        }
        if let Some(band) = self.guard_band.filter(|band| !(0.0..=1.0).contains(band)) {
            return fail("guard_band", format!("guard_band = {band} is not in [0, 1]"));
        }
        if !(0.0..0.5).contains(&self.margin) {
            return fail("margin", format!("margin = {} is not in [0, 0.5)", self.margin));
        }
        let Some(stored) = &self.stored else {
            let of_stored = [
                ("adaptive", self.adaptive),
                ("margin", self.margin != 0.0),
                ("precision", self.precision != Precision::Double),
            ];
            return match of_stored.into_iter().find(|(_, is_given)| *is_given) {
                Some((key, _)) => fail(key, format!("{key} needs something that is stored")),
                None => Ok(()),
            };
        };
        if self.spacing == Spacing::Own {
            return fail(
                "spacing",
                "spacing = own: stored sums are shared by rays of many spacings".to_owned(),
            );
        }
        let technique = stored.draft().map_err(in_key(&format!("{place}.stored")))?;
        if technique.real_time().is_none() {
            return fail("stored", format!("{} has no closed form", technique.name()));
        }
        if self.adaptive && (!technique.bound().has_upper() || stored.beta != 0.0) {
            let reason = format!("{} has no upper bound to blend with, or beta is given", technique.name());
            return fail("adaptive", format!("adaptive: {reason}"));
        }
        Ok(())
    }

    /// Memory of a texel that is looked up.
    pub(super) fn bits_per_texel(&self, technique: Option<&Technique>) -> usize {
        match technique {
            Some(technique) if self.spacing == Spacing::Two => 2 * technique.bits_per_texel(),
            Some(technique) => technique.bits_per_texel(),
            None => DEPTH_BITS,
        }
    }

    /// How bounds are blended.
    pub(super) fn blending(&self) -> Blending {
        let beta = self.stored.as_ref().map_or(0.0, |stored| stored.beta);
        if self.adaptive { Blending::Adaptive } else { Blending::Fixed(beta) }
    }

    /// The rectified map that it takes.
    pub(super) fn rectified<'a>(
        &self,
        maps: &'a Maps,
        default_band: f64,
    ) -> Result<&'a RectifiedMap, EvaluationError> {
        maps.get(self.filtered, self.guard_band.unwrap_or(default_band))
    }

    /// The method for a camera.
    pub(super) fn prepare<'a>(
        &self,
        shot: &Shot<'_>,
        maps: &'a Maps,
        technique: Option<&'a Technique>,
        (guard_band, seed): (f64, u64),
    ) -> Result<Prepared<'a>, EvaluationError> {
        if let Some(steps) = self.steps {
            let jitter = self.jitter.unwrap_or_default();
            return Ok(Prepared::Marched(Marched { steps, jitter, seed }));
        }
        let rectified = self.rectified(maps, guard_band)?;
        let spacing = self.spacing.inverse_sines(rectified, &shot.frustum, &shot.view, &shot.rays);
        let Some(technique) = technique else {
            return Ok(Prepared::Exact(ExactPrefixes::new(rectified, spacing)));
        };
        let stored = StoredPrefixes { technique, blending: self.blending(), margin: self.margin };
        let fail = |error: FilteringError| EvaluationError::Value(error.to_string());
        Ok(match self.precision {
            Precision::Double => {
                Prepared::Double(Prefiltered::new(stored, rectified, &shot.view, &spacing).map_err(fail)?)
            }
            Precision::Single => {
                Prepared::Single(Prefiltered::new(stored, rectified, &shot.view, &spacing).map_err(fail)?)
            }
        })
    }
}

impl Prepared<'_> {
    /// The lit share; NaN where there is none in \[0, 1\].
    pub(super) fn lit(&self, view: &SingleScattering<'_>, ray: &ViewRay) -> f64 {
        let answer = match self {
            Self::Marched(method) => method.estimate(view, ray),
            Self::Exact(method) => method.estimate(view, ray),
            Self::Double(method) => method.estimate(view, ray),
            Self::Single(method) => method.estimate(view, ray),
        };
        answer.ok().filter(|lit| (0.0..=1.0).contains(lit)).unwrap_or(f64::NAN)
    }
}
