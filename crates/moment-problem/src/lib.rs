//! Sharp bounds on a depth distribution from generalised moments, with evidence.
//!
//! A filterable shadow map stores b(z), a vector of functions of the occluder depth; filtering turns it into the
//! moments E_Z\[b\] of the distribution Z of depths in the filter kernel. How dark must a fragment at depth z_f then be
//! at least? That is the least mass before z_f of any distribution with these moments (Peters and Klein, *Moment
//! Shadow Mapping*, 2015, Problem 1).
//!
//! - [`Basis`] and [`BasisFunction`]: the map b, any formula in z.
//! - [`DepthDistribution`]: weighted depths, their cumulative distribution and moments.
//! - [`LowerBound`]: moments and z_f to [`Bounds`] with a [`Certificate`]; closed forms ([`Hamburger`],
//!   [`Hausdorff4`], [`Trigonometric4`], [`Markov`]) and, for any basis on \[0, 1\], [`ExchangeSimplex`] and
//!   [`LinearProgram`].
//! - [`fast_simplex`]: the same program on one finite support for millions of kernels, certified.
//! - [`lane_simplex`]: the same for up to four functions with one program in each lane of a vector, the fastest.
//! - [`hamburger`], [`hausdorff`], [`trigonometric`], [`markov`]: the same closed forms as plain functions over `f32`,
//!   `f64` or [`arithmetic::DoubleDouble`]; [`textbook`]: as published, for comparison.
//! - [`MomentBound`]: the closed forms that shadow maps use, with all that is known of each.
//! - [`wgsl`]: their shader twins.
//!
//! ```
//! use moment_problem::{Basis, DepthDistribution, ExchangeSimplex, Hamburger, LowerBound, hamburger};
//!
//! // A filter kernel: half of the texels at depth 0.2, the rest further away.
//! let kernel = DepthDistribution::new(&[0.2, 0.45, 0.7], &[0.5, 0.2, 0.3])?;
//!
//! // The evidence form: certified bounds from four power moments.
//! let bounds = Hamburger::<4>::default().bounds_of(&kernel, 0.6)?;
//! assert!(bounds.lower <= kernel.cdf(0.6) && kernel.cdf(0.6) <= bounds.upper);
//! assert!(bounds.gap() < 1e-8);
//!
//! // The fast form, from filtered moments.
//! let b: Vec<f64> = kernel.moments(&Basis::power(4));
//! let pair = hamburger::hamburger4(&[b[0], b[1], b[2], b[3]], 0.6);
//! assert!((pair.lower - bounds.lower).abs() < 1e-9);
//!
//! // Any other basis.
//! let basis: Basis = "z, exp(-2z), sin(3pi z)".parse()?;
//! let other = ExchangeSimplex::new(&basis)?.bounds_of(&kernel, 0.6)?;
//! assert!(other.lower <= kernel.cdf(0.6));
//! # Ok::<(), moment_problem::MomentError>(())
//! ```

// What unit tests share with the others names the crate.
#[cfg(test)]
extern crate self as moment_problem;

pub mod arithmetic;
mod basis;
mod certified;
mod closed_forms;
pub mod dense;
mod distribution;
mod error;
pub mod fast_simplex;
pub mod lane_simplex;

pub use basis::{Basis, BasisFunction, FunctionKind, MAX_FUNCTIONS};
pub use certified::{BoundMethod, ExchangeSimplex, LinearProgram, LpSolver, Solver, method};
pub use certified::{Bounds, Certificate, Interval, LowerBound};
pub use certified::{Chebyshev, Hamburger, Hausdorff4, Markov, Trigonometric4, closed_form};
pub use closed_forms::{
    InFront, MomentBound, hamburger, hausdorff, markov, roots, textbook, trigonometric, wgsl,
};
pub use distribution::DepthDistribution;
pub use error::{BasisError, DistributionError, MomentError};
