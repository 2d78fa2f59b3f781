//! Sharp bounds on a depth distribution from generalised moments, with evidence.

pub mod arithmetic;
mod basis;
pub mod batch;
mod bounds;
mod closed_form;
mod dense;
mod distribution;
mod error;
mod expression;
pub mod hamburger;
pub mod hausdorff;
mod hermite;
mod linear_program;
pub mod markov;
pub mod roots;
mod semi_infinite;
pub mod trigonometric;

pub use basis::{Basis, BasisFunction, DEFAULT_FAMILY, MAX_FUNCTIONS};
pub use bounds::{Bounds, Certificate, Interval, LowerBound};
pub use closed_form::{Chebyshev, Hamburger, Hausdorff4, Markov, Trigonometric4, closed_form};
pub use distribution::{DepthDistribution, WEIGHT_SUM_TOLERANCE};
pub use error::{BasisError, DistributionError, MomentError};
pub use linear_program::{LinearProgram, LpSolver};
pub use semi_infinite::{CERTIFIED_GAP, ExchangeSimplex, FEASIBILITY_TOLERANCE, PreparedBasis};
