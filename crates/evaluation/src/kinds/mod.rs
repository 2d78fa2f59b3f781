//! The kinds of experiment, one folder each.

pub(crate) mod bounds;
pub(crate) mod filterable;
pub(crate) mod quantization;
pub(crate) mod search;
pub(crate) mod speed_accuracy;
pub(crate) mod stability;
