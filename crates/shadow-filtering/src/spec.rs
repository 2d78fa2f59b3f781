//! Techniques as written in an experiment: `{ bound = "hamburger4", format = "unorm16", alpha = 6e-5 }`.

use crate::error::FilteringError;
use crate::technique::Technique;
use crate::techniques::{BiasedMoments, FAMILIES, Family};
use crate::transforms;
use moment_problem::{Interval, MomentBound};
use quantization::published::Published;
use quantization::{DepthInterval, Encoding, NumberFormat, Search};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A technique, one key a part; the bound names its basis. Keys in the plural stand for one technique each.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct TechniqueSpec {
    /// The bound G; `certified` where only a basis is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound: Option<BoundName>,
    /// For `certified`: the basis as on the command line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub basis: Option<String>,
    /// For `esm`: c per depth range. For `evsm`: that of the ascending warp, per half depth range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exponent: Option<f64>,
    /// For `evsm`: that of the descending warp; without it there are two channels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub negative_exponent: Option<f64>,
    /// For `lvsm`: layers of equal size.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layers: Option<usize>,
    /// For `csm` and `fourier`: M, two channels each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coefficients: Option<usize>,
    /// For moments: the variable that is stored; a published transform has its own, and every bound a usual one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<Range>,
    /// For moments: the moment bias (MSM15 section 4.2); without it the least that the precision needs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alpha: Option<f64>,
    /// For moments: several to try.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub alphas: Vec<f64>,
    /// For moments: b*, in their own variable; without it the moments of the arcsine or the uniform distribution.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub centre: Option<Vec<f64>>,
    /// For moments: 0 the lower bound, 1 the upper, between them BHS16's blend.
    #[serde(skip_serializing_if = "is_zero")]
    pub beta: f64,
    /// What is stored in place of b(z): `identity`, without which nothing is changed; `plain`, each function stretched to
    /// \[0, 1\] by itself; `sampled`, the same for any technique, by samples and with a margin; `optimal`, the best one for
    /// moments; or the name of a published one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transform: Option<String>,
    /// Several of these.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub transforms: Vec<String>,
    /// Number format of a value: `unorm8`, `unorm10`, `unorm16`, `f16`, `f32`, `u32/N`;
    /// without it `f32`.
    #[serde(skip_serializing_if = "Option::is_none", with = "format_text")]
    pub format: Option<NumberFormat>,
    /// Several of these.
    #[serde(skip_serializing_if = "Vec::is_empty", with = "format_texts")]
    pub formats: Vec<NumberFormat>,
    /// Refused by name: how techniques were spelled once.
    #[serde(skip_serializing)]
    pub kind: Option<String>,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// A bound by its name in experiments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoundName(&'static str);

impl BoundName {
    /// The name.
    pub fn as_str(self) -> &'static str {
        self.0
    }

    /// All of them.
    pub fn all() -> impl Iterator<Item = Self> {
        FAMILIES.iter().map(|family| Self(family.name))
    }

    /// The inequality or bound, and where it stands.
    pub fn equations(self) -> &'static str {
        self.family().map_or("", |family| family.equations)
    }

    /// Which moments it bounds, where it is the bound of moments.
    pub fn moments(self) -> Option<MomentBound> {
        self.family().and_then(Family::moments)
    }

    fn family(self) -> Option<&'static Family> {
        FAMILIES.iter().find(|family| family.name == self.0)
    }
}

impl std::str::FromStr for BoundName {
    type Err = FilteringError;

    fn from_str(text: &str) -> Result<Self, FilteringError> {
        FAMILIES.iter().find(|family| family.name == text).map(|family| Self(family.name)).ok_or_else(|| {
            let known: Vec<&str> = FAMILIES.iter().map(|family| family.name).collect();
            FilteringError::parameter("bound", text, format!("unknown (known: {})", known.join(", ")))
        })
    }
}

impl Serialize for BoundName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0)
    }
}

impl<'de> Deserialize<'de> for BoundName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

/// The variable whose functions are stored.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Range {
    /// Depth z, from 0 to 1.
    #[default]
    Unit,
    /// 2 z - 1, from -1 to 1.
    Signed,
}

impl Range {
    /// The usual one: power moments on the whole line lose fewer digits where depth runs from -1 to 1.
    pub fn of(bound: MomentBound) -> Self {
        match bound.interval() {
            Interval::Real => Self::Signed,
            Interval::Unit => Self::Unit,
        }
    }

    /// That of a published transform.
    pub fn of_published(published: &Published) -> Self {
        if published.signed { Self::Signed } else { Self::Unit }
    }

    /// The values.
    pub fn interval(self) -> DepthInterval {
        match self {
            Self::Unit => DepthInterval::UNIT,
            Self::Signed => DepthInterval::SIGNED,
        }
    }

    /// Name in experiments and records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unit => "unit",
            Self::Signed => "signed",
        }
    }
}

impl From<MomentBound> for TechniqueSpec {
    /// The bound with nothing else said.
    fn from(bound: MomentBound) -> Self {
        let name = FAMILIES.iter().find(|family| family.moments() == Some(bound));
        Self { bound: name.map(|family| BoundName(family.name)), ..Self::default() }
    }
}

impl TechniqueSpec {
    /// A bound with nothing else said.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] for an unknown name.
    pub fn named(bound: &str) -> Result<Self, FilteringError> {
        Ok(Self { bound: Some(bound.parse()?), ..Self::default() })
    }

    /// The number format.
    pub fn format(&self) -> NumberFormat {
        self.format.unwrap_or(NumberFormat::F32)
    }

    /// Name of the transform.
    pub fn transform(&self) -> &str {
        self.transform.as_deref().unwrap_or("identity")
    }

    /// Which moments are bounded, where the bound is that of moments.
    pub fn moment_bound(&self) -> Option<MomentBound> {
        self.bound.and_then(BoundName::moments)
    }

    /// Whether a linear program is solved for each fragment.
    pub fn is_certified(&self) -> bool {
        self.basis.is_some()
    }

    /// The variable whose moments are stored.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] for an unknown transform.
    pub fn stored_range(&self) -> Result<Range, FilteringError> {
        let own = transforms::published(self)?.map(Range::of_published);
        let usual = self.moment_bound().map_or(Range::Unit, Range::of);
        Ok(own.or(self.range).unwrap_or(usual))
    }

    /// The technique. Transforms that are searched for start from the default seed.
    ///
    /// # Errors
    /// [`FilteringError`] naming the key and its value.
    pub fn build(&self) -> Result<Technique, FilteringError> {
        self.build_with(&Search::default())
    }

    /// The technique, with transforms found by a search.
    ///
    /// # Errors
    /// As [`TechniqueSpec::build`].
    pub fn build_with(&self, search: &Search) -> Result<Technique, FilteringError> {
        self.resolved(Some(search))
    }

    /// The technique with the identity in place of transforms that have to be computed: whether
    /// [`TechniqueSpec::build`] works, at once.
    ///
    /// # Errors
    /// As [`TechniqueSpec::build`].
    pub fn draft(&self) -> Result<Technique, FilteringError> {
        self.resolved(None)
    }

    /// One technique for each combination of the transforms, formats and moment biases that are listed, in this order.
    pub fn sweep(&self) -> Vec<Self> {
        fn each<T: Clone>(one: &Option<T>, all: &[T]) -> Vec<Option<T>> {
            if all.is_empty() { vec![one.clone()] } else { all.iter().cloned().map(Some).collect() }
        }
        let mut specs = Vec::new();
        for transform in each(&self.transform, &self.transforms) {
            for format in each(&self.format, &self.formats) {
                for alpha in each(&self.alpha, &self.alphas) {
                    let (transforms, formats, alphas) = (Vec::new(), Vec::new(), Vec::new());
                    let transform = transform.clone();
                    let single =
                        Self { transform, transforms, format, formats, alpha, alphas, ..self.clone() };
                    specs.push(single);
                }
            }
        }
        specs
    }

    /// The bound of biased moments, where the bound is that of moments.
    ///
    /// # Errors
    /// As [`TechniqueSpec::build`].
    pub fn biased_moments(&self) -> Result<Option<BiasedMoments>, FilteringError> {
        self.moment_bound().map(|bound| BiasedMoments::new(bound, &self.ranged()?)).transpose()
    }

    fn ranged(&self) -> Result<Self, FilteringError> {
        let range = self.moment_bound().map(|_| self.stored_range()).transpose()?;
        Ok(Self { range, ..self.clone() })
    }

    fn resolved(&self, search: Option<&Search>) -> Result<Technique, FilteringError> {
        let family = self.family()?;
        let spec = self.ranged()?;
        let parts = family.parts(&spec)?;
        let transform = transforms::transform(&spec, parts.basis.as_ref(), search)?;
        Technique::new(parts.basis, Encoding::new(transform, self.format()), parts.bound)
    }

    /// The bound's entry; refuses keys that it does not take.
    fn family(&self) -> Result<&'static Family, FilteringError> {
        if let Some(kind) = &self.kind {
            return Err(FilteringError::parameter(
                "kind",
                kind,
                "techniques are spelled `bound = \"...\"` now",
            ));
        }
        let name = match (self.bound, &self.basis) {
            (Some(name), _) => name,
            (None, Some(_)) => "certified".parse()?,
            (None, None) => {
                return Err(FilteringError::parameter(
                    "bound",
                    "",
                    "is missing: neither bound nor basis is given",
                ));
            }
        };
        let family = name.family().ok_or(FilteringError::parameter("bound", name.0, "unknown"))?;
        for (key, value) in self.given() {
            if !family.keys.contains(&key) {
                let reason = format!("`{}` has no {key}", family.name);
                return Err(FilteringError::parameter(key, value, reason));
            }
        }
        Ok(family)
    }

    /// Keys of the bound that are given, with their values; sweeps under their key in the singular.
    fn given(&self) -> Vec<(&'static str, String)> {
        fn text<T: std::fmt::Debug>(value: &Option<T>) -> Option<String> {
            value.as_ref().map(|value| format!("{value:?}"))
        }
        let alphas = (!self.alphas.is_empty()).then(|| format!("{:?}", self.alphas));
        let all = [
            ("basis", self.basis.clone()),
            ("exponent", text(&self.exponent)),
            ("negative_exponent", text(&self.negative_exponent)),
            ("layers", text(&self.layers)),
            ("coefficients", text(&self.coefficients)),
            ("range", self.range.map(|range| range.name().to_owned())),
            ("alpha", text(&self.alpha).or(alphas)),
            ("centre", text(&self.centre)),
            ("beta", (self.beta != 0.0).then(|| self.beta.to_string())),
        ];
        all.into_iter().filter_map(|(key, value)| Some((key, value?))).collect()
    }

    /// Refuses keys of storage that a kind of experiment has no use for.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] with the key.
    pub fn check_storage(&self, allowed: &[&str]) -> Result<(), FilteringError> {
        let keys = [
            ("alpha", self.alpha.is_some()),
            ("alphas", !self.alphas.is_empty()),
            ("transform", self.transform.is_some()),
            ("transforms", !self.transforms.is_empty()),
            ("format", self.format.is_some()),
            ("formats", !self.formats.is_empty()),
        ];
        match keys.into_iter().find(|(key, is_given)| *is_given && !allowed.contains(key)) {
            None => Ok(()),
            Some((key, _)) => {
                let reason = format!("this kind of experiment takes {} only", allowed.join(", "));
                Err(FilteringError::parameter(key, "given", reason))
            }
        }
    }
}

/// Number formats as text.
mod format_text {
    use super::*;

    pub(super) fn serialize<S: Serializer>(
        format: &Option<NumberFormat>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        format.map(NumberFormat::name).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<NumberFormat>, D::Error> {
        String::deserialize(deserializer)?.parse().map(Some).map_err(serde::de::Error::custom)
    }
}

/// Lists of them.
mod format_texts {
    use super::*;

    pub(super) fn serialize<S: Serializer>(
        formats: &[NumberFormat],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(formats.iter().map(|format| format.name()))
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<NumberFormat>, D::Error> {
        let texts = Vec::<String>::deserialize(deserializer)?;
        texts.iter().map(|text| text.parse().map_err(serde::de::Error::custom)).collect()
    }
}
