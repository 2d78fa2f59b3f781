//! A method as an experiment writes it down.

use crate::error::EvaluationError;
use crate::experiment::keys::in_key;
use crate::kinds::soft_shadows::MethodSetting;
use crate::kinds::stochastic_shadows::StochasticSetting;
use crate::lit_frames::Anew;
use crate::role::plays_a_role;
use applications::temporal::{FilterSource, MovingCasters, TemporalMethod};
use quantization::NumberFormat;
use serde::{Deserialize, Serialize};
use shadow_filtering::DepthBias;

/// A method with its names.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct TemporalTechnique {
    /// Name in records and legends.
    pub name: String,
    /// Part in what papers claim, unique among its like.
    pub role: Option<String>,
    /// Depth bias, where it is not that of the experiment.
    pub bias: Option<DepthBias>,
    /// What it does.
    pub choice: MethodChoice,
}

/// What a technique does.
#[derive(Clone, Debug, PartialEq)]
pub enum MethodChoice {
    /// Gathers over time.
    Temporal(TemporalMethod),
    /// Percentage-closer soft shadows with so many taps for search and filter each.
    Taps(usize),
    /// A method of the kind `soft-shadows`, made anew for each frame.
    Soft(MethodSetting),
    /// A stochastic map a frame, of the kind `stochastic-shadows`; judged in the last judged frame of each path.
    Stochastic(Box<StochasticSetting>),
}

/// As it stands in the file: one of the four keys.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Written {
    name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    role: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    bias: Option<DepthBias>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    gather: Option<GatherSetting>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    taps: Option<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    method: Option<MethodSetting>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    stochastic: Option<Box<StochasticSetting>>,
}

/// How shadows are gathered. Left out, every key is as TC09 publishes it.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct GatherSetting {
    #[serde(skip_serializing_if = "Option::is_none")]
    start_tests: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    threshold: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tolerance: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    depth_range: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cautious: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    blockers_only: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    most_tests: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    format: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    filter: Option<FilterName>,
    #[serde(skip_serializing_if = "Option::is_none")]
    interpolated: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    moving: Option<MovingName>,
    #[serde(skip_serializing_if = "Option::is_none")]
    follow: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    centre_map: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    exact: Option<bool>,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
enum FilterName {
    Off,
    Previous,
    Current,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
enum MovingName {
    Ignored,
    Texel,
    Search,
}

impl GatherSetting {
    fn method(&self) -> Result<TemporalMethod, String> {
        let published = TemporalMethod::published();
        let format: NumberFormat = match &self.format {
            Some(name) => name.parse().map_err(|error| format!("format: {error}"))?,
            None => published.format,
        };
        let filter = self.filter.map_or(published.filter, |name| match name {
            FilterName::Off => FilterSource::Off,
            FilterName::Previous => FilterSource::Previous,
            FilterName::Current => FilterSource::Current,
        });
        let moving = self.moving.map_or(published.moving, |name| match name {
            MovingName::Ignored => MovingCasters::Ignored,
            MovingName::Texel => MovingCasters::Texel,
            MovingName::Search => MovingCasters::Search,
        });
        Ok(TemporalMethod {
            start_tests: self.start_tests.unwrap_or(published.start_tests),
            start_blockers: published.start_blockers,
            threshold: self.threshold.unwrap_or(published.threshold),
            tolerance: self.tolerance.unwrap_or(published.tolerance),
            depth_range: self.depth_range.unwrap_or(published.depth_range),
            cautious: self.cautious.unwrap_or(published.cautious),
            blockers_only: self.blockers_only.unwrap_or(published.blockers_only),
            most_tests: self.most_tests.unwrap_or(published.most_tests),
            format,
            filter,
            interpolated: self.interpolated.unwrap_or(published.interpolated),
            moving,
            follow: self.follow.unwrap_or(published.follow),
            centre_map: self.centre_map.unwrap_or(published.centre_map),
            exact: self.exact.unwrap_or(published.exact),
        })
    }

    /// Every key of a method.
    fn of(method: &TemporalMethod) -> Self {
        Self {
            start_tests: Some(method.start_tests),
            threshold: Some(method.threshold),
            tolerance: Some(method.tolerance),
            depth_range: Some(method.depth_range),
            cautious: Some(method.cautious),
            blockers_only: Some(method.blockers_only),
            most_tests: method.most_tests.is_finite().then_some(method.most_tests),
            format: Some(method.format.name()),
            filter: Some(match method.filter {
                FilterSource::Off => FilterName::Off,
                FilterSource::Previous => FilterName::Previous,
                FilterSource::Current => FilterName::Current,
            }),
            interpolated: Some(method.interpolated),
            moving: Some(match method.moving {
                MovingCasters::Ignored => MovingName::Ignored,
                MovingCasters::Texel => MovingName::Texel,
                MovingCasters::Search => MovingName::Search,
            }),
            follow: Some(method.follow),
            centre_map: Some(method.centre_map),
            exact: Some(method.exact),
        }
    }
}

impl TryFrom<Written> for TemporalTechnique {
    type Error = String;

    fn try_from(written: Written) -> Result<Self, String> {
        let Written { name, role, bias, gather, taps, method, stochastic } = written;
        let choice = match (gather, taps, method, stochastic) {
            (Some(gather), None, None, None) => MethodChoice::Temporal(
                gather.method().map_err(|error| format!("technique `{name}`: {error}"))?,
            ),
            (None, Some(taps), None, None) => MethodChoice::Taps(taps),
            (None, None, Some(method), None) => MethodChoice::Soft(method),
            (None, None, None, Some(setting)) => MethodChoice::Stochastic(setting),
            _ => {
                return Err(format!(
                    "technique `{name}` needs one of `gather`, `taps`, `method` and `stochastic`"
                ));
            }
        };
        Ok(Self { name, role, bias, choice })
    }
}

impl From<TemporalTechnique> for Written {
    fn from(technique: TemporalTechnique) -> Self {
        let TemporalTechnique { name, role, bias, choice } = technique;
        let written = Self { name, role, bias, ..Self::default() };
        match choice {
            MethodChoice::Temporal(method) => Self { gather: Some(GatherSetting::of(&method)), ..written },
            MethodChoice::Taps(taps) => Self { taps: Some(taps), ..written },
            MethodChoice::Soft(method) => Self { method: Some(method), ..written },
            MethodChoice::Stochastic(setting) => Self { stochastic: Some(setting), ..written },
        }
    }
}

plays_a_role!(TemporalTechnique);

impl MethodChoice {
    /// Nothing for methods that gather or sample the light.
    pub(super) fn anew(&self) -> Option<Anew<'_>> {
        match self {
            Self::Temporal(_) | Self::Stochastic(_) => None,
            Self::Taps(taps) => Some(Anew::Taps(*taps)),
            Self::Soft(method) => Some(Anew::Soft(method)),
        }
    }
}

impl TemporalTechnique {
    pub(super) fn check(&self, place: &str) -> Result<(), EvaluationError> {
        if let Some(bias) = &self.bias {
            bias.check().map_err(in_key(&format!("{place}.bias")))?;
        }
        match &self.choice {
            MethodChoice::Temporal(method) => method.check().map_err(|error| {
                let key = format!("{place}.gather.{}", error.key);
                EvaluationError::key(key, format!("technique `{}`: {error}", self.name))
            }),
            MethodChoice::Taps(taps) => Anew::Taps(*taps).check(&self.name, place),
            MethodChoice::Soft(method) => Anew::Soft(method).check(&self.name, place),
            MethodChoice::Stochastic(setting) => setting.check(&self.name, &format!("{place}.stochastic")),
        }
    }
}
