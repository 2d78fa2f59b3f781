//! The transform that gains most for a basis, and how much any can gain.

mod ascent;
mod bound;
mod chebyshev;
mod gain;
mod polish;
mod row_program;
mod search;
mod working_basis;

pub use bound::bound;
pub use gain::gain_bits;
pub(crate) use search::sizes;
pub use search::{Optimum, RANGE_TOLERANCE, Search, Structure, optimise, transform_range};
