//! The affine transform, bias and number format in which moments are stored.
//!
//! The curve b(z) of a basis fills little of the box that a texel can represent, so that most stored codes are never
//! used (MSM15 section 4.3). An affine transform theta stretches it; log2 |det theta| is what it gains in bits of
//! entropy, and filtering commutes with it. This crate
//! - finds the theta that gains most, for any basis, and proves how much any can gain: [`optimise`], [`bound`];
//! - keeps the published ones, each once: [`published`];
//! - stores and restores values as texture hardware does: [`NumberFormat`], [`Encoding`], [`SummedAreaTable`];
//! - finds the bias that rounding makes necessary: [`bias`], [`MomentMatrix`];
//! - writes transforms as shader code: [`snippet`].
//!
//! ```
//! use moment_problem::Basis;
//! use quantization::{DepthInterval, Encoding, NumberFormat, Search, optimise};
//!
//! let basis = Basis::power(2);
//! let optimum = optimise(&basis, DepthInterval::UNIT, &Search::default())?;
//! assert!((optimum.gain_bits - 2.0).abs() < 1e-9 && optimum.bound_bits < 2.001);
//! let encoding = Encoding::new(optimum.transform, NumberFormat::Unorm16);
//! let b = [0.3, 0.1];
//! let back = encoding.decode(&encoding.encode(&b)?)?;
//! assert!((back[0] - b[0]).abs() < 1e-5 && (back[1] - b[1]).abs() < 1e-5);
//! # Ok::<(), quantization::QuantizationError>(())
//! ```

pub mod bias;
mod error;
mod interval;
mod optimum;
pub mod published;
pub mod snippet;
mod storage;

pub use bias::moment_matrix::MomentMatrix;
pub use error::QuantizationError;
pub use interval::DepthInterval;
pub use optimum::{Optimum, RANGE_TOLERANCE, Search, Structure, bound, gain_bits, optimise, transform_range};
pub use storage::{AffineTransform, Encoding, NumberFormat, Range, Rectangle, SummedAreaTable, plain, range};
