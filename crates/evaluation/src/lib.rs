//! Experiments as data: trials, records, provenance.
//!
//! An [`Experiment`] is a TOML file that opens with a question and an expectation; running it creates a
//! [`RunDirectory`] with the resolved experiment, its records, raw timings and where they come from. Records depend on
//! the seed and the inputs only. Drawing is the business of `report`.

mod bounds;
mod error;
mod experiment;
mod filterable;
mod kernel;
mod lines;
mod method;
mod provenance;
mod quantization;
mod run;
mod run_directory;
mod search;
mod speed_accuracy;
mod stability;

pub use bounds::{
    BoundsExperiment, BoundsRecord, BoundsSample, Figure, KernelRecord, Mark, Technique, Timing,
};
pub use error::EvaluationError;
pub use experiment::{Experiment, Kind, Scale};
pub use filterable::{
    AgreementRecord, BiasSetting, CurveRecord, FilterableExperiment, FilterableRecord, FilterableSample,
    FilterableTechnique, FilterableTiming, MapSettings, Picture, PictureRecord, ViewRecord, map_name,
};
pub use kernel::{Kernel, Region, Surface, uniform_distribution};
pub use method::{Domain, Method, Solver, method};
pub use provenance::{Build, Provenance, cpu_model, logical_cores, sha256, utc};
pub use quantization::{
    Alphas, BiasRecord, BiasTarget, CodeRecord, ComparisonRecord, GainRecord, GainSample, GainSetting,
    HullRecord, QuantizationExperiment, QuantizationRecord, QuantizationViewRecord, RangeName, StoreSetting,
    StructureName,
};
pub use run::{Progress, Run, RunOptions};
pub use run_directory::{RecordedFile, RunDirectory, write_whole};
pub use search::{
    MarkRecord, Prediction, SearchAgreement, SearchAgreementRecord, SearchExperiment, SearchRecord,
    SearchReference, SearchSample, SearchTiming, SearchViewRecord, Shard, StageRecord,
};
pub use shadow_filtering::techniques::MomentBound;
pub use shadow_filtering::{DepthBias, TechniqueSpec};
pub use shadow_renderer::WHOLE_FRAME;
pub use speed_accuracy::{
    Advice, AdviceOptions, Blend, CandidateSetting, Choice, ComparisonSetting, DEFAULT_CANDIDATES,
    EveryViewSetting, FrameSample, FrameSetting, FrameTiming, GpuRecord, OrderSetting, OrderShare,
    PictureSetting, SpeedAccuracyExperiment, SpeedAccuracyRecord, SpeedSample, SpeedTiming, SpeedViewRecord,
};
pub use stability::{
    Arithmetic, CellRecord, CheckRecord, PivotRecord, Route, Shape, Span, StabilityExperiment,
    StabilityFamily, StabilityMethod, StabilityRecord, StabilitySample, StabilityViewRecord, Storage, Timed,
    WorstRecord,
};

/// The example of the README, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
