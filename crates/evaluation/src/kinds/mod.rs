//! The kinds of experiment: one folder and one line of the registry each.

pub(crate) mod bounds;
pub(crate) mod filterable;
pub(crate) mod quantization;
pub(crate) mod ranking_map;
pub(crate) mod search;
pub(crate) mod single_scattering;
pub(crate) mod soft_shadows;
pub(crate) mod speed_accuracy;
pub(crate) mod stability;
pub(crate) mod stochastic_shadows;
pub(crate) mod temporal_shadows;
pub(crate) mod translucent_shadows;

use crate::experiment::kind::Kind;

/// All kinds, in the order in which messages name them.
pub(crate) static KINDS: &[Kind] = &[
    Kind::of::<bounds::BoundsExperiment>(),
    Kind::of::<filterable::FilterableExperiment>(),
    Kind::of::<quantization::QuantizationExperiment>(),
    Kind::of::<search::SearchExperiment>(),
    Kind::of::<ranking_map::RankingMapExperiment>(),
    Kind::of::<stability::StabilityExperiment>(),
    Kind::of::<speed_accuracy::SpeedAccuracyExperiment>(),
    Kind::of::<soft_shadows::SoftShadowsExperiment>(),
    Kind::of::<single_scattering::SingleScatteringExperiment>(),
    Kind::of::<temporal_shadows::TemporalShadowsExperiment>(),
    Kind::of::<stochastic_shadows::StochasticShadowsExperiment>(),
    Kind::of::<translucent_shadows::TranslucentShadowsExperiment>(),
];
