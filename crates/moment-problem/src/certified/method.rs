//! From a basis, an interval and a solver's name to the method that computes bounds.

use super::bounds::{BoundMethod, Interval};
use super::closed_form::closed_form;
use super::linear_program::LinearProgram;
use super::semi_infinite::ExchangeSimplex;
use crate::basis::Basis;
use crate::error::MomentError;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// How bounds are computed.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Solver {
    /// MSM15 Algorithm 1: a linear program on a grid, solved by a general solver.
    Lp,
    /// The certified exchange simplex, any basis on \[0, 1\].
    Fast,
    /// The closed form of this basis and interval.
    Closed,
}

impl Solver {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Lp, Self::Fast, Self::Closed];

    /// The name in TOML and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lp => "lp",
            Self::Fast => "fast",
            Self::Closed => "closed",
        }
    }
}

impl FromStr for Solver {
    type Err = MomentError;

    fn from_str(name: &str) -> Result<Self, MomentError> {
        let known = Self::ALL.into_iter().find(|solver| solver.name() == name);
        known.ok_or_else(|| unsupported(format!("solver `{name}` is none of lp, fast, closed")))
    }
}

/// The method for a basis on an interval: the closed form where one exists, else the exchange simplex, unless a
/// solver is named.
///
/// Errors: no method for this combination (the message names one that works), or a basis that cannot be prepared.
pub fn method(basis: &Basis, interval: Interval, solver: Option<Solver>) -> Result<BoundMethod, MomentError> {
    let closed = match solver {
        None | Some(Solver::Closed) => closed_form(basis, interval)?,
        Some(Solver::Lp | Solver::Fast) => None,
    };
    match (closed, solver, interval) {
        (Some(closed), ..) => Ok(closed),
        (None, Some(Solver::Closed), Interval::Unit) => Err(unsupported(format!(
            "basis `{basis}` has no closed form on [0, 1] (power:4 and trig:2 have): use solver fast"
        ))),
        (None, Some(Solver::Lp), Interval::Unit) => Ok(Box::new(LinearProgram::new(basis)?)),
        (None, None | Some(Solver::Fast), Interval::Unit) => Ok(Box::new(ExchangeSimplex::new(basis)?)),
        (None, Some(Solver::Lp | Solver::Fast), Interval::Real) => {
            let solver = if solver == Some(Solver::Lp) { "lp" } else { "fast" };
            Err(unsupported(format!(
                "solver {solver} works on the interval unit only: the real line needs solver closed"
            )))
        }
        (None, None | Some(Solver::Closed), Interval::Real) => Err(unsupported(no_form_on_the_line(basis))),
    }
}

fn no_form_on_the_line(basis: &Basis) -> String {
    match basis.power_order() {
        Some(1) => {
            "power:1 on the real line bounds nothing, the mean alone is compatible with any mass in front: \
                    use the interval unit"
                .to_owned()
        }
        Some(order) if order % 2 == 1 => format!(
            "power:{order} on the real line has the same bound as power:{}: use that basis or the interval unit",
            order - 1
        ),
        _ => format!(
            "basis `{basis}` has no method on the real line (power:2, power:4, power:6, power:8 and one exp(c z) \
             with c > 0 have): use the interval unit"
        ),
    }
}

fn unsupported(message: String) -> MomentError {
    MomentError::Unsupported(message)
}
