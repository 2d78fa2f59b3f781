//! The sharp bound of any basis on \[0, 1\], by the certified semi-infinite linear program (MSM15 section 3.1).
//! Milliseconds a fragment: for evaluation, not for frames.

use super::Parts;
use crate::bound::{AnyBound, unit};
use crate::error::FilteringError;
use crate::spec::TechniqueSpec;
use moment_problem::hamburger::Pair;
use moment_problem::{Basis, ExchangeSimplex, LowerBound};

struct Certified {
    name: String,
    solver: ExchangeSimplex,
}

impl AnyBound for Certified {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn shade_double(&self, b: &[f64], z_f: f64) -> Result<f64, FilteringError> {
        Ok(self.bounds_double(b, z_f)?.lower)
    }

    fn bounds_double(&self, b: &[f64], z_f: f64) -> Result<Pair<f64>, FilteringError> {
        let bounds = self.solver.bounds(b, unit(z_f))?;
        Ok(Pair { lower: bounds.lower.clamp(0.0, 1.0), upper: bounds.upper.clamp(0.0, 1.0) })
    }

    fn has_upper(&self) -> bool {
        true
    }

    fn is_lower_bound(&self) -> bool {
        true
    }
}

/// `basis` as on the command line: `power:4`, `trig:2` or a list of functions.
pub(crate) fn parts(spec: &TechniqueSpec) -> Result<Parts, FilteringError> {
    let text = spec.basis.as_deref().unwrap_or_default();
    let basis: Basis = text.parse()?;
    let bound = Certified { name: format!("LP {basis}"), solver: ExchangeSimplex::new(&basis)? };
    Ok(Parts::new(basis, bound))
}
