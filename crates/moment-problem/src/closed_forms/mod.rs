//! Closed forms as plain functions over any [`Real`](crate::arithmetic::Real), without evidence.

pub mod batch;
pub mod hamburger;
pub mod hausdorff;
pub mod markov;
mod moment_bound;
pub mod roots;
pub mod textbook;
pub mod trigonometric;

pub use moment_bound::MomentBound;
