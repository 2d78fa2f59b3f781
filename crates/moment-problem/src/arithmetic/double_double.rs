//! Unevaluated sums of two `f64`: about 31 decimal digits without any dependency.

use super::{DoubleWord, Field, Real};

/// Two `f64`.
pub type DoubleDouble = DoubleWord<f64>;

/// pi to twice double precision.
pub(super) const PI: DoubleDouble =
    DoubleDouble { high: std::f64::consts::PI, low: 1.224_646_799_147_353_2e-16 };
/// ln 2 to twice double precision.
const LN_2: DoubleDouble = DoubleDouble { high: std::f64::consts::LN_2, low: 2.319_046_813_846_299_6e-17 };

impl DoubleDouble {
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

impl Field for DoubleDouble {
    fn from_double_double(value: DoubleDouble) -> Self {
        value
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.square_root()
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
