//! Counting what a shader would compute: a machine-independent measure of arithmetic.
//!
//! A technique is run on numbers that count. One addition, subtraction, multiplication or comparison is one operation;
//! a division, square root or elementary function is [`SPECIAL`], as graphics processors have a quarter as many units
//! for these. Copies, sign changes and constants are free. It is a count, not a time: latency, divergence and
//! registers are left out.

use moment_problem::arithmetic::{DoubleDouble, Field, Real};
use std::cell::Cell;
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Operations that a division, square root or elementary function counts as.
pub const SPECIAL: u64 = 4;

thread_local! {
    static OPERATIONS: Cell<u64> = const { Cell::new(0) };
}

fn charge(operations: u64) {
    OPERATIONS.with(|counter| counter.set(counter.get() + operations));
}

/// Operations of a computation on [`Counted`] numbers.
pub(crate) fn count(compute: impl FnOnce() -> Counted) -> u64 {
    OPERATIONS.with(|counter| counter.set(0));
    compute();
    OPERATIONS.with(Cell::get)
}

/// A single-precision number whose operations are counted, thread by thread.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counted(pub(crate) f32);

impl PartialEq for Counted {
    fn eq(&self, other: &Self) -> bool {
        charge(1);
        self.0 == other.0
    }
}

impl PartialOrd for Counted {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        charge(1);
        self.0.partial_cmp(&other.0)
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $operations:expr) => {
        impl $trait for Counted {
            type Output = Self;

            fn $method(self, other: Self) -> Self {
                charge($operations);
                Self($trait::$method(self.0, other.0))
            }
        }
    };
}

operator!(Add, add, 1);
operator!(Sub, sub, 1);
operator!(Mul, mul, 1);
operator!(Div, div, SPECIAL);

impl Neg for Counted {
    type Output = Self;

    fn neg(self) -> Self {
        Self(-self.0)
    }
}

macro_rules! special {
    ($($name:ident),*) => {
        $(fn $name(self) -> Self {
            charge(SPECIAL);
            Self(Field::$name(self.0))
        })*
    };
}

impl Field for Counted {
    fn from_double_double(value: DoubleDouble) -> Self {
        Self(f32::from_double_double(value))
    }

    fn from_f64(value: f64) -> Self {
        Self(value as f32)
    }

    special!(sqrt, cbrt, exp, ln, sin, cos);
}

impl Real for Counted {
    const EPSILON: f64 = <f32 as Real>::EPSILON;
    const TINY: f64 = <f32 as Real>::TINY;

    fn to_f64(self) -> f64 {
        f64::from(self.0)
    }

    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    /// As a shader does it: two products split by Dekker's method, three differences.
    fn product_difference(a: Self, b: Self, c: Self, d: Self) -> Self {
        const EXACT_PRODUCT: u64 = 17;
        charge(2 * EXACT_PRODUCT + 3);
        Self(f32::product_difference(a.0, b.0, c.0, d.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn operations_are_counted_and_values_kept() {
        let mut value = 0.0;
        let operations = count(|| {
            let x = Counted(2.0);
            let y = (x * x - Counted(1.0)).sqrt() / x;
            value = y.0;
            if y < x { -y } else { x }
        });
        assert_eq!(operations, 1 + 1 + SPECIAL + SPECIAL + 1);
        assert_eq!(value, 3f32.sqrt() / 2.0);
        assert_eq!(count(|| Counted(1.0)), 0);
    }
}
