//! Unevaluated sums of two `f32`: some 14 decimal digits for hardware without `f64`, such as graphics processors.
//!
//! Moments in single precision lose most of their digits in the pivots of a nearly singular matrix, and adding a moment
//! bias of 1e-6 rounds it to one or two digits. Done with pairs, both lose nothing that matters, whereas the moments
//! that are stored and the bound that is returned remain single floats. Products are split by Dekker's method: a fused
//! multiply-add is not exact on every device that offers one.

use super::{DoubleDouble, Field, Real};
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// `high + low` with `|low| <= ulp(high) / 2`. Relative error of one operation: below 2^-44.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloatFloat {
    high: f32,
    low: f32,
}

#[inline(always)]
fn two_sum(a: f32, b: f32) -> (f32, f32) {
    let sum = a + b;
    let b_virtual = sum - a;
    (sum, (a - (sum - b_virtual)) + (b - b_virtual))
}

#[inline(always)]
fn normalised(a: f32, b: f32) -> FloatFloat {
    let sum = a + b;
    // An infinite or NaN sum has no error term; without this, inf - inf would turn overflow into NaN.
    let low = if sum.is_finite() { b - (sum - a) } else { 0.0 };
    FloatFloat { high: sum, low }
}

#[inline(always)]
fn split(a: f32) -> (f32, f32) {
    const SPLITTER: f32 = 4097.0; // 2^12 + 1
    let t = SPLITTER * a;
    let high = t - (t - a);
    (high, a - high)
}

#[inline(always)]
fn two_product(a: f32, b: f32) -> (f32, f32) {
    let product = a * b;
    let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
    (product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low)
}

impl FloatFloat {
    /// Nearest single float.
    #[inline(always)]
    pub fn to_f32(self) -> f32 {
        self.high
    }

    /// The nearest pair.
    fn rounded(value: f64) -> Self {
        let high = value as f32;
        let low = if high.is_finite() { (value - f64::from(high)) as f32 } else { 0.0 };
        Self { high, low }
    }

    /// An elementary function, through `f64`: for bases that are evaluated beforehand, not for shaders.
    fn through(self, function: impl Fn(f64) -> f64) -> Self {
        Self::rounded(function(self.to_f64()))
    }
}

impl From<f32> for FloatFloat {
    #[inline(always)]
    fn from(high: f32) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for FloatFloat {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (high, high_error) = two_sum(self.high, other.high);
        let (low, low_error) = two_sum(self.low, other.low);
        let partial = normalised(high, high_error + low);
        normalised(partial.high, partial.low + low_error)
    }
}

impl Neg for FloatFloat {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for FloatFloat {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for FloatFloat {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (product, error) = two_product(self.high, other.high);
        normalised(product, error + (self.high * other.low + self.low * other.high))
    }
}

impl Div for FloatFloat {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        if !first.is_finite() {
            return Self::from(first);
        }
        let rest = self - other * Self::from(first);
        let second = rest.high / other.high;
        let rest = rest - other * Self::from(second);
        normalised(first, second) + Self::from(rest.high / other.high)
    }
}

impl PartialOrd for FloatFloat {
    #[inline(always)]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        match self.high.partial_cmp(&other.high) {
            Some(Ordering::Equal) => self.low.partial_cmp(&other.low),
            order => order,
        }
    }
}

impl Field for FloatFloat {
    fn from_double_double(value: DoubleDouble) -> Self {
        Self::rounded(value.to_f64())
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        if self.high <= 0.0 || !self.high.is_finite() {
            return Self::from(self.high.sqrt());
        }
        let root = Self::from(self.high.sqrt());
        let correction = (self - root * root).high / (2.0 * root.high);
        normalised(root.high, correction)
    }

    fn cbrt(self) -> Self {
        self.through(f64::cbrt)
    }

    fn exp(self) -> Self {
        self.through(f64::exp)
    }

    fn ln(self) -> Self {
        self.through(f64::ln)
    }

    fn sin(self) -> Self {
        self.through(f64::sin)
    }

    fn cos(self) -> Self {
        self.through(f64::cos)
    }
}

impl Real for FloatFloat {
    const EPSILON: f64 = 5.7e-14; // 2^-44
    const TINY: f64 = 1e-30;
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self.high) + f64::from(self.low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers with both parts, of either sign and any size from 1e-4 to 1e4.
    fn samples() -> Vec<FloatFloat> {
        let value =
            |i: i32| f64::from(i % 7 - 3) * 1.37 * (f64::from(i % 19) - 9.5).exp2() + f64::from(i) * 1e-9;
        (0..300).map(|i| FloatFloat::rounded(value(i))).collect()
    }

    #[test]
    fn operations_have_thirteen_digits() {
        for (i, &a) in samples().iter().enumerate() {
            for &b in &samples()[i % 5..] {
                let (x, y) = (a.to_f64(), b.to_f64());
                let size = x.abs() + y.abs();
                let close = |value: FloatFloat, exact: f64, size: f64| {
                    let error = (value.to_f64() - exact).abs();
                    assert!(error <= FloatFloat::EPSILON * size, "{a:?} {b:?}: {value:?} {exact} {error:e}");
                };
                close(a + b, x + y, size);
                close(a - b, x - y, size);
                close(a * b, x * y, (x * y).abs());
                if y != 0.0 {
                    close(a / b, x / y, (x / y).abs());
                }
            }
            if a.to_f64() > 0.0 {
                let root = a.sqrt();
                assert!((root.to_f64() - a.to_f64().sqrt()).abs() <= FloatFloat::EPSILON * root.to_f64());
            }
        }
    }

    #[test]
    fn what_is_not_finite_stays_so() {
        let (zero, one) = (FloatFloat::from(0.0), FloatFloat::from(1.0));
        assert!((one / zero).to_f32().is_infinite() && (zero / zero).to_f32().is_nan());
        assert!(!(FloatFloat::from(f32::MAX) + FloatFloat::from(f32::MAX)).to_f32().is_finite());
        assert!((-one).sqrt().to_f32().is_nan() && zero.sqrt() == zero);
    }
}
