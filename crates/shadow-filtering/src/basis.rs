//! The first part of a technique: the functions b(z) of the depth that a texel stores.

use moment_problem::Basis;
use moment_problem::arithmetic::Real;

/// b(z), written once for all number types.
pub trait DepthBasis: Send + Sync {
    /// Number m of functions.
    fn channels(&self) -> usize;

    /// b(z) for z in \[0, 1\]; `out` has [`DepthBasis::channels`] values.
    fn evaluate<R: Real>(&self, z: R, out: &mut [R]);
}

/// A [`DepthBasis`] behind a pointer, in the precisions in use. Implemented for every [`DepthBasis`].
pub trait AnyBasis: Send + Sync {
    /// As [`DepthBasis::channels`].
    fn channels(&self) -> usize;

    /// As [`DepthBasis::evaluate`], as a shader computes it.
    fn evaluate_single(&self, z: f32, out: &mut [f32]);

    /// As [`DepthBasis::evaluate`].
    fn evaluate_double(&self, z: f64, out: &mut [f64]);
}

impl<B: DepthBasis> AnyBasis for B {
    fn channels(&self) -> usize {
        DepthBasis::channels(self)
    }

    fn evaluate_single(&self, z: f32, out: &mut [f32]) {
        self.evaluate(z, out);
    }

    fn evaluate_double(&self, z: f64, out: &mut [f64]) {
        self.evaluate(z, out);
    }
}

/// Powers of a variable that runs over an interval: z, or s = 2 z - 1, whose powers lose fewer digits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Powers {
    /// Number m of powers, from the first on.
    pub order: usize,
    /// Whether the variable is s.
    pub signed: bool,
}

impl DepthBasis for Powers {
    fn channels(&self) -> usize {
        self.order
    }

    fn evaluate<R: Real>(&self, z: R, out: &mut [R]) {
        let base = if self.signed { signed(z) } else { z };
        let mut power = R::one();
        for value in out {
            power = power * base;
            *value = power;
        }
    }
}

/// s = 2 z - 1.
pub(crate) fn signed<R: Real>(z: R) -> R {
    z + z - R::one()
}

impl DepthBasis for Basis {
    fn channels(&self) -> usize {
        self.len()
    }

    fn evaluate<R: Real>(&self, z: R, out: &mut [R]) {
        for (value, function) in out.iter_mut().zip(self.functions()) {
            *value = function.evaluate(z);
        }
    }
}
