//! A method as an experiment writes it down.

use crate::error::EvaluationError;
use crate::experiment::keys::{in_key, refuse};
use crate::kinds::soft_shadows::MethodSetting;
use crate::lit_frames::Anew;
use crate::role::plays_a_role;
use applications::stochastic::{Footprint, PlaneFilter, SampleCentre};
use serde::{Deserialize, Serialize};
use shadow_filtering::{DepthBias, Technique, TechniqueSpec};

/// A method with its names: one of `stochastic`, `taps` and `method`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct StochasticTechnique {
    /// Name in records and legends.
    pub name: String,
    /// Part in what papers claim, unique among its like.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<String>,
    /// Depth bias, where it is not that of the experiment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias: Option<DepthBias>,
    /// A stochastic soft shadow map.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stochastic: Option<StochasticSetting>,
    /// Percentage-closer soft shadows with so many taps for search and filter each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub taps: Option<usize>,
    /// A method of the kind `soft-shadows`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<MethodSetting>,
}

/// What a technique does.
pub(super) enum Choice<'a> {
    Stochastic(&'a StochasticSetting),
    Anew(Anew<'a>),
}

/// A stochastic soft shadow map. Left out, every key is as SSSM15 publishes it.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct StochasticSetting {
    /// The filterable representation with its storage.
    pub basis: TechniqueSpec,
    /// Depths of the filter planes, ascending in \[0, 1\].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub planes: Vec<f64>,
    /// In place of `planes`: so many where the visible receivers are, at even shares of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub receiver_planes: Option<usize>,
    /// Side of the map over that of the experiment's; 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side: Option<f64>,
    /// Least rho in texels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_radius: Option<f64>,
    /// R_G.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gather_radius: Option<usize>,
    /// Levels above the finest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coarse_levels: Option<usize>,
    /// Taps of the search for edges; 0 for none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edge_taps: Option<usize>,
    /// Whether samples reach from where the light's middle sees them, in place of the middle of their texel.
    #[serde(default)]
    pub projected: bool,
    /// Whether samples reach as far as the rectangle of the light, in place of a disc.
    #[serde(default)]
    pub rectangle: bool,
    /// Whether every sample is gathered, and levels are not smoothed.
    #[serde(default)]
    pub every_sample: bool,
    /// Whether shadows of two planes are blended in place of their values.
    #[serde(default)]
    pub blend_shadows: bool,
}

impl StochasticSetting {
    /// How planes are filtered.
    pub(super) fn filter(&self) -> PlaneFilter {
        let published = PlaneFilter::published();
        PlaneFilter {
            footprint: if self.rectangle { Footprint::Rectangle } else { published.footprint },
            centre: if self.projected { SampleCentre::Projected } else { published.centre },
            least_radius: self.least_radius.unwrap_or(published.least_radius),
            edge_taps: self.edge_taps.unwrap_or(published.edge_taps),
            gather_radius: self.gather_radius.unwrap_or(published.gather_radius),
            coarse_levels: self.coarse_levels.unwrap_or(published.coarse_levels),
            interleaved: !self.every_sample,
            box_filter: !self.every_sample,
            ..published
        }
    }

    /// Side of the map in an experiment whose maps have this side.
    pub(super) fn size(&self, of_experiment: u32) -> u32 {
        (self.side.unwrap_or(1.0) * f64::from(of_experiment)).round().clamp(1.0, f64::from(MAX_SIDE)) as u32
    }

    /// Whether another technique is filtered alike, so that both can share the work.
    pub(super) fn shares(&self, other: &Self) -> bool {
        let same =
            |setting: &Self| Self { basis: self.basis.clone(), blend_shadows: false, ..setting.clone() };
        same(self) == same(other)
    }

    /// Bits of a texel over all planes; 0 of a technique that cannot be built.
    pub(crate) fn bits_per_texel(&self) -> usize {
        let planes = self.receiver_planes.unwrap_or(self.planes.len());
        self.build().map_or(0, |technique| planes * technique.bits_per_texel())
    }

    /// The technique of its basis.
    pub(super) fn build(&self) -> Result<Technique, shadow_filtering::FilteringError> {
        self.basis.build()
    }

    /// Rejects what cannot be filtered; `place` is its key, `name` that of the technique.
    pub(crate) fn check(&self, name: &str, place: &str) -> Result<(), EvaluationError> {
        let fail = |key: &str, reason: String| {
            refuse(format!("{place}{key}"), format!("technique `{name}`: {reason}"))
        };
        self.basis.draft().and_then(|technique| technique.check_real_time()).map_err(|error| {
            let reason = format!("technique `{name}`: {error}");
            EvaluationError::key(format!("{place}.basis"), reason)
        })?;
        match (self.planes.as_slice(), self.receiver_planes) {
            ([], None) => {
                return fail("", "planes is empty: zero planes hold no shadow".to_owned());
            }
            ([], Some(count)) if !(1..=MAX_PLANES).contains(&count) => {
                let reason = format!("receiver_planes = {count} is not between 1 and {MAX_PLANES}");
                return fail(".receiver_planes", reason);
            }
            ([_, ..], Some(_)) => {
                return fail(".planes", "planes and receiver_planes exclude each other".to_owned());
            }
            (planes, _) => {
                if let Some(plane) = planes.iter().find(|plane| !(0.0..=1.0).contains(*plane)) {
                    let reason = format!("planes: {plane} lies outside of the depth range [0, 1]");
                    return fail(".planes", reason);
                }
                if planes.len() > MAX_PLANES || !planes.windows(2).all(|pair| pair[0] < pair[1]) {
                    let reason = format!("planes = {planes:?} are not up to {MAX_PLANES} ascending depths");
                    return fail(".planes", reason);
                }
            }
        }
        if let Some(side) = self.side
            && !(1.0 / 64.0..=64.0).contains(&side)
        {
            return fail(".side", format!("side = {side} is not between 1/64 and 64"));
        }
        self.filter().check().map_err(|error| {
            let key = format!("{place}.{}", error.key);
            EvaluationError::key(key, format!("technique `{name}`: {error}"))
        })
    }
}

/// Most planes.
const MAX_PLANES: usize = 64;

/// Largest side of a map: every texel is a ray.
const MAX_SIDE: u32 = 4096;

plays_a_role!(StochasticTechnique);

impl StochasticTechnique {
    /// What it does.
    pub(super) fn choice(&self) -> Option<Choice<'_>> {
        match (&self.stochastic, self.taps, &self.method) {
            (Some(setting), None, None) => Some(Choice::Stochastic(setting)),
            (None, Some(taps), None) => Some(Choice::Anew(Anew::Taps(taps))),
            (None, None, Some(method)) => Some(Choice::Anew(Anew::Soft(method))),
            _ => None,
        }
    }

    pub(super) fn check(&self, place: &str) -> Result<(), EvaluationError> {
        if let Some(bias) = &self.bias {
            bias.check().map_err(in_key(&format!("{place}.bias")))?;
        }
        match self.choice() {
            None => {
                let reason = "needs one of `stochastic`, `taps` and `method`";
                refuse(place, format!("technique `{}`: {reason}", self.name))
            }
            Some(Choice::Anew(anew)) => anew.check(&self.name, place),
            Some(Choice::Stochastic(setting)) => setting.check(&self.name, &format!("{place}.stochastic")),
        }
    }
}
