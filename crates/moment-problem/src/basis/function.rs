//! Single functions of depth.

use super::expression::{Expression, Function, Operator};
use crate::arithmetic::{Ball, DoubleDouble, Field, Jet};
use crate::error::BasisError;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

/// The functions of [`Basis::default_family`](super::Basis::default_family), by id.
pub(super) const DEFAULT_FAMILY: [&str; 37] = [
    "z",
    "z^2",
    "z^3",
    "z^4",
    "z^5",
    "z^6",
    "z^7",
    "z^8",
    "sqrt(z+1/16)",
    "cbrt(z+1/16)",
    "1/(1+z)",
    "1/(1+z)^2",
    "1/(1/2+z)",
    "1/(1/4+z)",
    "1/(1+z^2)",
    "z/(1+z^2)",
    "1/(1+25(z-1/2)^2)",
    "exp(1z)",
    "exp(-1z)",
    "exp(2z)",
    "exp(-2z)",
    "exp(4z)",
    "exp(-4z)",
    "exp(8z)",
    "exp(-8(z-1/2)^2)",
    "ln(1+1z)",
    "ln(1+4z)",
    "sin(1pi z)",
    "cos(1pi z)",
    "sin(2pi z)",
    "cos(2pi z)",
    "sin(3pi z)",
    "cos(3pi z)",
    "sin(4pi z)",
    "cos(4pi z)",
    "sin(6pi z)",
    "cos(6pi z)",
];

/// Kinds of functions, from the simplest to the most special.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FunctionKind {
    /// Sums of powers of z.
    Polynomial,
    /// Quotients of polynomials.
    Rational,
    /// With a root.
    Radical,
    /// With a logarithm.
    Logarithmic,
    /// With an exponential function.
    Exponential,
    /// With a sine or cosine.
    Trigonometric,
}

fn kind(expression: &Expression) -> FunctionKind {
    match expression {
        Expression::Variable | Expression::Constant(_) => FunctionKind::Polynomial,
        Expression::Negate(inner) => kind(inner),
        Expression::Binary(operator, left, right) => {
            let divides = *operator == Operator::Divide && !matches!(**right, Expression::Constant(_));
            let own = if divides { FunctionKind::Rational } else { FunctionKind::Polynomial };
            own.max(kind(left)).max(kind(right))
        }
        Expression::Power(base, exponent) => {
            let own = if *exponent < 0 { FunctionKind::Rational } else { FunctionKind::Polynomial };
            own.max(kind(base))
        }
        Expression::Call(function, inner) => {
            let own = match function {
                Function::Sqrt | Function::Cbrt => FunctionKind::Radical,
                Function::Ln => FunctionKind::Logarithmic,
                Function::Exp => FunctionKind::Exponential,
                Function::Sin | Function::Cos => FunctionKind::Trigonometric,
            };
            own.max(kind(inner))
        }
    }
}

/// One component b_j of the map b that turns a depth into the data stored in a shadow map (MSM15 section 3).
///
/// Any formula in z is accepted; see [`BasisFunction::from_str`]. Two functions are equal when their formulas are
/// the same after constants are folded, however they were spelled.
#[derive(Clone, Debug)]
pub struct BasisFunction {
    name: Arc<str>,
    expression: Arc<Expression>,
}

impl BasisFunction {
    /// The id used in TOML, CSV and on the command line.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// b_j(z) in any arithmetic.
    pub fn evaluate<T: Field>(&self, z: T) -> T {
        match &*self.expression {
            Expression::Variable => z,
            expression => expression.evaluate(z),
        }
    }

    /// The monomial z^k, if the function is one.
    pub fn power(&self) -> Option<u32> {
        if *self.expression == Expression::Variable {
            return Some(1);
        }
        let Expression::Power(base, exponent) = &*self.expression else { return None };
        let exponent = u32::try_from(*exponent).ok().filter(|&k| k > 0);
        exponent.filter(|_| **base == Expression::Variable)
    }

    /// c, if the function is e^(c z) with c > 0.
    pub fn exponential(&self) -> Option<f64> {
        let Expression::Call(Function::Exp, argument) = &*self.expression else { return None };
        if **argument == Expression::Variable {
            return Some(1.0);
        }
        let Expression::Binary(Operator::Multiply, c, z) = &**argument else { return None };
        c.constant().map(DoubleDouble::to_f64).filter(|&c| c > 0.0 && **z == Expression::Variable)
    }

    /// What kind of function it is: that of its outermost transcendental part.
    pub fn kind(&self) -> FunctionKind {
        kind(&self.expression)
    }

    pub(super) fn monomial(k: usize) -> Self {
        let (name, expression) = match k {
            1 => ("z".to_owned(), Expression::Variable),
            _ => (format!("z^{k}"), Expression::Power(Box::new(Expression::Variable), k as i32)),
        };
        Self { name: name.into(), expression: Arc::new(expression) }
    }

    /// Checks that the function is finite and twice differentiable on \[0, 1\].
    fn check_unit_interval(&self) -> Result<(), BasisError> {
        const CELLS: i32 = 64;
        let at = |z: f64| BasisError::NotFinite { name: self.name.to_string(), z };
        for i in 0..=CELLS {
            let z = f64::from(i) / f64::from(CELLS);
            let jet = self.evaluate(Jet::variable(DoubleDouble::from(z)));
            if !(jet.value.to_f64().is_finite() && jet.second.to_f64().is_finite()) {
                return Err(at(z));
            }
        }
        // A pole between the samples shows as an unbounded enclosure; subdivide before giving up.
        let mut cells = vec![(0.0, 1.0, 0)];
        while let Some((low, high, depth)) = cells.pop() {
            if self.evaluate(Ball::interval(low, high)).upper().is_finite() {
                continue;
            }
            if depth == 16 {
                return Err(at(0.5 * (low + high)));
            }
            let middle = 0.5 * (low + high);
            cells.extend([(low, middle, depth + 1), (middle, high, depth + 1)]);
        }
        Ok(())
    }
}

impl PartialEq for BasisFunction {
    fn eq(&self, other: &Self) -> bool {
        self.expression == other.expression
    }
}

impl fmt::Display for BasisFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

impl FromStr for BasisFunction {
    type Err = BasisError;

    /// Parses a formula in z from `+ - * / ^`, parentheses, numbers (`0.25`, `2.5e-1`), `pi`, `e` and sqrt, cbrt, exp, ln,
    /// sin, cos. An `e` right after digits and before an exponent is one of ten: `2e3` is 2000, `2*e*3` three times 2 e.
    /// Juxtaposition multiplies (`2pi z`); spaces do not matter. A function of the default family gets its id.
    fn from_str(text: &str) -> Result<Self, BasisError> {
        let expression = Expression::parse(text)?;
        if expression.is_constant() {
            return Err(BasisError::Formula {
                formula: text.trim().to_owned(),
                reason: "a constant tells nothing about the depth".to_owned(),
            });
        }
        let known = DEFAULT_FAMILY
            .iter()
            .find(|id| Expression::parse(id).is_ok_and(|candidate| candidate == expression));
        let name: Arc<str> = match known {
            Some(id) => (*id).into(),
            None => text.split_whitespace().collect::<Vec<_>>().join(" ").into(),
        };
        let function = Self { name, expression: Arc::new(expression) };
        function.check_unit_interval()?;
        Ok(function)
    }
}
