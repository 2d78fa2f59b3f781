//! Basis functions and ordered sets of them.

mod expression;

use crate::arithmetic::{Ball, DoubleDouble, Field, Jet};
use crate::error::BasisError;
use expression::{Expression, Function, Operator};
use serde::Deserialize;
use std::fmt;
use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;

/// Largest number of functions in a [`Basis`].
pub const MAX_FUNCTIONS: usize = 16;

/// The 37 functions of the default family, by id.
///
/// MSM15 section 3.2 searches all 4-subsets of 37 "rather elementary, smooth functions ranging from rational
/// functions to exponentials and trigonometric functions"; its list is in a supplement that is not public. This
/// family has the same size and the same kinds of function. Only `z` to `z^4` and sine and cosine of 2 pi z and
/// 4 pi z are certainly in the paper's.
pub const DEFAULT_FAMILY: [&str; 37] = [
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
        match &*self.expression {
            Expression::Variable => Some(1),
            Expression::Power(base, exponent) if **base == Expression::Variable => {
                u32::try_from(*exponent).ok().filter(|&k| k > 0)
            }
            _ => None,
        }
    }

    /// c, if the function is e^(c z) with c > 0.
    pub fn exponential(&self) -> Option<f64> {
        let Expression::Call(Function::Exp, argument) = &*self.expression else { return None };
        let factor = match &**argument {
            Expression::Variable => 1.0,
            Expression::Binary(Operator::Multiply, c, z) if **z == Expression::Variable => {
                let Expression::Constant(c) = &**c else { return None };
                c.to_f64()
            }
            _ => return None,
        };
        (factor > 0.0).then_some(factor)
    }

    /// What kind of function it is: that of its outermost transcendental part.
    pub fn kind(&self) -> FunctionKind {
        kind(&self.expression)
    }

    fn monomial(k: usize) -> Self {
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

/// An ordered set of basis functions: the map b from a depth to m stored channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Basis {
    functions: Vec<BasisFunction>,
}

impl Basis {
    /// Collects functions; at least one, at most [`MAX_FUNCTIONS`], all different.
    pub fn new(functions: Vec<BasisFunction>) -> Result<Self, BasisError> {
        if functions.is_empty() {
            return Err(BasisError::Empty);
        }
        if functions.len() > MAX_FUNCTIONS {
            return Err(BasisError::TooLarge { count: functions.len(), largest: MAX_FUNCTIONS });
        }
        for (i, function) in functions.iter().enumerate() {
            if functions[..i].contains(function) {
                return Err(BasisError::Duplicate { name: function.name().to_owned() });
            }
        }
        Ok(Self { functions })
    }

    /// z, z^2, ..., z^m: moment shadow maps (MSM15 equation 1).
    ///
    /// # Panics
    /// If `m` is 0 or above [`MAX_FUNCTIONS`]; use [`Basis::from_str`] for input of unknown origin.
    pub fn power(m: usize) -> Self {
        assert!((1..=MAX_FUNCTIONS).contains(&m), "power basis of order {m}");
        Self { functions: (1..=m).map(BasisFunction::monomial).collect() }
    }

    /// sin 2 pi z, cos 2 pi z, ..., sin 2 pi n z, cos 2 pi n z: trigonometric moments (MSM15 equation 1 for n = 2).
    ///
    /// # Panics
    /// If `n` is 0 or above [`MAX_FUNCTIONS`] / 2.
    pub fn trigonometric(n: usize) -> Self {
        assert!((1..=MAX_FUNCTIONS / 2).contains(&n), "trigonometric basis of order {n}");
        let function = |name: &str, k: usize| {
            let formula = format!("{name}({}pi z)", 2 * k);
            BasisFunction::from_str(&formula).unwrap_or_else(|error| unreachable!("{error}"))
        };
        Self { functions: (1..=n).flat_map(|k| [function("sin", k), function("cos", k)]).collect() }
    }

    /// The [`DEFAULT_FAMILY`] as functions.
    pub fn default_family() -> Vec<BasisFunction> {
        DEFAULT_FAMILY
            .iter()
            .map(|id| BasisFunction::from_str(id).unwrap_or_else(|error| unreachable!("{error}")))
            .collect()
    }

    /// Reads a family of candidate functions from a TOML file: `functions = ["z", "exp(-2z)", ...]`, any number.
    pub fn read_family(path: &Path) -> Result<Vec<BasisFunction>, BasisError> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct FamilyFile {
            functions: Vec<String>,
        }
        let fail = |reason: String| BasisError::Family {
            path: path.display().to_string(),
            reason: first_line(&reason),
        };
        let text = std::fs::read_to_string(path).map_err(|error| fail(error.to_string()))?;
        let file: FamilyFile = toml::from_str(&text).map_err(|error| fail(error.message().to_owned()))?;
        let mut functions: Vec<BasisFunction> = Vec::new();
        for formula in &file.functions {
            let function = BasisFunction::from_str(formula).map_err(|error| fail(error.to_string()))?;
            if functions.contains(&function) {
                return Err(fail(format!("basis function `{}` appears twice", function.name())));
            }
            functions.push(function);
        }
        if functions.is_empty() {
            return Err(fail("a family needs at least one function".to_owned()));
        }
        Ok(functions)
    }

    /// The functions in order.
    pub fn functions(&self) -> &[BasisFunction] {
        &self.functions
    }

    /// Number m of functions.
    pub fn len(&self) -> usize {
        self.functions.len()
    }

    /// Never true: a basis has at least one function.
    pub fn is_empty(&self) -> bool {
        self.functions.is_empty()
    }

    /// b(z), length m.
    pub fn evaluate<T: Field>(&self, z: T) -> Vec<T> {
        self.functions.iter().map(|function| function.evaluate(z)).collect()
    }

    /// m, if the basis is z, z^2, ..., z^m in this order.
    pub fn power_order(&self) -> Option<usize> {
        let ordered = self.functions.iter().enumerate().all(|(i, f)| f.power() == Some(i as u32 + 1));
        ordered.then_some(self.len())
    }

    /// Whether this is the basis of trigonometric moment shadow mapping, in the order of MSM15 equation 1.
    pub fn is_trigonometric4(&self) -> bool {
        self.len() == 4 && *self == Self::trigonometric(2)
    }
}

fn first_line(text: &str) -> String {
    text.lines().next().unwrap_or_default().to_owned()
}

impl fmt::Display for Basis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, function) in self.functions.iter().enumerate() {
            write!(f, "{}{function}", if i == 0 { "" } else { "," })?;
        }
        Ok(())
    }
}

impl FromStr for Basis {
    type Err = BasisError;

    /// `power:M`, `trig:N` or a list of formulas separated by commas.
    fn from_str(text: &str) -> Result<Self, BasisError> {
        let order = |digits: &str, largest: usize| {
            let parsed = digits.trim().parse::<usize>().ok().filter(|m| (1..=largest).contains(m));
            parsed.ok_or_else(|| BasisError::Order { basis: text.trim().to_owned(), largest })
        };
        if let Some(digits) = text.trim().strip_prefix("power:") {
            return Ok(Self::power(order(digits, MAX_FUNCTIONS)?));
        }
        if let Some(digits) = text.trim().strip_prefix("trig:") {
            return Ok(Self::trigonometric(order(digits, MAX_FUNCTIONS / 2)?));
        }
        if text.trim().is_empty() {
            return Err(BasisError::Empty);
        }
        Self::new(text.split(',').map(BasisFunction::from_str).collect::<Result<_, _>>()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_family_has_37_different_functions() {
        let family = Basis::default_family();
        assert_eq!(family.len(), 37);
        for (i, function) in family.iter().enumerate() {
            assert_eq!(function.name(), DEFAULT_FAMILY[i]);
            assert!(!family[..i].contains(function), "{function} twice");
        }
    }

    #[test]
    fn shorthands_equal_their_spelling_out() {
        assert_eq!("power:3".parse::<Basis>(), "z, z^2, z^3".parse());
        let trigonometric: Basis = "sin(2 pi z),cos(2pi z),sin(4pi z),cos(4 pi z)".parse().unwrap();
        assert!(trigonometric.is_trigonometric4());
        assert_eq!("trig:2".parse::<Basis>(), Ok(trigonometric));
        assert_eq!("e^(2z)".parse::<BasisFunction>().unwrap().name(), "exp(2z)");
    }

    #[test]
    fn a_family_is_read_from_toml_and_its_mistakes_are_named() {
        let folder = std::env::temp_dir().join(format!("msm-family-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("family.toml");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            Basis::read_family(&path).map_err(|error| error.to_string())
        };
        let family = read("functions = ['z', 'exp(-3z)', 'z/(2+z)']").unwrap();
        assert_eq!(family.iter().map(BasisFunction::name).collect::<Vec<_>>(), ["z", "exp(-3z)", "z/(2+z)"]);
        for (text, needle) in [
            ("functions = ['z', 'tan(z)']", "tan"),
            ("functions = ['z', '1z']", "`z` appears twice"),
            ("functions = []", "at least one"),
            ("function = ['z']", "function"),
            ("functions = 3", "invalid type"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(needle) && error.contains("family.toml"), "{text}: {error}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(Basis::read_family(&path).unwrap_err().to_string().contains("family.toml"));
    }

    #[test]
    fn useless_bases_are_errors_that_name_the_value() {
        for (text, needle) in [
            ("power:0", "power:0"),
            ("power:99", "power:99"),
            ("trig:x", "trig:x"),
            ("z,,z^2", "ends too early"),
            ("z,z^2,z", "`z` appears twice"),
            ("sinh(z)", "sinh"),
            ("ln(z)", "not finite at z = 0"),
            ("1/(z-1/3)", "not finite at z = 0.333"),
            ("2", "constant"),
            ("", "at least one"),
        ] {
            let error = text.parse::<Basis>().unwrap_err().to_string();
            assert!(error.contains(needle), "{text}: {error}");
        }
    }
}
