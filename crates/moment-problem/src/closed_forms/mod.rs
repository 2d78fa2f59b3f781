//! Closed forms as plain functions over any [`Real`](crate::arithmetic::Real), without evidence.

pub(crate) mod canonical;
pub mod hamburger;
pub mod hausdorff;
mod in_front;
pub mod markov;
mod moment_bound;
mod pair;
pub mod roots;
pub mod textbook;
pub mod trigonometric;

/// The shader twins, as text. They need no bindings; what stands before them is stated.
pub mod wgsl {
    /// Exponential, sine and cosine to the last digits; clamps; constants of single precision.
    pub const ELEMENTARY: &str = include_str!("../arithmetic/elementary.wgsl");
    /// `chebyshev(mean, second, z_f)` and `cantelli`; after [`ELEMENTARY`].
    pub const CHEBYSHEV: &str = include_str!("chebyshev.wgsl");
    pub(super) const ROOTS: &str = include_str!("roots.wgsl");
    pub(super) const POWERS: &str = include_str!("powers.wgsl");
    pub(super) const HAMBURGER_2: &str = include_str!("hamburger2.wgsl");
    pub(super) const HAMBURGER_4: &str = include_str!("hamburger4.wgsl");
    pub(super) const HAMBURGER_4_BOUNDS: &str = include_str!("hamburger4_bounds.wgsl");
    pub(super) const HAMBURGER_6: &str = include_str!("hamburger6.wgsl");
    pub(super) const IN_FRONT: &str = include_str!("in_front.wgsl");
    pub(super) const IN_FRONT_2: &str = include_str!("in_front2.wgsl");
    pub(super) const IN_FRONT_4: &str = include_str!("in_front4.wgsl");
    pub(super) const IN_FRONT_HAMBURGER_4: &str = include_str!("in_front_hamburger4.wgsl");
    pub(super) const IN_FRONT_6: &str = include_str!("in_front6.wgsl");
    pub(super) const IN_FRONT_HAUSDORFF_4: &str = include_str!("in_front_hausdorff4.wgsl");
    pub(super) const BIAS: &str = include_str!("bias.wgsl");
    pub(super) const HAUSDORFF_4: &str = include_str!("hausdorff4.wgsl");
    pub(super) const TRIGONOMETRIC_4: &str = include_str!("trigonometric4.wgsl");
}

pub use in_front::InFront;
pub use moment_bound::MomentBound;
