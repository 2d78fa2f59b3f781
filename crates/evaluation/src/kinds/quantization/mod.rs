//! Experiments of kind `quantization`: what affine transforms, number formats and biases do to moments, to the valid
//! set, and to the error against percentage-closer filtering (MSM15 sections 4.2 and 4.3, BHS16 sections 2.5 and 3.2).

mod bias_search;
mod check;
mod gains;
mod geometry;
mod records;
mod run;
mod settings;
mod stored_technique;
mod workload;

pub use records::{
    BiasRecord, CodeRecord, ComparisonRecord, GainRecord, GainSample, HullRecord, QuantizationRecord,
};
pub use settings::{BiasTarget, GainSetting, QuantizationExperiment, StoreSetting, StructureName};
