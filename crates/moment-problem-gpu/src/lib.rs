//! Certified lower bounds on a graphics processor: the stages of [`moment_problem::lane_simplex`] as compute passes in double
//! precision, through any adapter that has it.
//!
//! Programs stay on the card ([`ResidentPrograms`]), candidates come in batches. What goes back is small: a sum for every
//! [`GROUP`] programs, one bound of each group to be checked, and the bases of the few programs that double precision cannot
//! certify, which [`ExactSimplex`](moment_problem::lane_simplex::ExactSimplex) decides.

mod card;
mod shader;

pub use card::{
    Answer, Card, CardError, GroupSums, Left, Pass, Programs, ResidentPrograms, Submitted, Weighting,
};

/// Programs whose errors are summed together.
pub const GROUP: usize = shader::GROUP as usize;
