//! The matrix B of a moment vector, which is positive semi-definite exactly if the vector is valid (MSM15 section 4.1).

use crate::error::QuantizationError;
use moment_problem::Basis;

/// How B follows from b, for the bases with a closed form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// B_ij = b_(i+j), b_0 = 1: Hankel, depths on the line.
    Power,
    /// Means of the products of 1, cos and sin of 2 pi z: the trigonometric moment problem of MSM15's TMSM.
    Trigonometric4,
}

/// The matrix of one basis; rows and columns belong to functions phi_0 = 1, phi_1, ..., B = E\[phi phi^T\].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MomentMatrix {
    kind: Kind,
    order: usize,
}

/// Largest number of rows: 16 power moments.
const MAX_ROWS: usize = 9;

impl MomentMatrix {
    /// The matrix of an even number of power moments, or of `trig:2`.
    ///
    /// # Errors
    /// [`QuantizationError::Parameter`] for other bases.
    pub fn new(basis: &Basis) -> Result<Self, QuantizationError> {
        let order = basis.len();
        if basis.is_trigonometric4() {
            return Ok(Self { kind: Kind::Trigonometric4, order });
        }
        if basis.power_order().is_some_and(|m| m % 2 == 0) {
            return Ok(Self { kind: Kind::Power, order });
        }
        let reason = "a moment matrix exists for power:M with an even M and for trig:2".to_owned();
        Err(QuantizationError::Parameter { key: "basis", value: basis.to_string(), reason })
    }

    /// Number of moments.
    pub fn order(&self) -> usize {
        self.order
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.order / 2 + 1
    }

    /// An entry of B.
    pub fn entry(&self, b: &[f64], i: usize, j: usize) -> f64 {
        if i + j == 0 {
            return 1.0;
        }
        match self.kind {
            Kind::Power => b[i + j - 1],
            // b holds the means of sin x, cos x, sin 2x, cos 2x; rows are 1, cos x, sin x.
            Kind::Trigonometric4 if i + j == 1 => b[1],
            Kind::Trigonometric4 if i == j => 0.5 + (1.5 - i as f64) * b[3],
            Kind::Trigonometric4 if i + j == 2 => b[0],
            Kind::Trigonometric4 => 0.5 * b[2],
        }
    }

    /// Functions phi at a depth.
    pub fn functions(&self, z: f64) -> Vec<f64> {
        match self.kind {
            Kind::Power => (0..self.rows()).map(|i| z.powi(i as i32)).collect(),
            Kind::Trigonometric4 => {
                let (sine, cosine) = (std::f64::consts::TAU * z).sin_cos();
                vec![1.0, cosine, sine]
            }
        }
    }

    /// Pivots of B = L D L^T, until one is not positive.
    fn pivots(&self, b: &[f64], mut each: impl FnMut(f64)) -> bool {
        let n = self.rows();
        let mut lower = [[0.0f64; MAX_ROWS]; MAX_ROWS];
        let mut pivots = [0.0f64; MAX_ROWS];
        for i in 0..n {
            for j in 0..=i {
                let mut value = self.entry(b, i, j);
                for k in 0..j {
                    value -= lower[i][k] * lower[j][k] * pivots[k];
                }
                if j < i {
                    lower[i][j] = value / pivots[j];
                } else {
                    pivots[i] = value;
                }
            }
            // A NaN is not positive either.
            if pivots[i].is_nan() || pivots[i] <= 0.0 {
                return false;
            }
            each(pivots[i]);
        }
        true
    }

    /// Whether B is positive definite, so that Problem 1 of MSM15 has a solution for b.
    pub fn is_valid(&self, b: &[f64]) -> bool {
        self.pivots(b, |_| {})
    }

    /// ln det B, or -infinity for a vector that is not valid.
    #[cfg(test)]
    pub(crate) fn ln_determinant(&self, b: &[f64]) -> f64 {
        let mut sum = 0.0;
        if self.pivots(b, |pivot| sum += pivot.ln()) { sum } else { f64::NEG_INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use moment_problem::DepthDistribution;

    #[test]
    fn matrices_are_means_of_products() {
        let z = DepthDistribution::new(&[0.1, 0.35, 0.6, 0.9], &[0.4, 0.3, 0.2, 0.1]).unwrap();
        for basis in [Basis::power(4), Basis::power(6), Basis::trigonometric(2)] {
            let matrix = MomentMatrix::new(&basis).unwrap();
            let b: Vec<f64> = z.moments(&basis);
            for i in 0..matrix.rows() {
                for j in 0..matrix.rows() {
                    let terms = z.depths().iter().zip(z.weights()).map(|(&depth, &weight)| {
                        let phi = matrix.functions(depth);
                        weight.to_f64() * phi[i] * phi[j]
                    });
                    assert!((terms.sum::<f64>() - matrix.entry(&b, i, j)).abs() < 1e-14, "{basis} {i} {j}");
                }
            }
            assert!(matrix.is_valid(&b) && matrix.ln_determinant(&b).is_finite());
        }
        let matrix = MomentMatrix::new(&Basis::power(2)).unwrap();
        // A variance of 0.05, and one of -0.05.
        assert!((matrix.ln_determinant(&[0.5, 0.3]) - 0.05f64.ln()).abs() < 1e-12);
        assert!(!matrix.is_valid(&[0.5, 0.2]) && !matrix.is_valid(&[0.5, f64::NAN]));
        assert!(MomentMatrix::new(&Basis::power(3)).is_err());
        assert!(MomentMatrix::new(&Basis::trigonometric(1)).is_err());
    }
}
