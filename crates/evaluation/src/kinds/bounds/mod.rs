//! Experiments of kind `bounds`: bounds over all fragment depths, for kernels and bases (MSM15 Figures 2 and 3).

mod kernel;
mod records;
mod run;
mod settings;

pub use kernel::{Region, Surface, SyntheticKernel, uniform_distribution};
pub use records::{BoundsRecord, BoundsSample, KernelRecord};
pub use settings::{BoundsExperiment, BoundsFigure, BoundsMark, BoundsTechnique, BoundsTiming};
