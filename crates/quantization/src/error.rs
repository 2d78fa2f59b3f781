//! What can go wrong, with the numbers in it.

use crate::interval::DepthInterval;
use moment_problem::BasisError;
use thiserror::Error;

/// Why a basis could not be quantised.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum QuantizationError {
    /// The basis itself is at fault.
    #[error(transparent)]
    Basis(#[from] BasisError),
    /// Depths between which there is nothing.
    #[error("depths from {start} to {end} are no interval: its ends must be finite and its length above 0")]
    Interval {
        /// Its first depth.
        start: f64,
        /// Its last depth.
        end: f64,
    },
    /// A function without a finite value on the interval of depths.
    #[error("basis function `{name}` is not finite at {at}, a depth of the interval from {start} to {end}")]
    NotFinite {
        /// The function.
        name: String,
        /// Where.
        at: f64,
        /// First depth.
        start: f64,
        /// Last depth.
        end: f64,
    },
    /// The curve b lies in a plane, so that no transform makes it fill a box.
    #[error(
        "the curve of the basis is flat: `{name}` differs from a combination of a constant and the functions before it \
         by {share:.1e} of its size only, below {smallest:.0e}"
    )]
    Singular {
        /// The function that adds nothing.
        name: String,
        /// Norm of what it adds over its norm.
        share: f64,
        /// Least accepted share.
        smallest: f64,
    },
    /// A function that no polynomial of accepted degree describes.
    #[error(
        "basis function `{name}` varies too fast: a polynomial of degree {degree} misses it by {miss:.1e}"
    )]
    Unresolved {
        /// The function.
        name: String,
        /// Largest degree tried.
        degree: usize,
        /// Relative error.
        miss: f64,
    },
    /// Even and odd rows where the basis has no such functions.
    #[error(
        "`{name}` makes a row that is neither even nor odd about the depth {centre}: use the dense structure"
    )]
    NoParity {
        /// The first function at fault.
        name: String,
        /// Middle of the interval.
        centre: f64,
    },
    /// A transform that does not keep what it promises once its matrix is rounded.
    #[error(
        "the matrix found does not survive rounding: stored values would range from {range_min:.3e} to {range_max:.3e} \
         and the gain of {gain_bits:.6} bits has a proved bound of {bound_bits:.6}; write the functions over depths \
         mapped to [0, 1]"
    )]
    Contradicted {
        /// Least stored value.
        range_min: f64,
        /// Largest stored value.
        range_max: f64,
        /// Gain of the rounded matrix.
        gain_bits: f64,
        /// What is proved of any.
        bound_bits: f64,
    },
    /// Functions that single precision cannot hold.
    #[error("{basis} exceeds single precision on {interval}: map depths to [0, 1] first")]
    Overflow {
        /// The functions.
        basis: String,
        /// The depths.
        interval: DepthInterval,
    },
    /// A transform of depths that must be mapped first.
    #[error("a transform for depths in {interval} exists only for depths mapped to {depths} first")]
    Rescaled {
        /// Depths asked for.
        interval: DepthInterval,
        /// Depths of the transform.
        depths: DepthInterval,
    },
    /// Nothing to start from.
    #[error("0 starts find nothing: at least 1 is needed")]
    NoStarts,
    /// A transform that cannot be inverted.
    #[error("a {rows}x{rows} matrix of determinant {determinant:e} cannot be inverted")]
    NotInvertible {
        /// Number of rows.
        rows: usize,
        /// Its determinant, or NaN if an entry is not finite.
        determinant: f64,
    },
    /// Numbers of the wrong count.
    #[error("{what}: {got} numbers given, {expected} expected")]
    Length {
        /// Of what.
        what: &'static str,
        /// Numbers expected.
        expected: usize,
        /// Numbers given.
        got: usize,
    },
    /// A parameter outside its range.
    #[error("{key} = {value}: {reason}")]
    Parameter {
        /// Its name.
        key: &'static str,
        /// Its value.
        value: String,
        /// What it should be.
        reason: String,
    },
}
