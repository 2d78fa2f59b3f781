//! The number types that the mathematics is written over.
//!
//! [`Field`] is what a formula needs: the four operations and the elementary functions. It is implemented by
//! machine numbers, by [`DoubleDouble`], by [`Ball`] (rigorous enclosures) and by [`Jet`] (derivatives), so one
//! expression tree yields values, derivatives and proofs. [`Real`] adds an order, which algorithms with branches need.

mod ball;
mod double_double;
mod double_word;
mod dyadic;
mod float_float;
mod half;
mod jet;

pub use ball::Ball;
pub use double_double::DoubleDouble;
pub use double_word::DoubleWord;
pub(crate) use dyadic::{Dyadic, minors};
pub use float_float::FloatFloat;
pub use half::Half;
pub use jet::Jet;

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Arithmetic with elementary functions; no order.
///
/// Every function follows IEEE habits outside its domain: the result is NaN or infinite, never a panic.
pub trait Field:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The constant, exactly where the type can hold it, else rounded (or enclosed).
    fn from_double_double(value: DoubleDouble) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Real cube root, odd.
    fn cbrt(self) -> Self;
    /// e^x.
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Sine of radians.
    fn sin(self) -> Self;
    /// Cosine of radians.
    fn cos(self) -> Self;

    /// The constant, exactly where the type can hold it, else rounded.
    fn from_f64(value: f64) -> Self {
        Self::from_double_double(DoubleDouble::from(value))
    }

    /// Integer power by repeated squaring; negative exponents divide.
    fn powi(self, exponent: i32) -> Self {
        let mut result = Self::from_f64(1.0);
        let mut square = self;
        let mut bits = exponent.unsigned_abs();
        while bits > 0 {
            if bits & 1 == 1 {
                result = result * square;
            }
            bits >>= 1;
            if bits > 0 {
                square = square * square;
            }
        }
        if exponent < 0 { Self::from_f64(1.0) / result } else { result }
    }
}

/// An ordered [`Field`]: [`Half`], `f32`, `f64`, [`FloatFloat`] or [`DoubleDouble`].
pub trait Real: Field + PartialOrd {
    /// Distance from 1 to the next larger number.
    const EPSILON: f64;
    /// Smallest divisor that is still trusted: well above underflow, far below any meaningful quantity.
    const TINY: f64;
    /// Nearest `f64`.
    fn to_f64(self) -> f64;

    /// Absolute value.
    #[inline(always)]
    fn abs(self) -> Self {
        if self < Self::zero() { -self } else { self }
    }
    /// Larger of two; `other` where `self` is NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    /// Smaller of two; `other` where `self` is NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    /// 0.
    #[inline(always)]
    fn zero() -> Self {
        Self::from_f64(0.0)
    }
    /// 1.
    #[inline(always)]
    fn one() -> Self {
        Self::from_f64(1.0)
    }
    /// Clamps to \[0, 1\]; NaN becomes 0, which for a lower bound is the value that proves nothing and darkens nothing.
    #[inline(always)]
    fn clamp_unit(self) -> Self {
        self.max(Self::zero()).min(Self::one())
    }
    /// a b - c d. Types with a wider one at hand round it once, so that nothing is lost where the products cancel.
    #[inline(always)]
    fn product_difference(a: Self, b: Self, c: Self, d: Self) -> Self {
        a * b - c * d
    }
    /// Whether the number is finite.
    #[inline(always)]
    fn is_finite(self) -> bool {
        self.to_f64().is_finite()
    }
}

macro_rules! machine_number {
    ($type:ty, $tiny:expr $(, $more:item)?) => {
        impl Field for $type {
            #[inline(always)]
            fn from_double_double(value: DoubleDouble) -> Self {
                value.to_f64() as $type
            }
            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                value as $type
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                <$type>::sqrt(self)
            }
            fn cbrt(self) -> Self {
                <$type>::cbrt(self)
            }
            fn exp(self) -> Self {
                <$type>::exp(self)
            }
            fn ln(self) -> Self {
                <$type>::ln(self)
            }
            fn sin(self) -> Self {
                <$type>::sin(self)
            }
            fn cos(self) -> Self {
                <$type>::cos(self)
            }
        }
        impl Real for $type {
            const EPSILON: f64 = <$type>::EPSILON as f64;
            const TINY: f64 = $tiny;
            #[inline(always)]
            fn to_f64(self) -> f64 {
                self as f64
            }
            #[inline(always)]
            fn abs(self) -> Self {
                <$type>::abs(self)
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                <$type>::is_finite(self)
            }
            $($more)?
        }
    };
}

machine_number!(
    f32,
    1e-30,
    #[inline(always)]
    fn product_difference(a: Self, b: Self, c: Self, d: Self) -> Self {
        // Products of single floats are exact in double precision.
        (f64::from(a) * f64::from(b) - f64::from(c) * f64::from(d)) as Self
    }
);
machine_number!(f64, 1e-200);
