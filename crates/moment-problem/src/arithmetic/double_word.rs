//! Double-word arithmetic: a number as the unevaluated sum of two machine floats, with twice their digits.
//!
//! Products are split by Dekker's method instead of a fused multiply-add: a default x86-64 build has no such instruction
//! and would call a library routine for each, and on graphics processors it is not exact on every device that offers one.

use super::Real;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A machine float, half of a [`DoubleWord`].
pub trait Word: Real {
    /// 2^s + 1 with s half of the significand's bits, rounded up.
    const SPLITTER: Self;
}

impl Word for f32 {
    const SPLITTER: Self = 4097.0; // 2^12 + 1
}

impl Word for f64 {
    const SPLITTER: Self = 134_217_729.0; // 2^27 + 1
}

/// `high + low` with `|low| <= ulp(high) / 2`. Relative error of one operation: below 2^-44 for `f32`, 2^-100 for `f64`.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct DoubleWord<F> {
    pub(super) high: F,
    pub(super) low: F,
}

#[inline(always)]
fn two_sum<F: Word>(a: F, b: F) -> (F, F) {
    let sum = a + b;
    let b_virtual = sum - a;
    (sum, (a - (sum - b_virtual)) + (b - b_virtual))
}

#[inline(always)]
fn split<F: Word>(a: F) -> (F, F) {
    let t = F::SPLITTER * a;
    let high = t - (t - a);
    (high, a - high)
}

#[inline(always)]
fn two_product<F: Word>(a: F, b: F) -> (F, F) {
    let product = a * b;
    let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
    (product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low)
}

impl<F: Word> DoubleWord<F> {
    /// Sum of two machine floats, exactly.
    #[inline(always)]
    pub fn sum(a: F, b: F) -> Self {
        let (high, low) = two_sum(a, b);
        Self::fast_sum(high, low)
    }

    /// The same for |a| >= |b|.
    #[inline(always)]
    fn fast_sum(a: F, b: F) -> Self {
        let high = a + b;
        // An infinite or NaN sum has no error term; without this, inf - inf would turn overflow into NaN.
        let low = if high.is_finite() { b - (high - a) } else { F::zero() };
        Self { high, low }
    }

    #[inline(always)]
    pub(super) fn scale(self, factor: F) -> Self {
        let (product, error) = two_product(self.high, factor);
        Self::fast_sum(product, error + self.low * factor)
    }

    #[inline(always)]
    pub(super) fn square_root(self) -> Self {
        if self.high <= F::zero() || !self.high.is_finite() {
            return Self::from(self.high.sqrt());
        }
        let root = Self::from(self.high.sqrt());
        let correction = (self - root * root).high / (root.high + root.high);
        Self::fast_sum(root.high, correction)
    }
}

impl<F: Word> From<F> for DoubleWord<F> {
    #[inline(always)]
    fn from(high: F) -> Self {
        Self { high, low: F::zero() }
    }
}

impl<F: Word> Add for DoubleWord<F> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (high, high_error) = two_sum(self.high, other.high);
        let (low, low_error) = two_sum(self.low, other.low);
        let partial = Self::fast_sum(high, high_error + low);
        Self::fast_sum(partial.high, partial.low + low_error)
    }
}

impl<F: Word> Neg for DoubleWord<F> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl<F: Word> Sub for DoubleWord<F> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<F: Word> Mul for DoubleWord<F> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (product, error) = two_product(self.high, other.high);
        Self::fast_sum(product, error + (self.high * other.low + self.low * other.high))
    }
}

impl<F: Word> Div for DoubleWord<F> {
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
        Self::fast_sum(first, second) + Self::from(remainder.high / other.high)
    }
}

impl<F: Word> PartialOrd for DoubleWord<F> {
    #[inline(always)]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        match self.high.partial_cmp(&other.high) {
            Some(Ordering::Equal) => self.low.partial_cmp(&other.low),
            order => order,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 24 bits times 24 bits fit into an `f64`; so do sums of numbers whose exponents differ by less than 29.
    #[test]
    fn sums_and_products_of_two_words_are_exact() {
        let value =
            |i: u32| (i as f32 * 1.618_034).fract().mul_add(3.0, -1.5) * ((i % 23) as f32 - 11.0).exp2();
        for i in 0..500 {
            for j in 0..40 {
                let (a, b) = (value(i), value(977 * j + i));
                let (sum, product) = (DoubleWord::sum(a, b), two_product(a, b));
                assert_eq!(
                    f64::from(sum.high) + f64::from(sum.low),
                    f64::from(a) + f64::from(b),
                    "{a} + {b}"
                );
                assert_eq!(
                    f64::from(product.0) + f64::from(product.1),
                    f64::from(a) * f64::from(b),
                    "{a} * {b}"
                );
            }
        }
    }
}
