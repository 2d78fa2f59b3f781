//! From a basis, an interval and a solver's name to the method that computes bounds.

use moment_problem::{Basis, ExchangeSimplex, Interval, LinearProgram, LowerBound, MomentError, closed_form};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A bound method that threads can share.
pub type Method = Box<dyn LowerBound + Send + Sync>;

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

/// The interval of admissible depths by its name on the command line and in TOML.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Domain {
    /// All real numbers.
    Real,
    /// \[0, 1\].
    #[default]
    Unit,
}

impl Domain {
    /// The interval I of MSM15 Problem 1.
    pub fn interval(self) -> Interval {
        match self {
            Self::Real => Interval::Real,
            Self::Unit => Interval::Unit,
        }
    }
}

impl fmt::Display for Domain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Real => "the real line",
            Self::Unit => "[0, 1]",
        })
    }
}

/// The method for a basis on an interval: the closed form where one exists, else the exchange simplex, unless a
/// solver is named.
///
/// Errors: no method for this combination (the message names one that works), or a basis that cannot be prepared.
pub fn method(basis: &Basis, domain: Domain, solver: Option<Solver>) -> Result<Method, MomentError> {
    let closed = match solver {
        None | Some(Solver::Closed) => closed_form(basis, domain.interval())?,
        Some(Solver::Lp | Solver::Fast) => None,
    };
    match (closed, solver, domain) {
        (Some(closed), ..) => Ok(closed),
        (None, Some(Solver::Closed), Domain::Unit) => Err(unsupported(format!(
            "basis `{basis}` has no closed form on [0, 1] (power:4 and trig:2 have): use solver fast"
        ))),
        (None, Some(Solver::Lp), Domain::Unit) => Ok(Box::new(LinearProgram::new(basis)?)),
        (None, None | Some(Solver::Fast), Domain::Unit) => Ok(Box::new(ExchangeSimplex::new(basis)?)),
        (None, Some(Solver::Lp | Solver::Fast), Domain::Real) => {
            let solver = if solver == Some(Solver::Lp) { "lp" } else { "fast" };
            Err(unsupported(format!(
                "solver {solver} works on the interval unit only: the real line needs solver closed"
            )))
        }
        (None, None | Some(Solver::Closed), Domain::Real) => Err(unsupported(no_form_on_the_line(basis))),
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
