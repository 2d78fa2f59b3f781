//! Small dense linear systems over any [`Real`] (nalgebra's factorisations need a complex field, which
//! double-double is not).

use crate::arithmetic::Real;

/// L U factors of a square matrix with row exchanges.
pub struct Factors<R> {
    size: usize,
    /// Row-major; L below the diagonal (unit), U on and above it.
    entries: Vec<R>,
    /// `rows[i]` is the original row that ended at i.
    rows: Vec<usize>,
}

impl<R: Real> Factors<R> {
    /// Factors the matrix given by `entry(row, column)`; `None` if a pivot vanishes.
    pub fn new(size: usize, entry: impl Fn(usize, usize) -> R) -> Option<Self> {
        let mut entries: Vec<R> = (0..size * size).map(|i| entry(i / size, i % size)).collect();
        let mut rows: Vec<usize> = (0..size).collect();
        for k in 0..size {
            let mut best = k;
            for i in k + 1..size {
                if entries[i * size + k].abs() > entries[best * size + k].abs() {
                    best = i;
                }
            }
            if best != k {
                rows.swap(best, k);
                for j in 0..size {
                    entries.swap(best * size + j, k * size + j);
                }
            }
            let pivot = entries[k * size + k];
            if pivot == R::zero() || !pivot.is_finite() {
                return None;
            }
            for i in k + 1..size {
                let factor = entries[i * size + k] / pivot;
                entries[i * size + k] = factor;
                for j in k + 1..size {
                    entries[i * size + j] = entries[i * size + j] - factor * entries[k * size + j];
                }
            }
        }
        Some(Self { size, entries, rows })
    }

    fn at(&self, i: usize, j: usize) -> R {
        self.entries[i * self.size + j]
    }

    /// Pivots: their product is the determinant up to its sign.
    pub fn pivots(&self) -> impl Iterator<Item = R> + '_ {
        (0..self.size).map(|i| self.at(i, i))
    }

    /// x with A x = b.
    pub fn solve(&self, b: &[R]) -> Vec<R> {
        let mut x: Vec<R> = self.rows.iter().map(|&row| b[row]).collect();
        for i in 0..self.size {
            for j in 0..i {
                x[i] = x[i] - self.at(i, j) * x[j];
            }
        }
        for i in (0..self.size).rev() {
            for j in i + 1..self.size {
                x[i] = x[i] - self.at(i, j) * x[j];
            }
            x[i] = x[i] / self.at(i, i);
        }
        x
    }

    /// y with A^T y = c.
    pub(crate) fn solve_transposed(&self, c: &[R]) -> Vec<R> {
        let mut t = c.to_vec();
        for i in 0..self.size {
            for j in 0..i {
                t[i] = t[i] - self.at(j, i) * t[j];
            }
            t[i] = t[i] / self.at(i, i);
        }
        for i in (0..self.size).rev() {
            for j in i + 1..self.size {
                t[i] = t[i] - self.at(j, i) * t[j];
            }
        }
        let mut y = vec![R::zero(); self.size];
        for (&row, value) in self.rows.iter().zip(t) {
            y[row] = value;
        }
        y
    }
}

/// Inner product.
pub fn dot<R: Real>(a: &[R], b: &[R]) -> R {
    a.iter().zip(b).fold(R::zero(), |sum, (&x, &y)| sum + x * y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_systems_are_solved() {
        let a = [[0.0, 2.0, 1.0], [1.0, -1.0, 3.0], [4.0, 0.5, -2.0]];
        let factors = Factors::new(3, |i, j| a[i][j]).unwrap();
        let x = factors.solve(&[1.0, 2.0, 3.0]);
        let y = factors.solve_transposed(&[1.0, 2.0, 3.0]);
        for (i, row) in a.iter().enumerate() {
            let product: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
            let transposed: f64 = a.iter().zip(&y).map(|(row, y)| row[i] * y).sum();
            let expected = (i + 1) as f64;
            assert!((product - expected).abs() < 1e-14 && (transposed - expected).abs() < 1e-14);
        }
        assert!(Factors::new(2, |_, _| 1.0).is_none());
    }
}
