//! Unevaluated sums of two `f32`: some 14 decimal digits for hardware without `f64`, such as graphics processors.
//!
//! Moments in single precision lose most of their digits in the pivots of a nearly singular matrix, and adding a moment
//! bias of 1e-6 rounds it to one or two digits. Done with pairs, both lose nothing that matters, whereas the moments
//! that are stored and the bound that is returned remain single floats.

use super::{DoubleDouble, DoubleWord, Field, Real};

/// Two `f32`.
pub type FloatFloat = DoubleWord<f32>;

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

impl Field for FloatFloat {
    fn from_double_double(value: DoubleDouble) -> Self {
        Self::rounded(value.to_f64())
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.square_root()
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
