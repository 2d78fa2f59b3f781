//! Weighted depths: the distribution Z of depth values within a filter kernel.

use crate::arithmetic::{DoubleDouble, Field, Real};
use crate::basis::Basis;
use crate::error::DistributionError;

/// Accepted deviation of the sum of the weights from 1, so that a hand-written 0.333333 is no error. The weights are
/// then divided by their sum.
const WEIGHT_SUM_TOLERANCE: f64 = 2e-6;

/// Finitely many depths with weights: the distribution Z of MSM15 section 3.
///
/// Depths ascend strictly; equal depths are merged, zero weights dropped, weights sum to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthDistribution {
    depths: Vec<f64>,
    weights: Vec<DoubleDouble>,
}

impl DepthDistribution {
    /// Builds a distribution from any order of depths; both slices have the same length.
    pub fn new(depths: &[f64], weights: &[f64]) -> Result<Self, DistributionError> {
        if depths.len() != weights.len() {
            return Err(DistributionError::Length { depths: depths.len(), weights: weights.len() });
        }
        if let Some((index, &value)) = depths.iter().enumerate().find(|(_, z)| !z.is_finite()) {
            return Err(DistributionError::Depth { index, value });
        }
        if let Some((index, &value)) =
            weights.iter().enumerate().find(|(_, w)| !(w.is_finite() && **w >= 0.0))
        {
            return Err(DistributionError::Weight { index, value });
        }
        let mut atoms: Vec<(f64, f64)> =
            depths.iter().copied().zip(weights.iter().copied()).filter(|&(_, w)| w > 0.0).collect();
        if depths.is_empty() {
            return Err(DistributionError::Empty);
        }
        let sum = atoms.iter().fold(DoubleDouble::zero(), |sum, &(_, w)| sum + DoubleDouble::from(w));
        if (sum.to_f64() - 1.0).abs() > WEIGHT_SUM_TOLERANCE {
            return Err(DistributionError::Sum { sum: sum.to_f64(), tolerance: WEIGHT_SUM_TOLERANCE });
        }
        atoms.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut distribution = Self { depths: Vec::new(), weights: Vec::new() };
        for (z, w) in atoms {
            let w = DoubleDouble::from(w) / sum;
            match (distribution.depths.last(), distribution.weights.last_mut()) {
                (Some(&last), Some(weight)) if last == z => *weight = *weight + w,
                _ => {
                    distribution.depths.push(z);
                    distribution.weights.push(w);
                }
            }
        }
        Ok(distribution)
    }

    /// Depths, ascending.
    pub fn depths(&self) -> &[f64] {
        &self.depths
    }

    /// Weights in the order of the depths, to double-double precision.
    pub fn weights(&self) -> &[DoubleDouble] {
        &self.weights
    }

    /// F_Z(z) = Z(depth < z): the value of percentage-closer filtering, left-continuous.
    pub fn cdf(&self, z: f64) -> f64 {
        self.mass(|depth| depth < z)
    }

    /// Z(depth <= z).
    pub fn cdf_inclusive(&self, z: f64) -> f64 {
        self.mass(|depth| depth <= z)
    }

    fn mass(&self, inside: impl Fn(f64) -> bool) -> f64 {
        let atoms = self.depths.iter().zip(&self.weights);
        let sum = atoms.filter(|(z, _)| inside(**z)).fold(DoubleDouble::zero(), |sum, (_, &w)| sum + w);
        sum.to_f64().min(1.0)
    }

    /// E_Z(b), length m, in the given arithmetic (the weights are rounded to it first).
    pub fn moments<T: Field>(&self, basis: &Basis) -> Vec<T> {
        let mut moments = vec![T::from_f64(0.0); basis.len()];
        for (&z, &w) in self.depths.iter().zip(&self.weights) {
            let weight = T::from_double_double(w);
            for (moment, function) in moments.iter_mut().zip(basis.functions()) {
                *moment = *moment + weight * function.evaluate(T::from_f64(z));
            }
        }
        moments
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cdf_is_left_continuous_and_atoms_are_merged() {
        let z = DepthDistribution::new(&[0.7, 0.2, 0.7, 0.5], &[0.25, 0.5, 0.25, 0.0]).unwrap();
        assert_eq!(z.depths(), [0.2, 0.7]);
        assert_eq!((z.cdf(0.2), z.cdf_inclusive(0.2), z.cdf(0.7), z.cdf(0.8)), (0.0, 0.5, 0.5, 1.0));
        let moments: Vec<f64> = z.moments(&Basis::power(2));
        assert!((moments[0] - 0.45).abs() < 1e-16 && (moments[1] - 0.265).abs() < 1e-16);
    }

    #[test]
    fn impossible_distributions_are_errors_with_the_number() {
        let error = |depths: &[f64], weights: &[f64]| {
            DepthDistribution::new(depths, weights).unwrap_err().to_string()
        };
        assert!(error(&[], &[]).contains("at least one atom"));
        assert!(error(&[0.1], &[0.9]).contains("0.9"));
        assert!(error(&[0.1, f64::NAN], &[0.5, 0.5]).contains("depth 1 is NaN"));
        assert!(error(&[0.1, 0.2], &[1.5, -0.5]).contains("-0.5"));
        assert!(error(&[0.1, 0.2], &[1.0]).contains("2 depths but 1 weights"));
    }
}
