//! Certified lower bounds on a graphics processor: the stages of [`moment_problem::lane_simplex`] as compute passes in double
//! precision, through any adapter that has it.
//!
//! Programs stay on the card ([`ResidentPrograms`]), candidates come in batches. What goes back is small: a sum for every
//! [`GROUP`] programs, one bound of each group to be checked, and the bases of the few programs that double precision cannot
//! certify, which [`ExactSimplex`](moment_problem::lane_simplex::ExactSimplex) decides.

mod card;
mod programs;
mod resident;
mod shader;
mod submission;

pub use card::{Card, CardError};
pub use programs::{Answer, GroupSums, Left, Pass, Programs, Weighting};
pub use resident::ResidentPrograms;
pub use submission::Submitted;

/// Programs whose errors are summed together.
pub const GROUP: usize = shader::GROUP as usize;
