//! Experiments of kind `bounds`: bounds over all fragment depths, for kernels and bases (MSM15 Figures 2 and 3).

mod records;
mod run;
mod settings;

pub use records::{BoundsRecord, BoundsSample, KernelRecord};
pub use settings::{BoundsExperiment, Figure, Mark, Technique, Timing};
