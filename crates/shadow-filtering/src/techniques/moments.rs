//! Moment shadow maps with closed-form sharp bounds (MSM15 section 4, BHS16 sections 1.2 and 2.4).
//!
//! Hamburger 4, 6 and 8 store powers of s = 2 z - 1: their bounds are invariant under affine maps of depth (MSM15
//! section 4), and powers of s lose fewer digits. Hausdorff 4 stores z to z^4, trigonometric 4 sine and cosine of
//! 2 pi z and 4 pi z. The filtered moments b are replaced by (1 - alpha) b + alpha b* (MSM15 section 4.2), so that
//! G <= F + alpha. b* are the moments of the arcsine distribution (Hamburger, Hausdorff) and of the uniform one
//! (trigonometric), which lie deep inside the cone of moments; MSM15's b* on \[0, 1\] lies on its boundary.
//!
//! Without a bias of the user's choice, kernels of exactly two depths are solved without any (see `two_surfaces`).

use super::{Parts, two_surfaces};
use crate::basis::{DepthBasis, Powers, signed};
use crate::bound::ShadowBound;
use crate::error::FilteringError;
use crate::spec::{Range, TechniqueSpec};
use crate::wgsl;
use moment_problem::MomentBound;
use moment_problem::arithmetic::Real;
use moment_problem::hamburger::Pair;

/// The sharp bounds of biased moments, blended.
#[derive(Clone, Copy, Debug)]
pub struct BiasedMoments {
    bound: MomentBound,
    range: Range,
    alpha: f64,
    /// The same for a shader.
    single_alpha: f64,
    /// b*, the first [`MomentBound::order`] entries.
    centre: [f64; MomentBound::MAX_ORDER],
    beta: f64,
    /// Whether two depths are recognised: not with a bias that stands for the storage of a real shadow map.
    recognises_two: bool,
}

impl BiasedMoments {
    /// The bound with `alpha`, `beta`, `centre` and `range` of a technique.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] for alpha or beta outside \[0, 1\], a b* of another order, and a range that the
    /// bound does not work on.
    pub(crate) fn new(bound: MomentBound, spec: &TechniqueSpec) -> Result<Self, FilteringError> {
        let alpha = spec.alpha.unwrap_or(bound.double_precision_bias());
        for (key, value) in [("alpha", alpha), ("beta", spec.beta)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(FilteringError::parameter(key, value, "must lie in [0, 1]"));
            }
        }
        let range = spec.range.unwrap_or_else(|| Range::of(bound));
        if range == Range::Signed && Range::of(bound) == Range::Unit {
            let reason = format!("{} needs depths from 0 to 1", bound.name());
            return Err(FilteringError::parameter("range", range.name(), reason));
        }
        let mut centre = [0.0; MomentBound::MAX_ORDER];
        centre[..bound.order()].copy_from_slice(usual_centre(bound, range));
        if let Some(given) = &spec.centre {
            if given.len() != bound.order() || given.iter().any(|value| !value.is_finite()) {
                let reason = format!("are not the {} numbers of b*", bound.order());
                return Err(FilteringError::parameter("centre", format!("{given:?}"), reason));
            }
            centre[..given.len()].copy_from_slice(given);
        }
        let single_alpha = spec.alpha.unwrap_or(bound.single_precision_bias());
        let recognises_two = spec.alpha.is_none() && bound != MomentBound::Hamburger2;
        Ok(Self { bound, range, alpha, single_alpha, centre, beta: spec.beta, recognises_two })
    }

    /// The same bound under another bias, without recognition of two depths. `centre` has one entry a moment.
    pub fn with_bias(mut self, alpha: f64, centre: &[f64]) -> Self {
        self.centre[..centre.len()].copy_from_slice(centre);
        Self { alpha, single_alpha: alpha, recognises_two: false, ..self }
    }

    /// b*, one entry a moment.
    pub fn centre(&self) -> &[f64] {
        &self.centre[..self.bound.order()]
    }

    /// The bounded moments.
    pub fn bound(&self) -> MomentBound {
        self.bound
    }

    /// The moments that the bound is computed from: biased, as exact input for another solver.
    pub fn biased(&self, filtered: &[f64]) -> Vec<f64> {
        self.biased_in(filtered)[..filtered.len()].to_vec()
    }

    /// (1 - alpha) b + alpha b* with the bias that the number type needs.
    fn biased_in<R: Real>(&self, filtered: &[R]) -> [R; MomentBound::MAX_ORDER] {
        let alpha = if is_double::<R>() { self.alpha } else { self.single_alpha };
        let (keep, share) = (R::from_f64(1.0 - alpha), R::from_f64(alpha));
        let mut biased = self.centre.map(R::from_f64);
        for (c, &b) in biased.iter_mut().zip(filtered) {
            *c = keep * b + share * *c;
        }
        biased
    }

    /// The variable whose functions are stored: z or s = 2 z - 1.
    fn variable<R: Real>(&self, z: R) -> R {
        match self.range {
            Range::Unit => z,
            Range::Signed => signed(z),
        }
    }

    /// The mass before z_f of moments of one or two depths, in double precision.
    fn lower_of_two<R: Real>(&self, b: &[R], z_f: R) -> Option<f64> {
        if !(self.recognises_two && is_double::<R>()) {
            return None;
        }
        let four = std::array::from_fn(|k| b[k].to_f64());
        if self.bound.is_trigonometric() {
            two_surfaces::trigonometric(four, z_f.to_f64())
        } else {
            two_surfaces::powers(four, self.variable(z_f).to_f64())
        }
    }
}

/// Moments of the arcsine distribution on \[0, 1\].
const ARCSINE_UNIT: [f64; MomentBound::MAX_ORDER] =
    [0.5, 0.375, 0.3125, 0.2734375, 0.24609375, 0.2255859375, 0.20947265625, 0.196380615234375];

/// b* in the variable that is stored.
fn usual_centre(bound: MomentBound, range: Range) -> &'static [f64] {
    if range == Range::of(bound) { bound.centre() } else { &ARCSINE_UNIT[..bound.order()] }
}

/// A shader recognises nothing, and needs a larger bias.
fn is_double<R: Real>() -> bool {
    R::EPSILON < 1e-10
}

impl ShadowBound for BiasedMoments {
    fn name(&self) -> String {
        let name = self.bound.name();
        if self.beta == 0.0 { name.to_owned() } else { format!("{name}, beta = {}", self.beta) }
    }

    /// lower + beta (upper - lower): beta = 0 is the sharp lower bound, 1 the upper (BHS16 section 2.4).
    fn shade<R: Real>(&self, b: &[R], z_f: R) -> R {
        let mut bounds = self.bounds(b, z_f);
        if let Some(lower) = self.lower_of_two(b, z_f) {
            // The larger one is the better bound, unless bias and rounding explain that it is larger.
            let explained = self.alpha + two_surfaces::UNCERTAIN_MASS;
            if bounds.lower <= R::from_f64(lower + explained) {
                bounds.lower = R::from_f64(lower);
            }
            bounds.upper = bounds.upper.max(bounds.lower);
        }
        bounds.blend(R::from_f64(self.beta))
    }

    fn bounds<R: Real>(&self, b: &[R], z_f: R) -> Pair<R> {
        let z_f = self.variable(z_f);
        if is_double::<R>() {
            self.bound.bounds(&self.biased_in(b), z_f)
        } else {
            self.bound.biased_bounds(b, self.single_alpha, &self.centre, z_f)
        }
    }

    fn has_upper(&self) -> bool {
        true
    }

    fn is_lower_bound(&self) -> bool {
        self.beta == 0.0
    }

    fn shader(&self) -> Option<String> {
        let centre = &self.centre[..self.bound.order()];
        wgsl::moments(self.bound, self.range == Range::Signed, self.single_alpha, centre, self.beta)
    }
}

/// In the usual variable.
impl DepthBasis for MomentBound {
    fn channels(&self) -> usize {
        self.order()
    }

    fn evaluate<R: Real>(&self, z: R, out: &mut [R]) {
        MomentBound::evaluate(*self, z, out);
    }
}

/// `alpha`, `beta`, `centre` and `range`, none of which has to be given.
pub(crate) fn parts(bound: MomentBound, spec: &TechniqueSpec) -> Result<Parts, FilteringError> {
    let biased = BiasedMoments::new(bound, spec)?;
    if biased.range == Range::of(bound) {
        return Ok(Parts::new(bound, biased));
    }
    Ok(Parts::new(Powers { order: bound.order(), signed: biased.range == Range::Signed }, biased))
}
