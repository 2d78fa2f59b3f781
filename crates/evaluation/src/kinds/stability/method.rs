//! One way to compute a bound, applied to the moments of an input.

use super::input::{Input, Moments};
use super::settings::{Arithmetic, Route, StabilityMethod};
use crate::error::EvaluationError;
use crate::experiment::keys::in_key;
use moment_problem::MomentBound;
use moment_problem::arithmetic::{DoubleDouble, FloatFloat, Half, Real};
use moment_problem::hamburger::Pair;
use quantization::{Encoding, NumberFormat};
use shadow_filtering::Range;

/// Most moments.
pub(crate) const MAX_MOMENTS: usize = 8;

/// Moments in the variable of a method, the first ones of eight.
pub(crate) type Vector<R> = [R; MAX_MOMENTS];

/// A method with its storage resolved.
pub(crate) struct Prepared {
    pub(crate) bound: MomentBound,
    pub(crate) route: Route,
    pub(crate) arithmetic: Arithmetic,
    pub(crate) signed: bool,
    encoding: Option<Encoding>,
    pub(crate) target: Vector<f64>,
    pub(crate) alpha: f64,
}

/// What a method starts from.
#[derive(Clone, Copy)]
pub(crate) enum Start<'a> {
    /// Exact moments, to be rounded to the arithmetic.
    Exact(&'a Vector<DoubleDouble>),
    /// Moments in double precision.
    Plain(&'a Vector<f64>),
    /// Stored numbers.
    Stored(&'a Vector<f64>),
}

/// What a method makes of an input.
pub(crate) struct Answer {
    /// The lower bound before any clamping, if it is a number.
    pub(crate) lower: Option<f64>,
    /// The upper bound, where the route has one.
    pub(crate) upper: Option<f64>,
}

impl Prepared {
    /// Resolves a method; `place` is its key in the file.
    pub(crate) fn new(setting: &StabilityMethod, place: &str) -> Result<Self, EvaluationError> {
        let StabilityMethod { ref method, route, arithmetic, .. } = *setting;
        let fail = |key: &str, reason: &str| {
            let key = format!("{place}.{key}");
            Err(EvaluationError::Key { reason: format!("{key}: {reason}"), key })
        };
        let resolved = method
            .check_storage(&["alpha", "transform", "format"])
            .and_then(|()| Ok((method.build()?, method.stored_range()?)));
        let (technique, range) = resolved.map_err(in_key(&format!("{place}.method")))?;
        let Some(bound) = method.moment_bound() else {
            return fail("method.bound", "is no bound of moments");
        };
        let (Some(alpha), Some(centre)) = (method.alpha, &method.centre) else {
            return fail("method", "alpha and centre have to be given");
        };
        if alpha >= 1.0 {
            return fail("method.alpha", &format!("{alpha} is not in [0, 1)"));
        }
        if route == Route::Textbook && bound == MomentBound::Trigonometric4 {
            return fail("route", "the algorithm of trigonometric moments is not published in full");
        }
        if let NumberFormat::U32Fixed { .. } = method.format() {
            return fail("method.format", &format!("{} belongs to sums, not texels", method.format()));
        }
        let is_stored = method.format.is_some() || method.transform.is_some();
        let mut target = [0.0; MAX_MOMENTS];
        target[..centre.len()].copy_from_slice(centre);
        let encoding = is_stored.then(|| technique.encoding().clone());
        Ok(Self { bound, route, arithmetic, signed: range == Range::Signed, encoding, target, alpha })
    }

    /// Whether two methods have the same exact bound at the same alpha.
    pub(crate) fn same_problem(&self, other: &Self) -> bool {
        (self.bound, self.signed, self.target) == (other.bound, other.signed, other.target)
    }

    /// The moments in the method's variable.
    pub(crate) fn moments<'a, R>(&self, moments: &'a Moments<R>) -> &'a Vector<R> {
        match (self.bound.is_trigonometric(), self.signed) {
            (true, _) => &moments.waves,
            (false, true) => &moments.signed,
            (false, false) => &moments.unit,
        }
    }

    /// z_f in the method's variable.
    pub(crate) fn depth(&self, input: &Input) -> f64 {
        if self.signed { 2.0 * input.z_f - 1.0 } else { input.z_f }
    }

    /// What is stored of the moments, as numbers; without storage there is nothing to be done.
    pub(crate) fn stored(&self, moments: &Vector<DoubleDouble>) -> Option<Vector<f64>> {
        let encoding = self.encoding.as_ref()?;
        let order = self.bound.order();
        let b = moments.map(Real::to_f64);
        let mut stored = [0.0; MAX_MOMENTS];
        encoding.transform().apply(&b[..order], &mut stored[..order]);
        stored.iter_mut().for_each(|value| *value = encoding.format().round(*value));
        Some(stored)
    }

    /// Decodes, biases and bounds in the method's arithmetic.
    pub(crate) fn answer(&self, start: Start<'_>, z_f: f64, alpha: f64) -> Answer {
        match self.arithmetic {
            Arithmetic::F16 => self.compute::<Half>(start, z_f, alpha),
            Arithmetic::F32 => self.compute::<f32>(start, z_f, alpha),
            Arithmetic::F64 => self.compute::<f64>(start, z_f, alpha),
            Arithmetic::Pairs => self.compute::<FloatFloat>(start, z_f, alpha),
        }
    }

    fn compute<R: Real>(&self, start: Start<'_>, z_f: f64, alpha: f64) -> Answer {
        let b: Vector<R> = match start {
            Start::Exact(moments) => moments.map(R::from_double_double),
            Start::Plain(moments) => moments.map(R::from_f64),
            Start::Stored(stored) => self.decoded(stored),
        };
        self.bounded(&self.biased(&b, alpha), R::from_f64(z_f))
    }

    /// Undoes the transform in the arithmetic of the method.
    fn decoded<R: Real>(&self, stored: &Vector<f64>) -> Vector<R> {
        let mut b = [R::zero(); MAX_MOMENTS];
        if let Some(encoding) = &self.encoding {
            let transform = encoding.transform();
            for (value, row) in b.iter_mut().zip(transform.inverse().chunks_exact(transform.order())) {
                let terms = row.iter().zip(stored).zip(transform.offset());
                *value = terms.fold(R::zero(), |sum, ((&m, &s), &o)| {
                    sum + R::from_f64(m) * (R::from_f64(s) - R::from_f64(o))
                });
            }
        }
        b
    }

    fn biased<R: Real>(&self, b: &Vector<R>, alpha: f64) -> Vector<R> {
        let alpha = R::from_f64(alpha);
        std::array::from_fn(|k| b[k] + alpha * (R::from_f64(self.target[k]) - b[k]))
    }

    /// The bound of biased moments.
    fn bounded<R: Real>(&self, b: &Vector<R>, z_f: R) -> Answer {
        match self.route {
            Route::Textbook => Answer { lower: self.bound.textbook(b, z_f).map(Real::to_f64), upper: None },
            Route::Ours => {
                let Pair { lower, upper } = self.bound.bounds(b, z_f);
                let number = |value: R| Some(value.to_f64()).filter(|value| value.is_finite());
                Answer { lower: number(lower), upper: number(upper) }
            }
        }
    }

    /// The exact bound of the exact moments with a bias.
    pub(crate) fn exact_biased(&self, moments: &Vector<DoubleDouble>, z_f: f64, alpha: f64) -> f64 {
        let biased = self.biased(moments, alpha);
        self.bound.bounds(&biased, DoubleDouble::from(z_f)).lower.to_f64()
    }

    /// Whether inputs without an exact bound are given to it: single or double precision, our forms, no storage.
    pub(crate) fn is_checked(&self) -> bool {
        let is_checked = match self.arithmetic {
            Arithmetic::F32 | Arithmetic::F64 => true,
            Arithmetic::F16 | Arithmetic::Pairs => false,
        };
        is_checked && self.route == Route::Ours && self.encoding.is_none()
    }
}
