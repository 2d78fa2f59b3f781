//! A method as an experiment writes it down.

use crate::error::EvaluationError;
use crate::experiment::keys::in_key;
use crate::role::plays_a_role;
use applications::translucency::{OpaqueOccluders, Rounding, TranslucentMethod, Treatment};
use quantization::NumberFormat;
use serde::{Deserialize, Serialize};
use shadow_filtering::{FilteringError, TechniqueSpec};

/// In which order surfaces are blended.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum BlendOrder {
    /// From the farthest to the nearest surface of each texel.
    #[default]
    Exact,
    /// As the scene lists its triangles.
    Unsorted,
    /// By the depths of the triangles' centres.
    Centre,
}

/// A method with its names: one of `blended`, `absorbance`, `fourier`, `stochastic`, `deep` and `treatment`.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TranslucentTechnique {
    /// Name in records and legends.
    pub name: String,
    /// Part in what papers claim, unique among its like.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<String>,
    /// A filterable shadow map of transmittance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blended: Option<TechniqueSpec>,
    /// Where blending rounds to the format.
    #[serde(default, skip_serializing_if = "is_default")]
    pub rounding: Rounding,
    /// In which order it is blended.
    #[serde(default, skip_serializing_if = "is_default")]
    pub order: BlendOrder,
    /// Moments of absorbance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub absorbance: Option<TechniqueSpec>,
    /// A Fourier opacity map of so many real coefficients in half floats; an even number leaves one of them unused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fourier: Option<usize>,
    /// Of maps of absorption: what becomes of opaque surfaces.
    #[serde(default, skip_serializing_if = "is_default")]
    pub opaque: OpaqueOccluders,
    /// A stochastic shadow map of so many samples a texel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stochastic: Option<usize>,
    /// A deep shadow map.
    #[serde(default, skip_serializing_if = "is_default")]
    pub deep: bool,
    /// A shadow map that knows no translucency.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub treatment: Option<Treatment>,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Most samples of a texel, and most coefficients.
const MOST_SAMPLES: usize = 256;
const MOST_COEFFICIENTS: usize = 127;

/// Format of Fourier opacity maps, which have to be blended.
const FOURIER_FORMAT: NumberFormat = NumberFormat::F16;

/// The shadow map of opaque surfaces that stand beside a map of absorption: four moments as published.
fn opaque_moments() -> Result<TechniqueSpec, FilteringError> {
    Ok(TechniqueSpec {
        transform: Some("GDC16 four moments".to_owned()),
        format: Some(NumberFormat::Unorm16),
        alpha: Some(6e-5),
        ..TechniqueSpec::named("hamburger4")?
    })
}

plays_a_role!(TranslucentTechnique);

impl TranslucentTechnique {
    pub(super) fn check(&self, place: &str) -> Result<(), EvaluationError> {
        let fail = |key: &str, reason: String| {
            Err(EvaluationError::key(format!("{place}{key}"), format!("technique `{}`: {reason}", self.name)))
        };
        let given = [
            self.blended.is_some(),
            self.absorbance.is_some(),
            self.fourier.is_some(),
            self.stochastic.is_some(),
            self.deep,
            self.treatment.is_some(),
        ];
        if given.iter().filter(|&&given| given).count() != 1 {
            let known = "`blended`, `absorbance`, `fourier`, `stochastic`, `deep` and `treatment`";
            return fail("", format!("needs one of {known}"));
        }
        if self.blended.is_none() {
            if self.rounding != Rounding::default() {
                return fail(".rounding", "rounding is for what is blended".to_owned());
            }
            if self.order != BlendOrder::default() {
                return fail(".order", "order is for what is blended".to_owned());
            }
        }
        if self.absorbance.is_none() && self.fourier.is_none() && self.opaque != OpaqueOccluders::default() {
            return fail(".opaque", "opaque is for maps of absorption".to_owned());
        }
        for (key, spec) in [("blended", &self.blended), ("absorbance", &self.absorbance)] {
            let Some(spec) = spec else { continue };
            let technique = spec.draft().map_err(in_key(&format!("{place}.{key}"))).map_err(self.named())?;
            if technique.real_time().is_none() {
                return fail(&format!(".{key}"), format!("{} has no closed form", technique.name()));
            }
            if key == "absorbance" && !matches!(spec.format(), NumberFormat::F16 | NumberFormat::F32) {
                let format = spec.format().name();
                return fail(
                    ".absorbance.format",
                    format!("format = {format}: absorbance has no upper end, f16 and f32 hold it"),
                );
            }
        }
        if let Some(samples) = self.stochastic.filter(|samples| !(1..=MOST_SAMPLES).contains(samples)) {
            return fail(
                ".stochastic",
                format!("stochastic = {samples} is not between 1 and {MOST_SAMPLES}"),
            );
        }
        if let Some(count) = self.fourier.filter(|count| !(3..=MOST_COEFFICIENTS).contains(count)) {
            return fail(".fourier", format!("fourier = {count} is not between 3 and {MOST_COEFFICIENTS}"));
        }
        Ok(())
    }

    fn named(&self) -> impl Fn(EvaluationError) -> EvaluationError {
        move |error| match error {
            EvaluationError::Key { key, reason } => {
                EvaluationError::Key { key, reason: format!("technique `{}`: {reason}", self.name) }
            }
            other => other,
        }
    }

    /// Ready for any view.
    pub(super) fn method(&self) -> Result<TranslucentMethod, EvaluationError> {
        self.built()
            .map_err(|error| EvaluationError::Value(format!("technique `{}`: {error}", self.name)))?
            .ok_or_else(|| EvaluationError::Value(format!("technique `{}` has no method", self.name)))
    }

    fn built(&self) -> Result<Option<TranslucentMethod>, FilteringError> {
        if let Some(spec) = &self.blended {
            let technique = Box::new(spec.build()?);
            return Ok(Some(TranslucentMethod::Blended { technique, rounding: self.rounding }));
        }
        if let Some(spec) = &self.absorbance {
            let technique = Box::new(spec.build()?);
            let apart = Box::new(opaque_moments()?.build()?);
            return Ok(Some(TranslucentMethod::Absorbance { technique, opaque: self.opaque, apart }));
        }
        if let Some(count) = self.fourier {
            return Ok(Some(TranslucentMethod::Fourier {
                pairs: (count - 1) / 2,
                format: FOURIER_FORMAT,
                opaque: self.opaque,
                apart: Box::new(opaque_moments()?.build()?),
            }));
        }
        if let Some(samples) = self.stochastic {
            return Ok(Some(TranslucentMethod::Stochastic { samples }));
        }
        Ok(match self.treatment {
            Some(treatment) => Some(TranslucentMethod::Comparison(treatment)),
            None if self.deep => Some(TranslucentMethod::Deep),
            None => None,
        })
    }
}
