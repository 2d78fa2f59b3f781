//! Values with first and second derivatives (forward-mode differentiation).

use super::{DoubleDouble, Field};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A function value with its first two derivatives by one variable.
#[derive(Clone, Copy, Debug)]
pub struct Jet<T> {
    /// f.
    pub value: T,
    /// f'.
    pub first: T,
    /// f''.
    pub second: T,
}

impl<T: Field> Jet<T> {
    /// The variable itself at `value`: derivatives 1 and 0.
    pub fn variable(value: T) -> Self {
        Self { value, first: T::from_f64(1.0), second: T::from_f64(0.0) }
    }

    /// g(f) for g with the given value and derivatives at f.
    fn chain(self, value: T, first: T, second: T) -> Self {
        Self {
            value,
            first: first * self.first,
            second: second * self.first * self.first + first * self.second,
        }
    }
}

impl<T: Field> Add for Jet<T> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            first: self.first + other.first,
            second: self.second + other.second,
        }
    }
}

impl<T: Field> Neg for Jet<T> {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, first: -self.first, second: -self.second }
    }
}

impl<T: Field> Sub for Jet<T> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + (-other)
    }
}

impl<T: Field> Mul for Jet<T> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let cross = self.first * other.first;
        Self {
            value: self.value * other.value,
            first: self.first * other.value + self.value * other.first,
            second: self.second * other.value + cross + cross + self.value * other.second,
        }
    }
}

impl<T: Field> Div for Jet<T> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let one = T::from_f64(1.0);
        let inverse = one / other.value;
        let square = inverse * inverse;
        self * other.chain(inverse, -square, (square + square) * inverse)
    }
}

impl<T: Field> Field for Jet<T> {
    fn from_double_double(value: DoubleDouble) -> Self {
        let zero = T::from_f64(0.0);
        Self { value: T::from_double_double(value), first: zero, second: zero }
    }

    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        let first = T::from_f64(0.5) / root;
        self.chain(root, first, -(first * T::from_f64(0.5) / self.value))
    }

    fn cbrt(self) -> Self {
        let root = self.value.cbrt();
        let first = root / (T::from_f64(3.0) * self.value);
        self.chain(root, first, -(T::from_f64(2.0) * first / (T::from_f64(3.0) * self.value)))
    }

    fn exp(self) -> Self {
        let value = self.value.exp();
        self.chain(value, value, value)
    }

    fn ln(self) -> Self {
        let inverse = T::from_f64(1.0) / self.value;
        self.chain(self.value.ln(), inverse, -(inverse * inverse))
    }

    fn sin(self) -> Self {
        let (sine, cosine) = (self.value.sin(), self.value.cos());
        self.chain(sine, cosine, -sine)
    }

    fn cos(self) -> Self {
        let (sine, cosine) = (self.value.sin(), self.value.cos());
        self.chain(cosine, -sine, -cosine)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_match_central_differences() {
        fn f<T: Field>(x: T) -> T {
            let one = T::from_f64(1.0);
            (x * x).exp() / (one + x).powi(3)
                + (one + x).ln() * x.sin() * x.cos()
                + (x + one).sqrt()
                + x.cbrt()
        }
        for x in [0.1f64, 0.35, 0.8] {
            let jet = f(Jet::variable(x));
            let h = 1e-4;
            let first = (f(x + h) - f(x - h)) / (2.0 * h);
            let second = (f(x + h) - 2.0 * f(x) + f(x - h)) / (h * h);
            assert_eq!(jet.value, f(x));
            assert!((jet.first - first).abs() < 1e-6 * jet.first.abs().max(1.0), "{x}");
            assert!((jet.second - second).abs() < 1e-5 * jet.second.abs().max(1.0), "{x}");
        }
    }
}
