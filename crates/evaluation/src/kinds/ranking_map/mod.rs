//! Experiments of kind `ranking-map`: how the ranking of all bases moves with the settings that a search takes for granted:
//! depth bias, filter kernel, cells of the support, reference, scenes.
//!
//! Every candidate is judged on every fragment of a sample under each of the settings, without a race, so that ranks of two
//! settings compare like with like. One variation with other fragments and nothing else says what sampling alone moves.

mod records;
mod run;
mod settings;

pub use records::{ClassRecord, FollowedRecord, VariationRecord};
pub use settings::{RankingMapExperiment, Variation};
