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
use moment_problem::Basis;
use moment_problem::arithmetic::{DoubleDouble, Real};
use moment_problem::hamburger::{Pair, hamburger, hamburger4};
use moment_problem::hausdorff::hausdorff4;
use moment_problem::trigonometric::trigonometric4;
use serde::{Deserialize, Serialize};

/// Which moments and which prior knowledge of depth; in TOML by its name in lower case, such as `hamburger4`.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum MomentBound {
    /// Mean and second moment on the line: Cantelli's inequality, as for variance shadow maps.
    Hamburger2,
    /// Four power moments on the line.
    Hamburger4,
    /// Six.
    Hamburger6,
    /// Eight.
    Hamburger8,
    /// Four power moments on \[0, 1\].
    Hausdorff4,
    /// Sine and cosine of 2 pi z and 4 pi z on \[0, 1\].
    Trigonometric4,
}

impl MomentBound {
    /// Number of moments.
    pub fn order(self) -> usize {
        match self {
            Self::Hamburger2 => 2,
            Self::Hamburger4 | Self::Hausdorff4 | Self::Trigonometric4 => 4,
            Self::Hamburger6 => 6,
            Self::Hamburger8 => 8,
        }
    }

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hamburger2 => "Hamburger 2",
            Self::Hamburger4 => "Hamburger 4",
            Self::Hamburger6 => "Hamburger 6",
            Self::Hamburger8 => "Hamburger 8",
            Self::Hausdorff4 => "Hausdorff 4",
            Self::Trigonometric4 => "Trigonometric 4",
        }
    }

    /// Bias that double precision needs. A kernel of one or two depths lies on the boundary of the cone of moments,
    /// where rounding, some 1e-16, is amplified by 1 / alpha; the bias itself adds alpha to G at most. The values keep
    /// both far below what matters.
    pub fn double_precision_bias(self) -> f64 {
        match self {
            Self::Hamburger2 | Self::Hamburger4 | Self::Hamburger6 => 1e-9,
            Self::Hausdorff4 | Self::Trigonometric4 => 1e-9,
            Self::Hamburger8 => 1e-8,
        }
    }

    /// Bias that moments stored in single precision need: the least at which the bound held on hard inputs of
    /// `experiments/stability.toml`, or for the two bounds on \[0, 1\] all but held.
    pub fn single_precision_bias(self) -> f64 {
        match self {
            Self::Hamburger2 | Self::Hamburger4 => 5e-7,
            Self::Hamburger6 => 5e-6,
            Self::Hamburger8 => 5e-5,
            Self::Hausdorff4 | Self::Trigonometric4 => 1e-5,
        }
    }

    /// The basis whose moments are bounded.
    pub fn basis(self) -> Basis {
        match self {
            Self::Trigonometric4 => Basis::trigonometric(2),
            _ => Basis::power(self.order()),
        }
    }

    /// The bound of the first [`MomentBound::order`] moments at a depth in the moments' own variable: any affine map
    /// of depth for the Hamburger bounds, depth in \[0, 1\] for the others.
    ///
    /// # Panics
    /// For fewer moments.
    pub fn bounds<R: Real>(self, moments: &[R], z_f: R) -> Pair<R> {
        match self {
            Self::Hamburger2 => hamburger(&leading::<R, 2>(moments), z_f),
            Self::Hamburger4 => hamburger4(&leading(moments), z_f),
            Self::Hamburger6 => hamburger(&leading::<R, 6>(moments), z_f),
            Self::Hamburger8 => hamburger(&leading::<R, 8>(moments), z_f),
            Self::Hausdorff4 => hausdorff4(&leading(moments), z_f),
            Self::Trigonometric4 => trigonometric4(&leading(moments), z_f),
        }
    }

    /// b*, the first [`MomentBound::order`] entries.
    pub(crate) fn centre(self) -> [f64; 8] {
        match self {
            Self::Hamburger2 | Self::Hamburger4 | Self::Hamburger6 | Self::Hamburger8 => {
                [0.0, 0.5, 0.0, 0.375, 0.0, 0.3125, 0.0, 0.2734375]
            }
            Self::Hausdorff4 => [0.5, 0.375, 0.3125, 0.2734375, 0.0, 0.0, 0.0, 0.0],
            Self::Trigonometric4 => [0.0; 8],
        }
    }
}

fn leading<R: Real, const M: usize>(moments: &[R]) -> [R; M] {
    std::array::from_fn(|k| moments[k])
}

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
        let centre = self.bound.centre();
        filtered.iter().zip(centre).map(|(&b, c)| (1.0 - self.alpha) * b + self.alpha * c).collect()
    }

    /// The bound with both ends.
    pub fn bounds(&self, filtered: &[f64], z_f: f64) -> Pair<f64> {
        self.bound.bounds(&self.array(filtered), self.variable(unit(z_f)))
    }

    fn encode_in<R: Real>(&self, depth: R, out: &mut [R]) {
        let z = unit(depth);
        if self.bound == MomentBound::Trigonometric4 {
            let angle = R::from_double_double(DoubleDouble::pi()) * (z + z);
            let (sine, cosine) = (angle.sin(), angle.cos());
            let product = sine * cosine;
            out.copy_from_slice(&[sine, cosine, product + product, (cosine - sine) * (cosine + sine)]);
            return;
        }
        let base = self.variable(z);
        let mut power = R::one();
        for value in out {
            power = power * base;
            *value = power;
        }
    }

    /// The variable whose functions are stored: z or s = 2 z - 1.
    fn variable<R: Real>(&self, z: R) -> R {
        match self.bound {
            MomentBound::Hausdorff4 | MomentBound::Trigonometric4 => z,
            _ => z + z - R::one(),
        }
    }

    /// G as a shader computes it: biased, without the recognition of two depths, which needs double precision.
    fn shade_in<R: Real>(&self, filtered: &[R], z_f: R) -> R {
        self.biased_bounds(filtered, z_f).blend(R::from_f64(self.beta))
    }

    fn biased_bounds<R: Real>(&self, filtered: &[R], z_f: R) -> Pair<R> {
        let alpha = R::from_f64(self.single_alpha);
        let keep = R::from_f64(1.0 - self.single_alpha);
        let mut biased = self.bound.centre().map(R::from_f64);
        for (c, &b) in biased.iter_mut().zip(filtered) {
            *c = keep * b + alpha * *c;
        }
        self.bound.bounds(&biased, self.variable(unit(z_f)))
    }

    fn lower_of_two(&self, filtered: &[f64], z_f: f64) -> Option<f64> {
        if !self.recognises_two || self.bound == MomentBound::Hamburger2 {
            return None;
        }
        let four = [filtered[0], filtered[1], filtered[2], filtered[3]];
        match self.bound {
            MomentBound::Hausdorff4 => two_surfaces::powers(four, z_f),
            MomentBound::Trigonometric4 => two_surfaces::trigonometric(four, z_f),
            _ => two_surfaces::powers(four, 2.0 * z_f - 1.0),
        }
    }

    /// (1 - alpha) b + alpha b*, without an allocation.
    fn array(&self, filtered: &[f64]) -> [f64; 8] {
        let mut biased = self.bound.centre();
        for (c, &b) in biased.iter_mut().zip(filtered) {
            *c = (1.0 - self.alpha) * b + self.alpha * *c;
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
