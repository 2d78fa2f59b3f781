//! One conformance suite for every `LowerBound`, the properties that MSM15 proves, and published reference vectors.

mod conformance;
mod properties;
mod reference_vectors;
mod samples;
