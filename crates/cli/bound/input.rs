//! What a bound is computed from: a basis, and atoms or moments.

use crate::outcome::Failure;
use anyhow::{Context, anyhow};
use moment_problem::{Basis, Bounds, DepthDistribution, LowerBound, MomentError};

pub(crate) fn parse_basis(text: &str) -> Result<Basis, String> {
    text.parse::<Basis>().map_err(|error| error.to_string())
}

/// What is known about the depths in the kernel.
pub(crate) enum Input {
    Atoms(DepthDistribution),
    Moments(Vec<f64>),
}

impl Input {
    /// From `--atoms` or `--moments`.
    pub(crate) fn parse(atoms: Option<&str>, moments: Option<&str>) -> Result<Self, Failure> {
        match (atoms, moments) {
            (Some(text), _) => Ok(Self::Atoms(parse_atoms(text)?)),
            (None, Some(text)) => {
                let moments = text.split(',').map(|number| parse_number(number, "--moments"));
                Ok(Self::Moments(moments.collect::<Result<_, _>>()?))
            }
            (None, None) => Err(Failure::Input(anyhow!("give --atoms or --moments"))),
        }
    }

    /// Bounds at z_f.
    pub(crate) fn bounds(&self, method: &dyn LowerBound, z_f: f64) -> Result<Bounds, MomentError> {
        match self {
            Self::Atoms(z) => method.bounds_of(z, z_f),
            Self::Moments(moments) => method.bounds(moments, z_f),
        }
    }

    /// Whose fault an error is.
    pub(crate) fn failure(&self, error: MomentError) -> Failure {
        let known = matches!(self, Self::Atoms(_));
        if error.is_failure() || (known && error.denies_moments()) {
            Failure::Failed(error.into())
        } else {
            Failure::Input(error.into())
        }
    }
}

/// A number of an option.
pub(crate) fn parse_number(text: &str, option: &str) -> Result<f64, Failure> {
    let number = text.trim().parse::<f64>();
    number.map_err(|_| Failure::Input(anyhow!("`{}` in {option} is not a number", text.trim())))
}

fn parse_atoms(text: &str) -> Result<DepthDistribution, Failure> {
    if text.trim().is_empty() {
        return Err(Failure::Input(anyhow!("--atoms is empty: a distribution needs at least one atom")));
    }
    let mut depths = Vec::new();
    let mut weights = Vec::new();
    for atom in text.split(',') {
        let (depth, weight) = atom.split_once(':').ok_or_else(|| {
            Failure::Input(anyhow!("`{}` in --atoms is not of the form depth:weight", atom.trim()))
        })?;
        depths.push(parse_number(depth, "--atoms")?);
        weights.push(parse_number(weight, "--atoms")?);
    }
    DepthDistribution::new(&depths, &weights).context("--atoms").map_err(Failure::Input)
}
