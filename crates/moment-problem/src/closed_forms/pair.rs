//! What every closed form returns.

use crate::arithmetic::Real;

/// Sharp lower and upper bound, both in \[0, 1\] and never NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair<R> {
    /// Bound of the mass strictly before z_f.
    pub lower: R,
    /// Bound of the mass up to and including z_f.
    pub upper: R,
}

impl<R: Real> Pair<R> {
    /// Clamps to \[0, 1\] and orders the two; NaN becomes the trivial bound (0 below, 1 above).
    #[inline(always)]
    pub(crate) fn clamped(lower: R, upper: R) -> Self {
        let lower = lower.clamp_unit();
        Self { lower, upper: upper.min(R::one()).max(lower) }
    }

    /// BHS16 section 2.4: beta = 0 gives the lower bound, beta = 1 the upper.
    pub fn blend(self, beta: R) -> R {
        self.lower + beta * (self.upper - self.lower)
    }
}
