//! Moment shadow maps with closed-form sharp bounds (MSM15 section 4, BHS16 sections 1.2 and 2.4).
//!
//! Hamburger 4, 6 and 8 store powers of s = 2 z - 1: their bounds are invariant under affine maps of depth (MSM15
//! section 4), and powers of s lose fewer digits. Hausdorff 4 stores z to z^4, trigonometric 4 sine and cosine of
//! 2 pi z and 4 pi z. The filtered moments b are replaced by (1 - alpha) b + alpha b* (MSM15 section 4.2), so that
//! G <= F + alpha. b* are the moments of the arcsine distribution (Hamburger, Hausdorff) and of the uniform one
//! (trigonometric), which lie deep inside the cone of moments; MSM15's b* on \[0, 1\] lies on its boundary.
//!
//! Without a bias of the user's choice, kernels of exactly two depths are solved without any (see `two_surfaces`).

use super::two_surfaces;
use crate::error::FilteringError;
use crate::real_time::{RealTime, in_real_time};
use crate::spec::MomentOptions;
use crate::technique::{Technique, unit};
use moment_problem::MomentBound;
use moment_problem::arithmetic::Real;
use moment_problem::hamburger::Pair;

/// A moment shadow map.
#[derive(Clone, Copy, Debug)]
pub struct Moments {
    bound: MomentBound,
    alpha: f64,
    /// The same for a shader.
    single_alpha: f64,
    beta: f64,
    /// Whether two depths are recognised: not with a bias that stands for the storage of a real shadow map.
    recognises_two: bool,
}

impl Moments {
    /// `options` choose the bias and the blend of bounds.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] for alpha or beta outside \[0, 1\].
    pub fn new(bound: MomentBound, options: MomentOptions) -> Result<Self, FilteringError> {
        let alpha = options.alpha.unwrap_or(bound.double_precision_bias());
        for (key, value) in [("alpha", alpha), ("beta", options.beta)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(FilteringError::parameter(key, value, "must lie in [0, 1]"));
            }
        }
        let single_alpha = options.alpha.unwrap_or(bound.single_precision_bias());
        Ok(Self { bound, alpha, single_alpha, beta: options.beta, recognises_two: options.alpha.is_none() })
    }

    /// The moments that the bound is computed from: biased, as exact input for another solver.
    pub fn biased(&self, filtered: &[f64]) -> Vec<f64> {
        self.towards_centre(filtered, self.alpha)[..self.bound.order()].to_vec()
    }

    /// The bound with both ends.
    pub fn bounds(&self, filtered: &[f64], z_f: f64) -> Pair<f64> {
        self.bound.bounds(&self.towards_centre(filtered, self.alpha), self.bound.variable(unit(z_f)))
    }

    fn encode_in<R: Real>(&self, depth: R, out: &mut [R]) {
        self.bound.evaluate(unit(depth), out);
    }

    /// G as a shader computes it: biased, without the recognition of two depths, which needs double precision.
    fn shade_in<R: Real>(&self, filtered: &[R], z_f: R) -> R {
        self.biased_bounds(filtered, z_f).blend(R::from_f64(self.beta))
    }

    fn biased_bounds<R: Real>(&self, filtered: &[R], z_f: R) -> Pair<R> {
        self.bound.biased_bounds(filtered, self.single_alpha, self.bound.variable(unit(z_f)))
    }

    fn lower_of_two(&self, filtered: &[f64], z_f: f64) -> Option<f64> {
        if !self.recognises_two || self.bound == MomentBound::Hamburger2 {
            return None;
        }
        let four = [filtered[0], filtered[1], filtered[2], filtered[3]];
        let variable = self.bound.variable(z_f);
        if self.bound.is_trigonometric() {
            two_surfaces::trigonometric(four, variable)
        } else {
            two_surfaces::powers(four, variable)
        }
    }

    /// (1 - alpha) b + alpha b*, without an allocation.
    fn towards_centre<R: Real>(&self, filtered: &[R], alpha: f64) -> [R; MomentBound::MAX_ORDER] {
        let (keep, alpha) = (R::from_f64(1.0 - alpha), R::from_f64(alpha));
        let mut biased = [R::zero(); MomentBound::MAX_ORDER];
        for ((value, &b), &centre) in biased.iter_mut().zip(filtered).zip(self.bound.centre()) {
            *value = keep * b + alpha * R::from_f64(centre);
        }
        biased
    }
}

in_real_time!(
    Moments,
    |technique| shaders::moments(technique.bound, technique.single_alpha, technique.beta),
    fn bounds_single(&self, filtered: &[f32], z_f: f32) -> [f32; 2] {
        let Pair { lower, upper } = self.biased_bounds(filtered, z_f);
        [lower, upper]
    }
);

impl Technique for Moments {
    fn name(&self) -> String {
        let name = self.bound.name();
        if self.beta == 0.0 { name.to_owned() } else { format!("{name}, beta = {}", self.beta) }
    }

    fn channels(&self) -> usize {
        self.bound.order()
    }

    fn encode(&self, depth: f64, out: &mut [f64]) {
        self.encode_in(depth, out);
    }

    /// lower + beta (upper - lower): beta = 0 is the sharp lower bound, 1 the upper (BHS16 section 2.4).
    fn shade(&self, filtered: &[f64], z_f: f64) -> Result<f64, FilteringError> {
        let mut bounds = self.bounds(filtered, z_f);
        if let Some(lower) = self.lower_of_two(filtered, unit(z_f)) {
            // The larger one is the better bound, unless bias and rounding explain that it is larger.
            let explained = self.alpha + two_surfaces::UNCERTAIN_MASS;
            bounds.lower = if bounds.lower > lower + explained { bounds.lower } else { lower };
            bounds.upper = bounds.upper.max(bounds.lower);
        }
        Ok(bounds.blend(self.beta))
    }

    fn is_lower_bound(&self) -> bool {
        self.beta == 0.0
    }

    fn real_time(&self) -> Option<&dyn RealTime> {
        Some(self)
    }
}
