//! One conformance suite for every `LowerBound`, the properties that MSM15 proves, and published reference vectors.

// A test may stop at a failure it did not expect, and reports what it skipped and measured.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod conformance;
mod properties;
mod reference_vectors;
mod rounded_moments;
mod samples;
