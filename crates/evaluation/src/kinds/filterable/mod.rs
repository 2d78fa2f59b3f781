//! Experiments of kind `filterable`: the error of filterable shadow maps against percentage-closer filtering
//! (MSM15 section 3.2).
//!
//! A fragment is a light-facing entry of a layered shadow map whose filter kernel lies inside the map. Texels that
//! nothing covers have depth 1, as in a shadow map cleared to the far plane.

mod agreement;
mod evaluate;
mod maps;
mod pairs;
mod picture;
mod plan;
mod records;
mod settings;
mod statistics;
mod tables;
mod timing;
mod view;

pub use maps::map_name;
pub use records::{AgreementRecord, CurveRecord, FilterableRecord, PairRecord, PictureRecord};
pub use settings::{FilterableExperiment, FilterableTechnique, FilterableTiming, MapSettings, Picture};
