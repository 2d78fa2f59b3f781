//! Formulas in one variable z: parser, exact constants, evaluation over any [`Field`].

use crate::arithmetic::{DoubleDouble, Field, Real};
use crate::error::BasisError;

/// Longest accepted formula in bytes; nesting can be no deeper, so evaluation cannot exhaust the stack.
const MAX_FORMULA_LENGTH: usize = 200;

/// Longest accepted number in digits: double-double holds 31.
const MAX_DIGITS: usize = 30;

/// Largest accepted exponent of ten: with 30 digits more on either side double-double still holds all of its digits.
const LARGEST_POWER_OF_TEN: i32 = 200;

/// Expression tree of a formula in z.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Expression {
    Variable,
    Constant(DoubleDouble),
    Negate(Box<Expression>),
    Binary(Operator, Box<Expression>, Box<Expression>),
    Power(Box<Expression>, i32),
    Call(Function, Box<Expression>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    Sqrt,
    Cbrt,
    Exp,
    Ln,
    Sin,
    Cos,
}

impl Expression {
    pub(crate) fn evaluate<T: Field>(&self, z: T) -> T {
        match self {
            Self::Variable => z,
            Self::Constant(value) => T::from_double_double(*value),
            Self::Negate(inner) => -inner.evaluate(z),
            Self::Binary(operator, left, right) => {
                let (left, right) = (left.evaluate(z), right.evaluate(z));
                match operator {
                    Operator::Add => left + right,
                    Operator::Subtract => left - right,
                    Operator::Multiply => left * right,
                    Operator::Divide => left / right,
                }
            }
            Self::Power(base, exponent) => base.evaluate(z).powi(*exponent),
            Self::Call(function, inner) => {
                let x = inner.evaluate(z);
                match function {
                    Function::Sqrt => x.sqrt(),
                    Function::Cbrt => x.cbrt(),
                    Function::Exp => x.exp(),
                    Function::Ln => x.ln(),
                    Function::Sin => x.sin(),
                    Function::Cos => x.cos(),
                }
            }
        }
    }

    /// Parses a formula such as `1/(1+25(z-1/2)^2)`, `exp(-2z)`, `sin(3pi z)` or `e^(2z)`.
    ///
    /// Juxtaposition multiplies and binds like `*`; `^` takes an integer exponent, except on `e`.
    pub(crate) fn parse(text: &str) -> Result<Self, BasisError> {
        let fail = |reason: String| BasisError::Formula { formula: text.to_owned(), reason };
        if text.len() > MAX_FORMULA_LENGTH {
            return Err(BasisError::Formula {
                formula: format!("{}...", text.chars().take(30).collect::<String>()),
                reason: format!("{} bytes long, at most {MAX_FORMULA_LENGTH} are accepted", text.len()),
            });
        }
        let mut parser = Parser { rest: text.trim_start() };
        let expression = parser.sum().map_err(fail)?;
        if let Some(unexpected) = parser.rest.chars().next() {
            return Err(fail(format!("unexpected `{unexpected}`")));
        }
        Ok(expression)
    }

    pub(super) fn constant(&self) -> Option<DoubleDouble> {
        if let Self::Constant(value) = self { Some(*value) } else { None }
    }

    pub(crate) fn is_constant(&self) -> bool {
        self.constant().is_some()
    }

    fn binary(operator: Operator, left: Self, right: Self) -> Self {
        let one = DoubleDouble::one();
        let zero = DoubleDouble::zero();
        match (operator, left.constant(), right.constant()) {
            (_, Some(_), Some(_)) => {
                let folded = Self::Binary(operator, Box::new(left), Box::new(right));
                Self::Constant(folded.evaluate(zero))
            }
            (Operator::Multiply, Some(c), _) if c == one => right,
            (Operator::Multiply | Operator::Divide, _, Some(c)) if c == one => left,
            (Operator::Add, Some(c), _) if c == zero => right,
            (Operator::Add | Operator::Subtract, _, Some(c)) if c == zero => left,
            _ => Self::Binary(operator, Box::new(left), Box::new(right)),
        }
    }

    fn negated(self) -> Self {
        match self {
            Self::Constant(value) => Self::Constant(-value),
            Self::Negate(inner) => *inner,
            other => Self::Negate(Box::new(other)),
        }
    }
}

struct Parser<'a> {
    rest: &'a str,
}

type Parsed = Result<Expression, String>;

impl Parser<'_> {
    fn peek(&self) -> Option<char> {
        self.rest.chars().next()
    }

    fn skip(&mut self, bytes: usize) {
        self.rest = self.rest[bytes..].trim_start();
    }

    fn accept(&mut self, token: char) -> bool {
        let found = self.peek() == Some(token);
        if found {
            self.skip(token.len_utf8());
        }
        found
    }

    fn sum(&mut self) -> Parsed {
        let mut left = self.product()?;
        loop {
            let operator = if self.accept('+') {
                Operator::Add
            } else if self.accept('-') {
                Operator::Subtract
            } else {
                return Ok(left);
            };
            left = Expression::binary(operator, left, self.product()?);
        }
    }

    fn product(&mut self) -> Parsed {
        let mut left = self.signed()?;
        loop {
            if self.accept('*') {
                left = Expression::binary(Operator::Multiply, left, self.signed()?);
            } else if self.accept('/') {
                left = Expression::binary(Operator::Divide, left, self.signed()?);
            } else if self.peek().is_some_and(|c| c == '(' || c.is_ascii_alphanumeric() || c == '.') {
                left = Expression::binary(Operator::Multiply, left, self.power()?);
            } else {
                return Ok(left);
            }
        }
    }

    fn signed(&mut self) -> Parsed {
        if self.accept('-') {
            Ok(self.signed()?.negated())
        } else if self.accept('+') {
            self.signed()
        } else {
            self.power()
        }
    }

    fn power(&mut self) -> Parsed {
        let is_e = self.rest.starts_with('e') && !self.rest.starts_with("exp");
        let base = self.atom()?;
        if !self.accept('^') {
            return Ok(base);
        }
        let exponent = if self.accept('-') { self.atom()?.negated() } else { self.atom()? };
        match exponent.constant().map(DoubleDouble::to_f64) {
            Some(n) if n.fract() == 0.0 && n.abs() <= 64.0 => {
                if base.is_constant() {
                    return Ok(Expression::Constant(base.evaluate(DoubleDouble::zero()).powi(n as i32)));
                }
                Ok(if n == 1.0 { base } else { Expression::Power(Box::new(base), n as i32) })
            }
            _ if is_e => Ok(Expression::Call(Function::Exp, Box::new(exponent))),
            _ => Err("an exponent must be an integer of size at most 64 (or the base e)".to_owned()),
        }
    }

    fn atom(&mut self) -> Parsed {
        match self.peek() {
            None => Err("ends too early".to_owned()),
            Some('(') => {
                self.skip(1);
                self.closed()
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() => self.word(),
            Some(c) => Err(format!("unexpected `{c}`")),
        }
    }

    fn closed(&mut self) -> Parsed {
        let inner = self.sum()?;
        if self.accept(')') { Ok(inner) } else { Err("a `)` is missing".to_owned()) }
    }

    /// Decimal digits, with a point and an exponent of ten as in 2.5e-3, whose letter and digits follow without a space.
    /// Where spaces or a point leave open whether `e` is Euler's number, both readings are named.
    fn number(&mut self) -> Parsed {
        let end = self.rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(self.rest.len());
        let (digits, after) = self.rest.split_at(end);
        let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
        if fraction.contains('.') || digits.len() > MAX_DIGITS {
            return Err(format!("`{digits}` is not a number"));
        }
        if whole.is_empty() && fraction.is_empty() {
            return Err("`.` is not a number".to_owned());
        }
        let (exponent, length) = match exponent_of_ten(after) {
            None => ("0".to_owned(), 0),
            Some(found) if found.ambiguous => {
                let (sign, power) = found.exponent.split_at(found.exponent.len() - found.digits);
                let product = if sign.is_empty() { "*" } else { sign };
                return Err(format!(
                    "`{digits}{seen}` is read as the number {digits}e{exponent} or as Euler's number in \
                     {digits}*e{product}{power}: write one of the two",
                    seen = after[..found.length].trim_end(),
                    exponent = found.exponent,
                ));
            }
            Some(found) => (found.exponent, found.length),
        };
        // Decimal digits are accumulated in double-double, so that 0.1 is 1/10 and not its nearest double.
        let ten = DoubleDouble::from(10.0);
        let value = whole.bytes().chain(fraction.bytes()).fold(DoubleDouble::zero(), |value, digit| {
            value * ten + DoubleDouble::from(f64::from(digit - b'0'))
        });
        let power = exponent.parse::<i32>().ok().filter(|power| power.abs() <= LARGEST_POWER_OF_TEN);
        let Some(power) = power else {
            return Err(format!(
                "`{digits}e{exponent}`: exponents of ten go from -{LARGEST_POWER_OF_TEN} to {LARGEST_POWER_OF_TEN}"
            ));
        };
        let power = power - fraction.len() as i32;
        let scale = ten.powi(power.abs());
        self.skip(end + length);
        Ok(Expression::Constant(if power < 0 { value / scale } else { value * scale }))
    }

    fn word(&mut self) -> Parsed {
        let end = self.rest.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(self.rest.len());
        let word = &self.rest[..end];
        let function = match word {
            "z" => None,
            "pi" => {
                self.skip(2);
                return Ok(Expression::Constant(DoubleDouble::pi()));
            }
            "piz" => {
                self.skip(2);
                return Ok(Expression::Constant(DoubleDouble::pi()));
            }
            "e" => {
                self.skip(1);
                return Ok(Expression::Constant(DoubleDouble::one().exp()));
            }
            "sqrt" => Some(Function::Sqrt),
            "cbrt" => Some(Function::Cbrt),
            "exp" => Some(Function::Exp),
            "ln" => Some(Function::Ln),
            "sin" => Some(Function::Sin),
            "cos" => Some(Function::Cos),
            other => {
                return Err(format!(
                    "unknown name `{other}` (known: z, pi, e, sqrt, cbrt, exp, ln, sin, cos)"
                ));
            }
        };
        self.skip(end);
        let Some(function) = function else { return Ok(Expression::Variable) };
        if !self.accept('(') {
            return Err(format!("`{word}` must be followed by `(`", word = function.name()));
        }
        let argument = self.closed()?;
        let call = Expression::Call(function, Box::new(argument.clone()));
        if argument.is_constant() {
            return Ok(Expression::Constant(call.evaluate(DoubleDouble::zero())));
        }
        Ok(call)
    }
}

/// What follows a number's digits and may be its exponent of ten.
struct ExponentOfTen {
    /// Sign and digits without spaces.
    exponent: String,
    /// How many of its characters are digits.
    digits: usize,
    /// Bytes up to the end of the digits.
    length: usize,
    /// Whether it may as well be Euler's number.
    ambiguous: bool,
}

/// The exponent of ten that `text` begins with, spaces or not.
fn exponent_of_ten(text: &str) -> Option<ExponentOfTen> {
    let marked = text.trim_start();
    let letter = marked.strip_prefix('e').or_else(|| marked.strip_prefix('E'))?;
    let signed = letter.trim_start();
    let unsigned = signed.strip_prefix(['+', '-']).unwrap_or(signed);
    let sign = &signed[..signed.len() - unsigned.len()];
    let power = unsigned.trim_start();
    let digits = power.find(|c: char| !c.is_ascii_digit()).unwrap_or(power.len());
    if digits == 0 {
        return None;
    }
    let (power, rest) = power.split_at(digits);
    let length = text.len() - rest.len();
    let exponent = format!("{sign}{power}");
    // `2 e-3`, `2e - 3`; `2e3.5`, `2e3e4`.
    let spaced = length != 1 + exponent.len();
    let ambiguous = spaced || rest.starts_with('.') || exponent_of_ten(rest).is_some();
    Some(ExponentOfTen { exponent, digits, length, ambiguous })
}

impl Function {
    fn name(self) -> &'static str {
        match self {
            Self::Sqrt => "sqrt",
            Self::Cbrt => "cbrt",
            Self::Exp => "exp",
            Self::Ln => "ln",
            Self::Sin => "sin",
            Self::Cos => "cos",
        }
    }
}

#[cfg(test)]
mod tests;
