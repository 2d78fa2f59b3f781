//! The last part of a technique: the guess G(b, z_f) of the shadow from filtered values.

use crate::error::FilteringError;
use crate::operations::{Counted, count};
use moment_problem::arithmetic::Real;
use moment_problem::hamburger::Pair;

/// Depth clamped to \[0, 1\]; NaN becomes 1, the far plane.
pub(crate) fn unit<R: Real>(depth: R) -> R {
    let (zero, one) = (R::zero(), R::one());
    if depth < zero {
        zero
    } else if depth < one {
        depth
    } else {
        one
    }
}

/// G(b, z_f) in closed form, written once for all number types: in real time, with a twin in WGSL.
///
/// No method returns NaN; z_f is a depth in \[0, 1\].
pub trait ShadowBound: Send + Sync {
    /// The technique with its parameters, for tables.
    fn name(&self) -> String;

    /// The guess in \[0, 1\]: the approximate share of the kernel in front of z_f.
    fn shade<R: Real>(&self, b: &[R], z_f: R) -> R;

    /// Both bounds before they are blended; twice [`ShadowBound::shade`] where there is no upper one.
    fn bounds<R: Real>(&self, b: &[R], z_f: R) -> Pair<R> {
        let lower = self.shade(b, z_f);
        Pair { lower, upper: lower }
    }

    /// Whether [`ShadowBound::bounds`] has an upper bound.
    fn has_upper(&self) -> bool {
        false
    }

    /// Whether G <= F_Z(z_f) is a theorem.
    fn is_lower_bound(&self) -> bool {
        true
    }

    /// WGSL of basis and bound: `const CHANNELS`, `fn encode(depth: f32) -> array<f32, CHANNELS>` and
    /// `fn shade(filtered: array<f32, CHANNELS>, z_f: f32) -> f32`, with everything that they need. `None` without.
    fn shader(&self) -> Option<String> {
        None
    }
}

/// A bound behind a pointer, in the precisions in use. Implemented for every [`ShadowBound`]; bounds that solve a linear
/// program implement it themselves, and only they fail.
pub trait AnyBound: Send + Sync {
    /// As [`ShadowBound::name`].
    fn name(&self) -> String;

    /// As [`ShadowBound::shade`]. Moments are biased as much as double precision needs, unless the user has chosen a bias.
    ///
    /// # Errors
    /// [`FilteringError::Moments`] for a linear program without a certified solution.
    fn shade_double(&self, b: &[f64], z_f: f64) -> Result<f64, FilteringError>;

    /// As [`ShadowBound::bounds`].
    ///
    /// # Errors
    /// As [`AnyBound::shade_double`].
    fn bounds_double(&self, b: &[f64], z_f: f64) -> Result<Pair<f64>, FilteringError>;

    /// What a shader computes, if one can.
    fn real_time(&self) -> Option<&dyn RealTime> {
        None
    }

    /// As [`ShadowBound::has_upper`].
    fn has_upper(&self) -> bool;

    /// As [`ShadowBound::is_lower_bound`].
    fn is_lower_bound(&self) -> bool;
}

/// A bound as shaders compute it: in single precision, with a twin in WGSL, at a known number of operations.
pub trait RealTime: Send + Sync {
    /// As [`ShadowBound::shade`]. Moments are biased as much as single precision needs, unless the user has chosen a bias.
    fn shade_single(&self, b: &[f32], z_f: f32) -> f32;

    /// As [`ShadowBound::bounds`].
    fn bounds_single(&self, b: &[f32], z_f: f32) -> Pair<f32>;

    /// As [`ShadowBound::shader`].
    fn shader(&self) -> Option<String>;

    /// Operations of shading one fragment, in units of one addition; a division, root or elementary function counts as
    /// [`SPECIAL`](crate::SPECIAL).
    fn operations(&self, b: &[f32], z_f: f32) -> u64;
}

impl<B: ShadowBound> AnyBound for B {
    fn name(&self) -> String {
        ShadowBound::name(self)
    }

    fn shade_double(&self, b: &[f64], z_f: f64) -> Result<f64, FilteringError> {
        Ok(self.shade(b, unit(z_f)))
    }

    fn bounds_double(&self, b: &[f64], z_f: f64) -> Result<Pair<f64>, FilteringError> {
        Ok(self.bounds(b, unit(z_f)))
    }

    fn real_time(&self) -> Option<&dyn RealTime> {
        Some(self)
    }

    fn has_upper(&self) -> bool {
        ShadowBound::has_upper(self)
    }

    fn is_lower_bound(&self) -> bool {
        ShadowBound::is_lower_bound(self)
    }
}

impl<B: ShadowBound> RealTime for B {
    fn shade_single(&self, b: &[f32], z_f: f32) -> f32 {
        self.shade(b, unit(z_f))
    }

    fn bounds_single(&self, b: &[f32], z_f: f32) -> Pair<f32> {
        self.bounds(b, unit(z_f))
    }

    fn shader(&self) -> Option<String> {
        ShadowBound::shader(self)
    }

    fn operations(&self, b: &[f32], z_f: f32) -> u64 {
        let b: Vec<Counted> = b.iter().map(|&value| Counted(value)).collect();
        count(|| self.shade(&b, unit(Counted(z_f))))
    }
}
