//! Double-double with fused products, for functions that are compiled for processors that have these; elsewhere the same bits,
//! slowly. [`DoubleDouble`] itself has to do without.

use crate::arithmetic::DoubleDouble;

/// Rows of the largest system.
pub(super) const MAX_RANK: usize = super::MAX_FUNCTIONS + 1;

/// An unevaluated sum, as [`DoubleDouble`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Pair {
    pub(super) high: f64,
    pub(super) low: f64,
}

impl From<DoubleDouble> for Pair {
    #[inline(always)]
    fn from(value: DoubleDouble) -> Self {
        Self { high: value.to_f64(), low: value.low() }
    }
}

impl Pair {
    #[inline(always)]
    pub(super) fn of(high: f64) -> Self {
        Self { high, low: 0.0 }
    }

    /// For |a| >= |b|.
    #[inline(always)]
    fn fast_sum(a: f64, b: f64) -> Self {
        let high = a + b;
        Self { high, low: b - (high - a) }
    }

    #[inline(always)]
    pub(super) fn plus(self, other: Self) -> Self {
        let sum = self.high + other.high;
        let part = sum - self.high;
        let lost = (self.high - (sum - part)) + (other.high - part);
        Self::fast_sum(sum, lost + (self.low + other.low))
    }

    #[inline(always)]
    pub(super) fn times(self, other: Self) -> Self {
        let product = self.high * other.high;
        let lost = self.high.mul_add(other.high, -product);
        Self::fast_sum(product, lost + self.high.mul_add(other.low, self.low * other.high))
    }

    /// self - a b.
    #[inline(always)]
    fn minus_product(self, a: Self, b: Self) -> Self {
        let product = a.times(b);
        self.plus(Self { high: -product.high, low: -product.low })
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        let first = self.high / other.high;
        let rest = self.minus_product(other, Self::of(first));
        let second = rest.high / other.high;
        let rest = rest.minus_product(other, Self::of(second));
        Self::fast_sum(first, second).plus(Self::of(rest.high / other.high))
    }
}

/// A vector, zero beyond the rank.
pub(super) type Vector = [Pair; MAX_RANK];

/// L U factors of a square matrix with row exchanges, as [`Factors`](crate::dense::Factors) for any number.
pub(super) struct PairFactors {
    rank: usize,
    /// L below the diagonal (unit), U on and above it.
    entries: [Vector; MAX_RANK],
    /// `rows[i]` is the original row that ended at i.
    rows: [usize; MAX_RANK],
}

impl PairFactors {
    /// Of a matrix by rows; `None` if a pivot vanishes.
    #[inline(always)]
    pub(super) fn new(rank: usize, matrix: &[[f64; MAX_RANK]; MAX_RANK]) -> Option<Self> {
        let mut entries = [Vector::default(); MAX_RANK];
        for i in 0..rank {
            for j in 0..rank {
                entries[i][j] = Pair::of(matrix[i][j]);
            }
        }
        let mut rows = [0, 1, 2, 3, 4];
        for k in 0..rank {
            let mut best = k;
            for i in k + 1..rank {
                if entries[i][k].high.abs() > entries[best][k].high.abs() {
                    best = i;
                }
            }
            entries.swap(k, best);
            rows.swap(k, best);
            let pivot = entries[k][k];
            if pivot.high == 0.0 || !pivot.high.is_finite() {
                return None;
            }
            for i in k + 1..rank {
                let factor = entries[i][k].over(pivot);
                entries[i][k] = factor;
                for j in k + 1..rank {
                    entries[i][j] = entries[i][j].minus_product(factor, entries[k][j]);
                }
            }
        }
        Some(Self { rank, entries, rows })
    }

    /// x with A x = b.
    #[inline(always)]
    pub(super) fn solve(&self, b: &Vector) -> Vector {
        let mut x = Vector::default();
        for i in 0..self.rank {
            x[i] = b[self.rows[i]];
            for j in 0..i {
                x[i] = x[i].minus_product(self.entries[i][j], x[j]);
            }
        }
        for i in (0..self.rank).rev() {
            for j in i + 1..self.rank {
                x[i] = x[i].minus_product(self.entries[i][j], x[j]);
            }
            x[i] = x[i].over(self.entries[i][i]);
        }
        x
    }

    /// y with A^T y = c.
    #[inline(always)]
    pub(super) fn solve_transposed(&self, c: &Vector) -> Vector {
        let mut t = *c;
        for i in 0..self.rank {
            for j in 0..i {
                t[i] = t[i].minus_product(self.entries[j][i], t[j]);
            }
            t[i] = t[i].over(self.entries[i][i]);
        }
        let mut y = Vector::default();
        for i in (0..self.rank).rev() {
            for j in i + 1..self.rank {
                t[i] = t[i].minus_product(self.entries[j][i], t[j]);
            }
            y[self.rows[i]] = t[i];
        }
        y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dense::Factors;

    #[test]
    fn systems_are_solved_as_in_double_double() {
        let entry = |i: usize, j: usize| ((3 * i + 5 * j + i * j) as f64 * 0.7).sin();
        let matrix = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
        let (factors, others) = (
            PairFactors::new(5, &matrix).unwrap(),
            Factors::new(5, |i, j| DoubleDouble::from(entry(i, j))).unwrap(),
        );
        let right: Vec<DoubleDouble> = (0..5).map(|i| DoubleDouble::from(1.0 / (i + 3) as f64)).collect();
        let b: Vector = std::array::from_fn(|i| right[i].into());
        for (pairs, doubles) in [
            (factors.solve(&b), others.solve(&right)),
            (factors.solve_transposed(&b), others.solve_transposed(&right)),
        ] {
            for (pair, double) in pairs.iter().zip(doubles) {
                let difference = (DoubleDouble::sum(pair.high, pair.low) + -double).to_f64();
                assert!(difference.abs() < 1e-28 * double.to_f64().abs().max(1.0), "{pair:?} {double:?}");
            }
        }
        assert!(PairFactors::new(2, &[[1.0; 5]; 5]).is_none());
    }
}
