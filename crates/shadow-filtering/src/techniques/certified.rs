//! Any basis, by the certified semi-infinite linear program (MSM15 section 3.1). Milliseconds a fragment: for
//! evaluation, not for frames.

use crate::error::FilteringError;
use crate::technique::{Technique, unit};
use moment_problem::{Basis, ExchangeSimplex, LowerBound};

/// The sharp bound of any basis on \[0, 1\].
pub struct Certified {
    basis: Basis,
    solver: ExchangeSimplex,
}

impl Certified {
    /// `basis` as on the command line: `power:4`, `trig:2` or a list of functions.
    ///
    /// # Errors
    /// [`FilteringError::Basis`] for a basis that cannot be read or prepared.
    pub fn new(basis: &str) -> Result<Self, FilteringError> {
        let basis: Basis = basis.parse()?;
        let solver = ExchangeSimplex::new(&basis)?;
        Ok(Self { basis, solver })
    }
}

impl Technique for Certified {
    fn name(&self) -> String {
        format!("LP {}", self.basis)
    }

    fn channels(&self) -> usize {
        self.basis.len()
    }

    fn encode(&self, depth: f64, out: &mut [f64]) {
        for (value, function) in out.iter_mut().zip(self.basis.functions()) {
            *value = function.evaluate(unit(depth));
        }
    }

    fn shade(&self, filtered: &[f64], z_f: f64) -> Result<f64, FilteringError> {
        Ok(self.solver.bounds(filtered, unit(z_f))?.lower.clamp(0.0, 1.0))
    }

    fn is_lower_bound(&self) -> bool {
        true
    }
}
