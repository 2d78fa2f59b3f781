//! Experiments as data: trials, records, provenance.

mod method;

pub use method::{Domain, Method, Solver, method};
