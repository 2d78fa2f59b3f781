//! Basis functions and ordered sets of them.

mod expression;
mod function;

pub use function::{BasisFunction, FunctionKind};

use crate::arithmetic::Field;
use crate::error::BasisError;
use function::DEFAULT_FAMILY;
use std::fmt;
use std::str::FromStr;

/// Largest number of functions in a [`Basis`].
pub const MAX_FUNCTIONS: usize = 16;

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

    /// 37 elementary functions: z to z^8, roots, rational functions, exponentials, logarithms, sines and cosines.
    ///
    /// MSM15 section 3.2 searches all 4-subsets of 37 "rather elementary, smooth functions ranging from rational
    /// functions to exponentials and trigonometric functions"; its list is in a supplement that is not public. This
    /// family has the same size and the same kinds of function. Only `z` to `z^4` and sine and cosine of 2 pi z and
    /// 4 pi z are certainly in the paper's.
    pub fn default_family() -> Vec<BasisFunction> {
        DEFAULT_FAMILY
            .iter()
            .map(|id| BasisFunction::from_str(id).unwrap_or_else(|error| unreachable!("{error}")))
            .collect()
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
