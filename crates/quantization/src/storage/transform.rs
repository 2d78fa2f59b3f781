//! Affine transforms of moment vectors.

use crate::error::QuantizationError;
use moment_problem::arithmetic::{DoubleDouble, Field, Real};
use moment_problem::dense::Factors;

/// theta(b) = matrix b + offset (MSM15 section 4.3), with its inverse.
#[derive(Clone, Debug, PartialEq)]
pub struct AffineTransform {
    order: usize,
    /// Row-major.
    matrix: Vec<f64>,
    offset: Vec<f64>,
    /// Row-major; computed in double-double and rounded once.
    inverse: Vec<f64>,
    log2_determinant: f64,
}

impl AffineTransform {
    /// Takes a row-major matrix and an offset.
    ///
    /// # Errors
    /// [`QuantizationError::Length`], and [`QuantizationError::NotInvertible`] for a singular matrix or numbers that
    /// are not finite.
    pub fn new(matrix: Vec<f64>, offset: Vec<f64>) -> Result<Self, QuantizationError> {
        let order = offset.len();
        if matrix.len() != order * order || order == 0 {
            let (expected, got) = (order * order, matrix.len());
            return Err(QuantizationError::Length { what: "matrix of a transform", expected, got });
        }
        let singular = |determinant: f64| QuantizationError::NotInvertible { rows: order, determinant };
        if matrix.iter().chain(&offset).any(|value| !value.is_finite()) {
            return Err(singular(f64::NAN));
        }
        let factors = Factors::new(order, |i, j| DoubleDouble::from(matrix[i * order + j]))
            .ok_or_else(|| singular(0.0))?;
        let columns: Vec<Vec<DoubleDouble>> = (0..order)
            .map(|j| {
                let unit = |i: usize| DoubleDouble::from(f64::from(u8::from(i == j)));
                factors.solve(&(0..order).map(unit).collect::<Vec<_>>())
            })
            .collect();
        let inverse: Vec<f64> = (0..order * order).map(|k| columns[k % order][k / order].to_f64()).collect();
        let log2_determinant = factors.pivots().map(|pivot| log2(pivot.abs())).sum::<f64>();
        if !log2_determinant.is_finite() || inverse.iter().any(|value| !value.is_finite()) {
            return Err(singular(log2_determinant.exp2()));
        }
        Ok(Self { order, matrix, offset, inverse, log2_determinant })
    }

    /// b itself.
    ///
    /// # Panics
    /// For order 0.
    pub fn identity(order: usize) -> Self {
        assert!(order > 0, "a transform of order 0");
        let matrix: Vec<f64> =
            (0..order * order).map(|k| f64::from(u8::from(k / order == k % order))).collect();
        Self { order, inverse: matrix.clone(), matrix, offset: vec![0.0; order], log2_determinant: 0.0 }
    }

    /// Each value by itself: factor times value + offset.
    ///
    /// # Errors
    /// As [`AffineTransform::new`].
    pub fn diagonal(factors: Vec<f64>, offset: Vec<f64>) -> Result<Self, QuantizationError> {
        let m = factors.len();
        let mut matrix = vec![0.0; m * m];
        for (i, factor) in factors.into_iter().enumerate() {
            matrix[i * m + i] = factor;
        }
        Self::new(matrix, offset)
    }

    /// Number m of moments.
    pub fn order(&self) -> usize {
        self.order
    }

    /// The matrix, row-major.
    pub fn matrix(&self) -> &[f64] {
        &self.matrix
    }

    /// What is added to the product.
    pub fn offset(&self) -> &[f64] {
        &self.offset
    }

    /// The matrix' inverse, row-major.
    pub fn inverse(&self) -> &[f64] {
        &self.inverse
    }

    /// A row of the matrix.
    ///
    /// # Panics
    /// Beyond the last row.
    pub fn row(&self, index: usize) -> &[f64] {
        &self.matrix[index * self.order..(index + 1) * self.order]
    }

    /// log2 |det theta|: the bits of entropy that m stored numbers gain (MSM15 Proposition 6).
    pub fn log2_determinant(&self) -> f64 {
        self.log2_determinant
    }

    /// matrix b + offset. `out` has as many entries as `b`.
    pub fn apply(&self, b: &[f64], out: &mut [f64]) {
        for ((value, row), &offset) in
            out.iter_mut().zip(self.matrix.chunks_exact(self.order)).zip(&self.offset)
        {
            *value = row.iter().zip(b).fold(offset, |sum, (m, b)| sum + m * b);
        }
    }

    /// The b that [`AffineTransform::apply`] maps to `stored`.
    pub fn invert(&self, stored: &[f64], out: &mut [f64]) {
        for (value, row) in out.iter_mut().zip(self.inverse.chunks_exact(self.order)) {
            let terms = row.iter().zip(stored).zip(&self.offset);
            *value = terms.fold(0.0, |sum, ((m, s), o)| sum + m * (s - o));
        }
    }
}

/// log2 of a number that machine numbers may be too coarse for.
fn log2(value: DoubleDouble) -> f64 {
    value.ln().to_f64() / std::f64::consts::LN_2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_undoes_the_transform() {
        let theta = AffineTransform::new(vec![1.0, 0.0, 4.0, -4.0], vec![0.0, 0.25]).unwrap();
        assert_eq!(theta.log2_determinant(), 2.0);
        let (mut stored, mut back) = ([0.0; 2], [0.0; 2]);
        theta.apply(&[0.3, 0.2], &mut stored);
        assert!((stored[0] - 0.3).abs() < 1e-15 && (stored[1] - 0.65).abs() < 1e-15, "{stored:?}");
        theta.invert(&stored, &mut back);
        assert!((back[0] - 0.3).abs() < 1e-15 && (back[1] - 0.2).abs() < 1e-15, "{back:?}");
        assert_eq!(AffineTransform::identity(3).inverse(), AffineTransform::identity(3).matrix());
    }

    #[test]
    fn useless_matrices_are_errors() {
        assert!(AffineTransform::new(vec![1.0, 2.0, 2.0, 4.0], vec![0.0; 2]).is_err());
        assert!(AffineTransform::new(vec![1.0, f64::NAN, 2.0, 4.0], vec![0.0; 2]).is_err());
        let error = AffineTransform::new(vec![1.0; 3], vec![0.0; 2]).unwrap_err().to_string();
        assert!(error.contains('3') && error.contains('4'), "{error}");
    }
}
