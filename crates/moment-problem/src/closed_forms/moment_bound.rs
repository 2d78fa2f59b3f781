//! The closed forms that shadow maps use, as one type that answers for itself.

use super::hamburger::{Pair, hamburger, hamburger4};
use super::hausdorff::{hausdorff4, hausdorff4_biased};
use super::in_front::{self, InFront};
use super::textbook;
use super::trigonometric::trigonometric4;
use crate::arithmetic::{DoubleDouble, Real};
use crate::basis::Basis;
use crate::certified::Interval;
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

/// What distinguishes the bounds, stated once.
struct Facts {
    name: &'static str,
    order: usize,
    basis: &'static str,
    interval: Interval,
    double_bias: f64,
    single_bias: f64,
    centre: &'static [f64],
}

/// Moments of the arcsine distribution on \[-1, 1\].
const ARCSINE_SIGNED: [f64; 8] = [0.0, 0.5, 0.0, 0.375, 0.0, 0.3125, 0.0, 0.2734375];

/// Moments of the arcsine distribution on \[0, 1\].
const ARCSINE_UNIT: [f64; 4] = [0.5, 0.375, 0.3125, 0.2734375];

impl MomentBound {
    /// Most moments of any of them.
    pub const MAX_ORDER: usize = 8;

    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Hamburger2,
        Self::Hamburger4,
        Self::Hamburger6,
        Self::Hamburger8,
        Self::Hausdorff4,
        Self::Trigonometric4,
    ];

    #[inline]
    fn facts(self) -> Facts {
        let line = |name, order, basis, double_bias, single_bias| {
            let centre = &ARCSINE_SIGNED[..order];
            Facts { name, order, basis, interval: Interval::Real, double_bias, single_bias, centre }
        };
        let unit = |name, basis, single_bias, centre| Facts {
            name,
            order: 4,
            basis,
            interval: Interval::Unit,
            double_bias: 1e-9,
            single_bias,
            centre,
        };
        match self {
            Self::Hamburger2 => line("Hamburger 2", 2, "power:2", 1e-9, 2e-7),
            Self::Hamburger4 => line("Hamburger 4", 4, "power:4", 1e-9, 1e-6),
            Self::Hamburger6 => line("Hamburger 6", 6, "power:6", 1e-9, 5e-6),
            Self::Hamburger8 => line("Hamburger 8", 8, "power:8", 1e-8, 3e-5),
            Self::Hausdorff4 => unit("Hausdorff 4", "power:4", 1e-4, &ARCSINE_UNIT),
            Self::Trigonometric4 => unit("Trigonometric 4", "trig:2", 2e-3, &[0.0; 4]),
        }
    }

    /// Name in tables.
    pub fn name(self) -> &'static str {
        self.facts().name
    }

    /// Number m of moments.
    pub fn order(self) -> usize {
        self.facts().order
    }

    /// The basis whose moments are bounded.
    pub fn basis(self) -> Basis {
        if self.is_trigonometric() { Basis::trigonometric(2) } else { Basis::power(self.order()) }
    }

    /// The basis as it is spelled in TOML and on the command line.
    pub fn basis_name(self) -> &'static str {
        self.facts().basis
    }

    /// The admissible values of the variable. A bound on the line is invariant under affine maps of depth (MSM15
    /// section 4); one on \[0, 1\] needs depths from 0 to 1.
    pub fn interval(self) -> Interval {
        self.facts().interval
    }

    /// Whether the moments are those of sines and cosines instead of powers.
    pub fn is_trigonometric(self) -> bool {
        self == Self::Trigonometric4
    }

    /// Distributions of so many depths are determined by their moments (MSM15 Proposition 4).
    pub fn determined_depths(self) -> usize {
        self.order() / 2
    }

    /// Bias that double precision needs. A kernel of one or two depths lies on the boundary of the cone of moments,
    /// where rounding, some 1e-16, is amplified by 1 / alpha; the bias itself adds alpha to G at most. The values keep
    /// both far below what matters.
    pub fn double_precision_bias(self) -> f64 {
        self.facts().double_bias
    }

    /// Bias that moments stored in single precision need: the least of 1, 2, 3, 5 and 10 times a power of ten at which no
    /// bound broke on ten million kernels of one to three surfaces with and without the far plane, z_f at and next to a
    /// surface (the first of them in the tests of `shadow-filtering`).
    pub fn single_precision_bias(self) -> f64 {
        self.facts().single_bias
    }

    /// b*, towards which biased moments move: those of the arcsine distribution, or of the uniform one for sines and
    /// cosines, which lie deep inside the cone of moments.
    pub fn centre(self) -> &'static [f64] {
        self.facts().centre
    }

    /// The variable whose functions are best stored, at a depth in \[0, 1\]: s = 2 z - 1 where the bound allows it, since
    /// powers of s lose fewer digits, else z.
    pub fn variable<R: Real>(self, depth: R) -> R {
        match self.interval() {
            Interval::Real => depth + depth - R::one(),
            Interval::Unit => depth,
        }
    }

    /// b at a depth in \[0, 1\], as functions of [`MomentBound::variable`]; `out` holds [`MomentBound::order`] values.
    pub fn evaluate<R: Real>(self, depth: R, out: &mut [R]) {
        let x = self.variable(depth);
        if self.is_trigonometric() {
            let angle = R::from_double_double(DoubleDouble::pi()) * (x + x);
            let (sine, cosine) = (angle.sin(), angle.cos());
            let product = sine * cosine;
            out.copy_from_slice(&[sine, cosine, product + product, (cosine - sine) * (cosine + sine)]);
            return;
        }
        let mut power = R::one();
        for value in out {
            power = power * x;
            *value = power;
        }
    }

    /// The bound of the first [`MomentBound::order`] moments at a depth in the moments' own variable: any affine map
    /// of depth for the bounds on the line, depth in \[0, 1\] for the others.
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

    /// The points in front of z_f of the distribution that attains the lower bound, in the moments' own variable; `None`
    /// for sines and cosines, whose distribution is not computed.
    ///
    /// # Panics
    /// For fewer moments.
    pub fn in_front<R: Real>(self, moments: &[R], z_f: R) -> Option<InFront<R>> {
        Some(match self {
            Self::Hamburger2 => in_front::chebyshev(&leading(moments), z_f),
            Self::Hamburger4 => in_front::hamburger(&leading::<R, 4>(moments), z_f),
            Self::Hamburger6 => in_front::hamburger(&leading::<R, 6>(moments), z_f),
            Self::Hamburger8 => in_front::hamburger(&leading::<R, 8>(moments), z_f),
            Self::Hausdorff4 => in_front::hausdorff4(&leading(moments), z_f),
            Self::Trigonometric4 => return None,
        })
    }

    /// The bound of (1 - alpha) b + alpha c, in the way that loses least in single precision; `centre` is c, such as
    /// [`MomentBound::centre`].
    ///
    /// # Panics
    /// For fewer moments.
    pub fn biased_bounds<R: Real>(self, moments: &[R], alpha: f64, centre: &[f64], z_f: R) -> Pair<R> {
        let (keep, alpha) = (R::from_f64(1.0 - alpha), R::from_f64(alpha));
        if self == Self::Hausdorff4 {
            let centre = std::array::from_fn(|k| R::from_f64(centre[k]));
            return hausdorff4_biased(&leading(moments), &centre, alpha, z_f);
        }
        let mut biased = [R::zero(); Self::MAX_ORDER];
        for ((value, &b), &c) in biased.iter_mut().zip(moments).zip(centre) {
            *value = keep * b + alpha * R::from_f64(c);
        }
        self.bounds(&biased, z_f)
    }

    /// The lower bound as the papers compute it, where they print an algorithm; `None` also where it fails.
    ///
    /// # Panics
    /// For fewer moments.
    pub fn textbook<R: Real>(self, moments: &[R], z_f: R) -> Option<R> {
        match self {
            Self::Hamburger2 => textbook::hamburger(&leading::<R, 2>(moments), z_f),
            Self::Hamburger4 => textbook::hamburger4(&leading(moments), z_f),
            Self::Hamburger6 => textbook::hamburger(&leading::<R, 6>(moments), z_f),
            Self::Hamburger8 => textbook::hamburger(&leading::<R, 8>(moments), z_f),
            Self::Hausdorff4 => textbook::hausdorff4(&leading(moments), z_f),
            Self::Trigonometric4 => None,
        }
    }

    /// Parts of a shader, in order: `encode(depth)`, an array of [`MomentBound::order`] values, and `biased_bounds(b,
    /// z_f)`, lower and upper bound of (1 - alpha) b + alpha b* at a depth in \[0, 1\]. Before them stand `const CHANNELS: u32`,
    /// the order, `const SIGNED: bool`, whether [`MomentBound::variable`] is 2 z - 1, `const ALPHA: f32`, `const KEEP: f32`,
    /// 1 - alpha, and `const CENTRE`, b*. `None` for eight moments, which have no
    /// shader.
    pub fn wgsl(self) -> Option<&'static [&'static str]> {
        use super::wgsl::*;
        Some(match self {
            Self::Hamburger2 => &[ELEMENTARY, CHEBYSHEV, POWERS, HAMBURGER_2, BIAS],
            Self::Hamburger4 => {
                &[ELEMENTARY, ROOTS, CHEBYSHEV, POWERS, HAMBURGER_4, HAMBURGER_4_BOUNDS, BIAS]
            }
            Self::Hamburger6 => &[ELEMENTARY, ROOTS, CHEBYSHEV, POWERS, HAMBURGER_6, BIAS],
            Self::Hamburger8 => return None,
            Self::Hausdorff4 => &[ELEMENTARY, ROOTS, CHEBYSHEV, POWERS, HAMBURGER_4, HAUSDORFF_4],
            Self::Trigonometric4 => &[ELEMENTARY, ROOTS, CHEBYSHEV, TRIGONOMETRIC_4, BIAS],
        })
    }

    /// Parts that follow those of [`MomentBound::wgsl`]: `in_front(b, z_f) -> InFront`, depths and weights of
    /// [`MomentBound::in_front`] from biased moments, as values of [`MomentBound::variable`].
    pub fn wgsl_in_front(self) -> Option<&'static [&'static str]> {
        use super::wgsl::*;
        Some(match self {
            Self::Hamburger2 => &[IN_FRONT, IN_FRONT_2],
            Self::Hamburger4 => &[IN_FRONT, IN_FRONT_4, IN_FRONT_HAMBURGER_4],
            Self::Hamburger6 => &[IN_FRONT, IN_FRONT_6],
            Self::Hausdorff4 => &[IN_FRONT, IN_FRONT_4, IN_FRONT_HAUSDORFF_4],
            Self::Hamburger8 | Self::Trigonometric4 => return None,
        })
    }
}

fn leading<R: Real, const M: usize>(moments: &[R]) -> [R; M] {
    std::array::from_fn(|k| moments[k])
}
