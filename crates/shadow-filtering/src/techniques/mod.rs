//! One file a technique, with its mathematics.

mod certified;
mod convolution;
mod exponential;
mod exponential_variance;
mod layered_variance;
mod moments;
mod two_surfaces;
mod variance;

pub use certified::Certified;
pub use convolution::Convolution;
pub use exponential::Exponential;
pub use exponential_variance::ExponentialVariance;
pub use layered_variance::LayeredVariance;
pub use moment_problem::MomentBound;
pub use moments::Moments;
pub use variance::Variance;
