//! One conformance suite for every `LowerBound`, the properties that MSM15 proves, and published reference vectors.

#![allow(clippy::unwrap_used)] // a test may stop at a failure it did not expect

mod conformance;
mod properties;
mod reference_vectors;
mod rounded_moments;
mod samples;
