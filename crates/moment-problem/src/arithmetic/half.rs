//! Half floats (binary16) as arithmetic: what a shader computes in with `enable f16`, at twice the rate of single floats.
//!
//! Every operation is carried out in single precision and rounded once more, which for sums, products, quotients and
//! square roots is the nearest half float: 24 digits are two more than twice 11.

use super::{DoubleDouble, Field, Real};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number with 11 binary digits between 2^-24 and 65504, held as a single float.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Half(f32);

impl Half {
    /// The nearest half float, ties to even; beyond the range it is infinite.
    #[inline]
    pub fn nearest(value: f32) -> Self {
        /// 2^-14, the least normal half float.
        const LEAST_NORMAL: f32 = 6.103_515_6e-5;
        /// Multiples of 2^-24 are the whole numbers that are left after adding this.
        const SHIFT: f32 = 0.75;
        /// From here on the nearest number is infinite.
        const BEYOND: f32 = 65_520.0;
        if value.abs() < LEAST_NORMAL {
            // Half an ulp of 0.75 is 2^-25: the sum is rounded to a multiple of 2^-24.
            return Self((value.abs() + SHIFT - SHIFT).copysign(value));
        }
        if value.abs() >= BEYOND {
            return Self(f32::INFINITY.copysign(value));
        }
        let bits = value.to_bits();
        // 13 bits of the fraction go.
        let rounded = bits.wrapping_add(0x0fff + (bits >> 13 & 1)) & !0x1fff;
        Self(if value.is_nan() { value } else { f32::from_bits(rounded) })
    }

    /// The same number as a single float.
    #[inline(always)]
    pub fn to_f32(self) -> f32 {
        self.0
    }
}

macro_rules! operation {
    ($trait:ident, $method:ident) => {
        impl $trait for Half {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self::nearest(self.0.$method(other.0))
            }
        }
    };
}

operation!(Add, add);
operation!(Sub, sub);
operation!(Mul, mul);
operation!(Div, div);

impl Neg for Half {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Field for Half {
    fn from_double_double(value: DoubleDouble) -> Self {
        // Twice rounded, which moves a constant by half a unit and a hair at most.
        Self::nearest(value.to_f64() as f32)
    }
    fn sqrt(self) -> Self {
        Self::nearest(self.0.sqrt())
    }
    fn cbrt(self) -> Self {
        Self::nearest(self.0.cbrt())
    }
    fn exp(self) -> Self {
        Self::nearest(self.0.exp())
    }
    fn ln(self) -> Self {
        Self::nearest(self.0.ln())
    }
    fn sin(self) -> Self {
        Self::nearest(self.0.sin())
    }
    fn cos(self) -> Self {
        Self::nearest(self.0.cos())
    }
}

impl Real for Half {
    const EPSILON: f64 = 9.765_625e-4; // 2^-10
    const TINY: f64 = 6.103_515_625e-5; // 2^-14, below which digits are lost
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self.0)
    }
    #[inline(always)]
    fn product_difference(a: Self, b: Self, c: Self, d: Self) -> Self {
        // Products of half floats are exact in single precision, which a shader has at hand.
        Self::nearest(a.0 * b.0 - c.0 * d.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of all half floats the distance to the nearest one is at most that to any other.
    #[test]
    fn numbers_become_the_nearest_half_float_ties_to_even() {
        let half = |bits: u32| f32::from_bits(bits);
        // Bits of single floats whose last 13 are zero are half floats in the normal range.
        for (value, nearest) in [
            (1.0, 1.0),
            (1.0 + 2f32.powi(-11), 1.0),
            (1.0 + 3.0 * 2f32.powi(-11), 1.0 + 2.0 * 2f32.powi(-10)),
            (half(0x3f80_1001), 1.0 + 2f32.powi(-10)),
            (65_519.0, 65_504.0),
            (65_520.0, f32::INFINITY),
            (-1e9, f32::NEG_INFINITY),
            (2f32.powi(-25), 0.0),
            (1.5 * 2f32.powi(-24), 2f32.powi(-23)),
            (-(2f32.powi(-24)), -(2f32.powi(-24))),
        ] {
            assert_eq!(Half::nearest(value).to_f32(), nearest, "{value:e}");
        }
        assert!(Half::nearest(f32::NAN).to_f32().is_nan());
    }

    #[test]
    fn operations_round_once() {
        let [a, b] = [1.0 / 3.0, 0.1].map(Half::from_f64);
        assert_eq!((a + b).to_f64(), Half::nearest((a.to_f64() + b.to_f64()) as f32).to_f64());
        assert_eq!((Half::from_f64(2048.0) + Half::one()).to_f64(), 2048.0);
        assert_eq!((Half::from_f64(60_000.0) * Half::from_f64(2.0)).to_f64(), f64::INFINITY);
        // 1 - (1 - 2^-11)^2 in two roundings would be a multiple of 2^-11.
        let near = Half::from_f64(1.0 - 2f64.powi(-11));
        let exact = 1.0 - near.to_f64() * near.to_f64();
        let difference = Half::product_difference(Half::one(), Half::one(), near, near).to_f64();
        assert!((difference - exact).abs() < 1e-6, "{difference:e} for {exact:e}");
    }
}
