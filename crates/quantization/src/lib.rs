//! The affine transform, bias and number format in which moments are stored.

mod bound;
mod chebyshev;
mod error;
mod interval;
mod optimise;
mod polish;
mod random;
mod range;
mod row_program;
mod search;
mod transform;
mod working_basis;

pub use bound::{LARGEST_BINARY_DETERMINANT, bound};
pub use error::QuantizationError;
pub use interval::DepthInterval;
pub use optimise::{Optimum, Search, Structure, default_starts, gain_bits, optimise, transform_range};
pub use random::Random;
pub use range::{Range, range};
pub use transform::AffineTransform;
