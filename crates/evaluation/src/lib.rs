//! Experiments as data: trials, records, provenance.
//!
//! An [`Experiment`] is a TOML file that opens with a question and an expectation; running it creates a
//! [`RunDirectory`] with the resolved experiment, its records, raw timings and where they come from. Records depend on
//! the seed and the inputs only. Drawing is the business of `report`.

mod advice;
mod error;
mod experiment;
mod forecast;
mod fragments;
mod kinds;
mod lit_frames;
mod pictures;
mod provenance;
mod role;
mod run;
mod run_directory;
mod shards;
mod statistics;
mod timing;

pub use advice::{
    Advice, AdviceOptions, Answer, BANDWIDTH, BiasInView, Budget, Choice, CostSource, Definitions, Measured,
    Nothing, NothingSoft, ReferenceSetting, ScatteringAdvice, ScatteringChoice, Shared, Shipping, SoftChoice,
    SoftShadowAdvice, Together, TranslucentCasterAdvice, TranslucentChoice,
};
pub use applications::BiasSetting;
pub use error::EvaluationError;
pub use experiment::{Alphas, CardPrediction, Experiment, Prediction, Scale};
pub use forecast::Forecast;
pub use fragments::{Lighting, ReferenceRecord, SceneSettings, TruthSetting, ViewRecord, check_scene};
pub use kinds::bounds::{
    BoundsExperiment, BoundsFigure, BoundsMark, BoundsRecord, BoundsSample, BoundsTechnique, BoundsTiming,
    KernelRecord, Region, Surface, SyntheticKernel, uniform_distribution,
};
pub use kinds::filterable::{
    AgreementRecord, CurveRecord, FilterableExperiment, FilterableRecord, FilterableTechnique,
    FilterableTiming, MapSettings, PairRecord, Picture, PictureRecord, map_name,
};
pub use kinds::quantization::{
    BiasRecord, BiasTarget, CodeRecord, ComparisonRecord, GainRecord, GainSample, GainSetting, HullRecord,
    QuantizationExperiment, QuantizationRecord, StoreSetting, StructureName,
};
pub use kinds::ranking_map::{ClassRecord, FollowedRecord, RankingMapExperiment, Variation, VariationRecord};
pub use kinds::search::{
    MarkRecord, SearchAgreement, SearchAgreementRecord, SearchExperiment, SearchRecord, SearchReference,
    SearchSample, SearchTiming, StageRecord,
};
pub use kinds::single_scattering::{
    AliasingRecord, AliasingSetting, EdgeRecord, MediumSetting, ScatteringCost, ScatteringMethod,
    ScatteringPasses, ScatteringPicture, ScatteringPictureRecord, ScatteringRecord, ScatteringStability,
    ScatteringTechnique, ScatteringTiming, ScatteringViewRecord, SingleScatteringExperiment, Standpoint,
    StandpointSetting, StoredBiasRecord,
};
pub use kinds::soft_shadows::{
    Corners, LightSetting, MethodSetting, PassSample, PassTiming, Population, Precision, ReceiverRecord,
    ReconstructionPoint, SearchTexel, SoftAdvice, SoftPicture, SoftPictureRecord, SoftRecord,
    SoftShadowsExperiment, SoftTechnique, SoftViewRecord, Sweep, SweepRecord, SweepValues,
};
pub use kinds::speed_accuracy::{
    Blend, COMPARED_FRAME, CandidateSetting, ComparisonSetting, EveryViewSetting, FrameRoute, FrameSample,
    FrameSetting, FrameTiming, OrderSetting, OrderShare, PictureSetting, SpeedAccuracyExperiment,
    SpeedAccuracyRecord, SpeedSample, SpeedTiming,
};
pub use kinds::stability::{
    Arithmetic, CellRecord, CheckRecord, PivotRecord, Route, Shape, Span, StabilityExperiment,
    StabilityFamily, StabilityMethod, StabilityRecord, StabilitySample, StabilityTiming,
};
pub use kinds::stochastic_shadows::{
    ModulationRecord, ModulationSetting, PlaneRecord, StochasticPicture, StochasticPictureRecord,
    StochasticRecord, StochasticSetting, StochasticShadowsExperiment, StochasticTechnique,
    StochasticViewRecord,
};
pub use kinds::temporal_shadows::{
    CountRecord, CountingSetting, GatherSetting, MethodChoice, PathSetting, TemporalAnimation,
    TemporalPicture, TemporalPictureRecord, TemporalRecord, TemporalShadowsExperiment, TemporalTechnique,
    TemporalViewRecord,
};
pub use kinds::translucent_shadows::{
    BlendOrder, BlendingRecord, ColourRecord, ColourSetting, TranslucentAdvice, TranslucentCost,
    TranslucentGroup, TranslucentPicture, TranslucentPictureRecord, TranslucentRecord,
    TranslucentShadowsExperiment, TranslucentStability, TranslucentTechnique, TranslucentViewRecord,
};
pub use lit_frames::ScaledLight;
pub use moment_problem::MomentBound;
pub use pictures::PICTURE_GAP;
pub use provenance::{Build, Provenance, logical_cores};
pub use role::{Role, with_role};
pub use run::{Backend, PartOptions, Progress, Run, RunOptions};
pub use run_directory::{RecordedFile, RunDirectory, write_whole};
pub use shadow_filtering::{DepthBias, KernelSpec, TechniqueSpec};
pub use shadow_renderer::WHOLE_FRAME;
pub use shards::{RoundState, Shard, ranges, round_state};
pub use statistics::NOTHING;
pub use timing::{GpuRecord, TimedSample, TimingSetting};

/// The page on the crates, its example compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/how-to/rust.md")]
struct FromRust;
