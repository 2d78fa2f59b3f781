//! Experiments of kind `stability`: where methods fail on inputs that are hard in a known way, in which arithmetic and
//! storage, and from which moment bias on they no longer do.

mod cell;
mod check;
mod exact;
mod family;
mod input;
mod method;
mod records;
mod run;
mod scenes;
mod settings;
mod tally;

pub use records::{CellRecord, CheckRecord, PivotRecord, StabilityRecord, StabilitySample};
pub use settings::{
    Arithmetic, Route, Shape, Span, StabilityExperiment, StabilityFamily, StabilityMethod, StabilityTiming,
};
