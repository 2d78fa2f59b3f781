//! Bounds with evidence: closed forms, the exchange simplex and the linear program behind one interface.

mod bounds;
mod closed_form;
mod exact;
mod hamburger;
mod hermite;
mod linear_program;
mod method;
mod semi_infinite;

pub use bounds::{BoundMethod, Bounds, Certificate, Interval, LowerBound};
pub use closed_form::{Hausdorff4, Markov, Trigonometric4, closed_form};
pub use hamburger::{Chebyshev, Hamburger};
pub(crate) use linear_program::ask;
pub use linear_program::{LinearProgram, LpSolver};
pub use method::{Solver, method};
pub use semi_infinite::ExchangeSimplex;
pub(crate) use semi_infinite::{Column, FiniteProgram};
