//! Values with derivatives up to the third (forward-mode differentiation).

use super::{DoubleDouble, Field};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A function value with its first three derivatives by one variable.
#[derive(Clone, Copy, Debug)]
pub struct Jet<T> {
    /// f.
    pub value: T,
    /// f'.
    pub first: T,
    /// f''.
    pub second: T,
    /// f'''.
    pub third: T,
}

impl<T: Field> Jet<T> {
    /// The variable itself at `value`: derivatives 1, 0 and 0.
    pub fn variable(value: T) -> Self {
        let zero = T::from_f64(0.0);
        Self { value, first: T::from_f64(1.0), second: zero, third: zero }
    }

    /// g(f) for g with the given value and derivatives at f (Faa di Bruno).
    fn chain(self, value: T, first: T, second: T, third: T) -> Self {
        let square = self.first * self.first;
        let cross = self.first * self.second;
        Self {
            value,
            first: first * self.first,
            second: second * square + first * self.second,
            third: third * square * self.first + second * (cross + cross + cross) + first * self.third,
        }
    }

    /// The jet times a constant.
    pub fn scale(self, factor: T) -> Self {
        Self {
            value: factor * self.value,
            first: factor * self.first,
            second: factor * self.second,
            third: factor * self.third,
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
            third: self.third + other.third,
        }
    }
}

impl<T: Field> Neg for Jet<T> {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, first: -self.first, second: -self.second, third: -self.third }
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
        let mixed = self.second * other.first + self.first * other.second;
        Self {
            value: self.value * other.value,
            first: self.first * other.value + self.value * other.first,
            second: self.second * other.value + cross + cross + self.value * other.second,
            third: self.third * other.value + mixed + mixed + mixed + self.value * other.third,
        }
    }
}

impl<T: Field> Div for Jet<T> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let one = T::from_f64(1.0);
        let inverse = one / other.value;
        let square = inverse * inverse;
        let second = (square + square) * inverse;
        self * other.chain(inverse, -square, second, -(T::from_f64(3.0) * second * inverse))
    }
}

impl<T: Field> Field for Jet<T> {
    fn from_double_double(value: DoubleDouble) -> Self {
        let zero = T::from_f64(0.0);
        Self { value: T::from_double_double(value), first: zero, second: zero, third: zero }
    }

    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        let first = T::from_f64(0.5) / root;
        let second = -(first * T::from_f64(0.5) / self.value);
        self.chain(root, first, second, -(T::from_f64(1.5) * second / self.value))
    }

    fn cbrt(self) -> Self {
        let root = self.value.cbrt();
        let first = root / (T::from_f64(3.0) * self.value);
        let third = T::from_f64(1.0) / T::from_f64(3.0);
        let second = -(T::from_f64(2.0) * third * first / self.value);
        self.chain(root, first, second, -(T::from_f64(5.0) * third * second / self.value))
    }

    fn exp(self) -> Self {
        let value = self.value.exp();
        self.chain(value, value, value, value)
    }

    fn ln(self) -> Self {
        let inverse = T::from_f64(1.0) / self.value;
        let square = inverse * inverse;
        self.chain(self.value.ln(), inverse, -square, T::from_f64(2.0) * square * inverse)
    }

    fn sin(self) -> Self {
        let (sine, cosine) = (self.value.sin(), self.value.cos());
        self.chain(sine, cosine, -sine, -cosine)
    }

    fn cos(self) -> Self {
        let (sine, cosine) = (self.value.sin(), self.value.cos());
        self.chain(cosine, -sine, -cosine, sine)
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
            let third = (f(Jet::variable(x + h)).second - f(Jet::variable(x - h)).second) / (2.0 * h);
            assert_eq!(jet.value, f(x));
            assert!((jet.third - third).abs() < 1e-5 * jet.third.abs().max(1.0), "{x}");
            assert!((jet.first - first).abs() < 1e-6 * jet.first.abs().max(1.0), "{x}");
            assert!((jet.second - second).abs() < 1e-5 * jet.second.abs().max(1.0), "{x}");
        }
    }
}
