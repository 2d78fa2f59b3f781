//! Unevaluated sums of two `f64`: about 31 decimal digits without any dependency.
//!
//! Products are split by Dekker's method instead of a fused multiply-add, because a default x86-64 build has no
//! such instruction and would call a library routine for each.

use super::{Field, Real};
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// `high + low` with `|low| <= ulp(high) / 2`. Relative error of one operation: below 2^-100.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleDouble {
    high: f64,
    low: f64,
}

/// pi to twice double precision.
pub const PI: DoubleDouble = DoubleDouble { high: std::f64::consts::PI, low: 1.224_646_799_147_353_2e-16 };
/// ln 2 to twice double precision.
const LN_2: DoubleDouble = DoubleDouble { high: std::f64::consts::LN_2, low: 2.319_046_813_846_299_6e-17 };

#[inline(always)]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_virtual = sum - a;
    (sum, (a - (sum - b_virtual)) + (b - b_virtual))
}

#[inline(always)]
fn fast_two_sum(a: f64, b: f64) -> DoubleDouble {
    let sum = a + b;
    // An infinite or NaN sum has no error term; without this, inf - inf would turn overflow into NaN.
    let low = if sum.is_finite() { b - (sum - a) } else { 0.0 };
    DoubleDouble { high: sum, low }
}

#[inline(always)]
fn split(a: f64) -> (f64, f64) {
    const SPLITTER: f64 = 134_217_729.0; // 2^27 + 1
    let t = SPLITTER * a;
    let high = t - (t - a);
    (high, a - high)
}

#[inline(always)]
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let (a_high, a_low) = split(a);
    let (b_high, b_low) = split(b);
    (product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low)
}

impl DoubleDouble {
    /// Sum of two doubles, exactly.
    pub fn sum(a: f64, b: f64) -> Self {
        let (high, low) = two_sum(a, b);
        fast_two_sum(high, low)
    }

    /// Nearest double.
    #[inline(always)]
    pub fn to_f64(self) -> f64 {
        self.high
    }

    /// The part below the nearest double.
    pub fn low(self) -> f64 {
        self.low
    }

    /// pi.
    pub fn pi() -> Self {
        PI
    }

    fn scale(self, factor: f64) -> Self {
        let (product, error) = two_product(self.high, factor);
        fast_two_sum(product, error + self.low * factor)
    }

    /// Multiplication by a power of two, exact.
    fn scale_exact(self, power_of_two: f64) -> Self {
        Self { high: self.high * power_of_two, low: self.low * power_of_two }
    }

    /// Sine and cosine together, for |x| up to a few thousand (beyond it the reduction loses digits).
    fn sin_cos(self) -> (Self, Self) {
        if !self.high.is_finite() {
            return (Self::from(f64::NAN), Self::from(f64::NAN));
        }
        let quadrant = (self.high / std::f64::consts::FRAC_PI_2).round();
        let reduced = self - PI.scale_exact(0.5).scale(quadrant);
        let square = reduced * reduced;
        let series = |first: Self, start: f64| {
            let (mut sum, mut term, mut k) = (first, first, start);
            // 28 factorial terms leave less than 1e-33 for |x| <= pi / 4.
            while k < 30.0 {
                term = -(term * square) / Self::from(k * (k + 1.0));
                sum = sum + term;
                k += 2.0;
            }
            sum
        };
        let sine = series(reduced, 2.0);
        let cosine = series(Self::from(1.0), 1.0);
        match quadrant.rem_euclid(4.0) as u8 {
            0 => (sine, cosine),
            1 => (cosine, -sine),
            2 => (-sine, -cosine),
            _ => (-cosine, sine),
        }
    }
}

impl From<f64> for DoubleDouble {
    #[inline(always)]
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for DoubleDouble {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (high, high_error) = two_sum(self.high, other.high);
        let (low, low_error) = two_sum(self.low, other.low);
        let partial = fast_two_sum(high, high_error + low);
        fast_two_sum(partial.high, partial.low + low_error)
    }
}

impl Neg for DoubleDouble {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for DoubleDouble {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + (-other)
    }
}

impl Mul for DoubleDouble {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (product, error) = two_product(self.high, other.high);
        fast_two_sum(product, error + (self.high * other.low + self.low * other.high))
    }
}

impl Div for DoubleDouble {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        if !first.is_finite() {
            return Self::from(first);
        }
        let remainder = self - other.scale(first);
        let second = remainder.high / other.high;
        let remainder = remainder - other.scale(second);
        let quotient = fast_two_sum(first, second);
        quotient + Self::from(remainder.high / other.high)
    }
}

impl PartialOrd for DoubleDouble {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        match self.high.partial_cmp(&other.high) {
            Some(Ordering::Equal) => self.low.partial_cmp(&other.low),
            order => order,
        }
    }
}

impl Field for DoubleDouble {
    fn from_double_double(value: DoubleDouble) -> Self {
        value
    }

    fn sqrt(self) -> Self {
        if self.high <= 0.0 || !self.high.is_finite() {
            return Self::from(self.high.sqrt());
        }
        let root = Self::from(self.high.sqrt());
        let correction = (self - root * root).high / (2.0 * root.high);
        Self::sum(root.high, correction)
    }

    fn cbrt(self) -> Self {
        if self.high == 0.0 || !self.high.is_finite() {
            return Self::from(self.high.cbrt());
        }
        let root = Self::from(self.high.cbrt());
        let correction = (self - root * root * root).high / (3.0 * root.high * root.high);
        Self::sum(root.high, correction)
    }

    fn exp(self) -> Self {
        if !self.high.is_finite() || self.high.abs() > 700.0 {
            return Self::from(self.high.exp());
        }
        const HALVINGS: i32 = 9;
        let exponent = (self.high / std::f64::consts::LN_2).round();
        let reduced = (self - LN_2.scale(exponent)).scale_exact(0.5_f64.powi(HALVINGS));
        // e^x - 1 rather than e^x, so that the repeated squaring keeps the small part.
        let (mut sum, mut term) = (reduced, reduced);
        for k in 2..10 {
            term = term * reduced / Self::from(f64::from(k));
            sum = sum + term;
        }
        for _ in 0..HALVINGS {
            sum = sum.scale_exact(2.0) + sum * sum;
        }
        (sum + Self::from(1.0)).scale_exact(2f64.powi(exponent as i32))
    }

    fn ln(self) -> Self {
        if self.high <= 0.0 || !self.high.is_finite() {
            return Self::from(self.high.ln());
        }
        let first = Self::from(self.high.ln());
        // One Newton step doubles the digits of the double.
        first + (self * (-first).exp() - Self::from(1.0))
    }

    fn sin(self) -> Self {
        self.sin_cos().0
    }

    fn cos(self) -> Self {
        self.sin_cos().1
    }
}

impl Real for DoubleDouble {
    const EPSILON: f64 = 7.9e-31; // 2^-100
    const TINY: f64 = 1e-200;
    fn to_f64(self) -> f64 {
        self.high
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_close(value: DoubleDouble, expected: (f64, f64)) {
        let expected = DoubleDouble::sum(expected.0, expected.1);
        let error = (value - expected).to_f64().abs();
        assert!(error <= 1e-30 * expected.to_f64().abs(), "{value:?} against {expected:?}: {error:e}");
    }

    /// Reference pairs from 60-digit arithmetic.
    #[test]
    fn elementary_functions_have_thirty_digits() {
        let x = DoubleDouble::from(0.7);
        assert_close(x.exp(), (2.0137527074704766, -2.005_824_354_976_479_3e-16));
        assert_close(x.sin(), (0.644_217_687_237_691, 2.874_056_792_733_875_5e-18));
    }

    #[test]
    fn inverse_functions_undo_each_other() {
        for i in 1..200 {
            let x = DoubleDouble::from(f64::from(i) * 0.037);
            assert!(((x.exp().ln() - x) / x).to_f64().abs() < 2e-30, "exp/ln at {x:?}");
            assert!(((x.sqrt() * x.sqrt() - x) / x).to_f64().abs() < 2e-31, "sqrt at {x:?}");
            assert!(((x.cbrt().powi(3) - x) / x).to_f64().abs() < 2e-31, "cbrt at {x:?}");
            let (s, c) = (x.sin(), x.cos());
            assert!((s * s + c * c - DoubleDouble::one()).to_f64().abs() < 2e-31, "sin/cos at {x:?}");
            let double = (x + x).sin() - DoubleDouble::from(2.0) * s * c;
            assert!(double.to_f64().abs() < 1e-30, "sin 2x at {x:?}");
        }
    }

    #[test]
    fn a_product_of_sums_is_exact_where_doubles_round() {
        let x = DoubleDouble::sum(1.0, 1e-17);
        let y = x * x - DoubleDouble::one();
        assert!((y.to_f64() - 2e-17).abs() < 1e-32);
    }
}
