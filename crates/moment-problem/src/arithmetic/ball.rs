//! Midpoint-radius enclosures over [`DoubleDouble`]: the arithmetic of the proofs.

use super::{DoubleDouble, Field};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The set of reals within `radius` of `middle`. An operation's result contains every value that the operation
/// takes on members of its operands; where that is impossible (division by a ball around 0) the radius is infinite.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    middle: DoubleDouble,
    radius: f64,
}

/// Relative error of one double-double operation, with two bits to spare.
const MIDDLE_ERROR: f64 = 3.2e-30;
/// Relative error of a double-double elementary function (largest seen in tests: 2e-30).
const FUNCTION_ERROR: f64 = 1e-28;
/// Radii are computed in round-to-nearest; this factor covers a dozen such roundings.
const ROUND_UP: f64 = 1.0 + 4e-15;

impl Ball {
    /// The interval \[low, high\].
    pub fn interval(low: f64, high: f64) -> Self {
        let middle = DoubleDouble::sum(low, high) * DoubleDouble::from(0.5);
        Self { middle, radius: (high - low).abs() * 0.5 * ROUND_UP }
    }

    /// One point.
    pub fn point(value: DoubleDouble) -> Self {
        Self { middle: value, radius: 0.0 }
    }

    /// Largest member.
    pub fn upper(self) -> f64 {
        let value = self.middle.to_f64();
        value + (self.radius + value.abs() * f64::EPSILON) * ROUND_UP
    }

    /// Smallest member.
    pub fn lower(self) -> f64 {
        -(-self).upper()
    }

    fn with_error(middle: DoubleDouble, radius: f64, relative: f64) -> Self {
        let total = (radius + middle.to_f64().abs() * relative) * ROUND_UP;
        // A NaN anywhere (0 * inf, for instance) must not pass for a small ball.
        if total.is_nan() || !middle.to_f64().is_finite() {
            Self { middle: DoubleDouble::from(0.0), radius: f64::INFINITY }
        } else {
            Self { middle, radius: total }
        }
    }

    fn unbounded() -> Self {
        Self { middle: DoubleDouble::from(0.0), radius: f64::INFINITY }
    }

    /// The monotone function that maps the middle to `middle`, with `slope` a bound on its derivative over the ball.
    fn lipschitz(self, middle: DoubleDouble, slope: f64) -> Self {
        let radius = if self.radius == 0.0 { 0.0 } else { self.radius * slope };
        Self::with_error(middle, radius, FUNCTION_ERROR)
    }
}

impl Add for Ball {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let middle = self.middle + other.middle;
        // Cancellation can make the sum small: the error is relative to the operands.
        let rounding = (self.middle.to_f64().abs() + other.middle.to_f64().abs()) * MIDDLE_ERROR;
        Self::with_error(middle, self.radius + other.radius + rounding, 0.0)
    }
}

impl Neg for Ball {
    type Output = Self;
    fn neg(self) -> Self {
        Self { middle: -self.middle, radius: self.radius }
    }
}

impl Sub for Ball {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + (-other)
    }
}

impl Mul for Ball {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self.middle.to_f64().abs() * ROUND_UP, other.middle.to_f64().abs() * ROUND_UP);
        let radius = if self.radius == 0.0 && other.radius == 0.0 {
            0.0
        } else {
            a * other.radius + b * self.radius + self.radius * other.radius
        };
        Self::with_error(self.middle * other.middle, radius, MIDDLE_ERROR)
    }
}

impl Div for Ball {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let size = other.middle.to_f64().abs() * (1.0 - f64::EPSILON);
        let nearest = size - other.radius;
        if nearest.is_nan() || nearest <= 0.0 {
            return Self::unbounded();
        }
        let quotient = self.middle / other.middle;
        // |x/y - m/n| <= (|x - m| + |m/n| |y - n|) / |y|
        let spread = self.radius + quotient.to_f64().abs() * ROUND_UP * other.radius;
        Self::with_error(quotient, spread / nearest, MIDDLE_ERROR)
    }
}

impl Field for Ball {
    fn from_double_double(value: DoubleDouble) -> Self {
        Self { middle: value, radius: value.to_f64().abs() * MIDDLE_ERROR }
    }

    fn from_f64(value: f64) -> Self {
        Self::point(DoubleDouble::from(value))
    }

    fn sqrt(self) -> Self {
        let nearest = self.lower();
        if nearest.is_nan() || nearest <= 0.0 {
            return Self::unbounded();
        }
        self.lipschitz(self.middle.sqrt(), 0.5 / nearest.sqrt())
    }

    fn cbrt(self) -> Self {
        let nearest = self.lower().max(-self.upper());
        if nearest.is_nan() || nearest <= 0.0 {
            return Self::unbounded();
        }
        self.lipschitz(self.middle.cbrt(), 1.0 / (3.0 * nearest.cbrt().powi(2)))
    }

    fn exp(self) -> Self {
        let slope = self.upper().exp() * (1.0 + 1e-15);
        self.lipschitz(self.middle.exp(), slope)
    }

    fn ln(self) -> Self {
        let nearest = self.lower();
        if nearest.is_nan() || nearest <= 0.0 {
            return Self::unbounded();
        }
        let logarithm = self.middle.ln();
        // Near 1 the logarithm is small but its error is not: add the absolute part.
        let ball = self.lipschitz(logarithm, 1.0 / nearest);
        Self { radius: ball.radius + MIDDLE_ERROR, ..ball }
    }

    fn sin(self) -> Self {
        let ball = self.lipschitz(self.middle.sin(), 1.0);
        Self { radius: ball.radius + FUNCTION_ERROR, ..ball }
    }

    fn cos(self) -> Self {
        let ball = self.lipschitz(self.middle.cos(), 1.0);
        Self { radius: ball.radius + FUNCTION_ERROR, ..ball }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enclosures_contain_sampled_values() {
        let expression = |x: Ball| {
            let one = Ball::from_f64(1.0);
            (x * x).exp() / (one + x) + (one + x).ln() * x.sin() - (x + one).sqrt() * x.cos()
                + (x + one).cbrt()
        };
        let plain = |x: f64| {
            (x * x).exp() / (1.0 + x) + (1.0 + x).ln() * x.sin() - (x + 1.0).sqrt() * x.cos()
                + (x + 1.0).cbrt()
        };
        for i in 0..50 {
            let (low, high) = (f64::from(i) * 0.02, f64::from(i) * 0.02 + 0.01);
            let ball = expression(Ball::interval(low, high));
            assert!(ball.upper() - ball.lower() < 0.2, "useless enclosure {ball:?}");
            for k in 0..=10 {
                let value = plain(low + (high - low) * f64::from(k) / 10.0);
                assert!(
                    ball.lower() <= value + 1e-15 && value - 1e-15 <= ball.upper(),
                    "{value} outside {ball:?}"
                );
            }
        }
    }

    #[test]
    fn impossible_operations_are_unbounded_not_wrong() {
        let around_zero = Ball::interval(-0.1, 0.1);
        for ball in
            [Ball::from_f64(1.0) / around_zero, around_zero.ln(), around_zero.sqrt(), around_zero.cbrt()]
        {
            assert_eq!(ball.upper(), f64::INFINITY);
            assert_eq!(ball.lower(), f64::NEG_INFINITY);
        }
    }
}
