//! The basis matrix without its row of ones, one a lane.

use super::lanes::{Lanes, Mask, Quad, unrolled};

/// A pivot below this is none: its reciprocal would overflow.
const SMALLEST_PIVOT: f64 = 1e-300;

/// When a weight counts as negative.
#[derive(Clone, Copy, Debug)]
pub(super) struct WeightTolerances {
    /// Roundings that it may be negative by, times the size of its row of the inverse. An absolute tolerance accepts bases whose
    /// weight is as small as it: G then is wrong by that weight times the size of a dual vector, which may be 1e12.
    pub(super) relative: f64,
    /// The same for weights whose row has no size: two roundings of the mass 1.
    pub(super) absolute: f64,
    /// A weight above this times the size of its row is positive whatever rounding did; of what lies between, nobody knows in
    /// double precision.
    pub(super) doubt: f64,
}

impl WeightTolerances {
    pub(super) const DEFAULT: Self = Self { relative: 5e-14, absolute: 3e-16, doubt: 5e-15 };
}

/// What is known of the signs of weights.
pub(super) struct Signs<M> {
    /// One is negative, or no number, or the matrix is singular.
    pub(super) negative: M,
    /// One may be negative.
    pub(super) doubtful: M,
}

/// L U factors of C = \[a(x_1) - a(x_0) | ... | a(x_D) - a(x_(D-1))\], D x D with row exchanges, and a(x_0).
///
/// Weights of mass 1 with moments b: C W = b - a(x_0), w_0 = 1 - W_0, w_r = W_(r-1) - W_r, w_D = W_(D-1). Dual vectors of
/// costs c at the basic columns: C^T y = (c_1 - c_0, ...), y_0 = c_0 - y . a(x_0).
#[derive(Clone, Copy)]
pub(super) struct Factors<V: Lanes, const D: usize> {
    /// L below the diagonal (unit), U on and above it.
    entries: [[V; D]; D],
    /// Of the diagonal.
    reciprocals: [V; D],
    pub(super) base: [V; D],
    /// Whether row i was exchanged with row k < i, by k and i.
    exchanges: [[V::Mask; D]; D],
    pub(super) singular: V::Mask,
}

#[inline(always)]
fn exchange<V: Lanes>(mask: V::Mask, a: &mut V, b: &mut V) {
    let (x, y) = (*a, *b);
    *a = V::select(mask, y, x);
    *b = V::select(mask, x, y);
}

impl<V: Lanes, const D: usize> Factors<V, D> {
    /// For R = D + 1 ascending columns a lane.
    #[inline(always)]
    pub(super) fn new<const R: usize>(table: &[Quad], x: &[V; R]) -> Self {
        let none = V::Mask::of(0);
        let mut f = Self {
            entries: [[V::zero(); D]; D],
            reciprocals: [V::zero(); D],
            base: [V::zero(); D],
            exchanges: [[none; D]; D],
            singular: none,
        };
        let mut before = V::gather(table, x[0]);
        unrolled!(i < D, {
            f.base[i] = before[i];
        });
        unrolled!(r < D, {
            let column = V::gather(table, x[r + 1]);
            unrolled!(i < D, {
                f.entries[i][r] = column[i] - before[i];
            });
            before = column;
        });
        // The last one is read by nobody.
        let _ = before;
        unrolled!(k < D, {
            unrolled!(i < D, {
                if i > k {
                    let larger = f.entries[k][k].abs().less(f.entries[i][k].abs());
                    f.exchanges[k][i] = larger;
                    unrolled!(j < D, {
                        let (mut a, mut b) = (f.entries[k][j], f.entries[i][j]);
                        exchange(larger, &mut a, &mut b);
                        f.entries[k][j] = a;
                        f.entries[i][j] = b;
                    });
                }
            });
            f.singular = f.singular | !f.entries[k][k].abs().at_least(V::splat(SMALLEST_PIVOT));
            let reciprocal = V::splat(1.0) / f.entries[k][k];
            f.reciprocals[k] = reciprocal;
            unrolled!(i < D, {
                if i > k {
                    let factor = f.entries[i][k] * reciprocal;
                    f.entries[i][k] = factor;
                    unrolled!(j < D, {
                        if j > k {
                            f.entries[i][j] = factor.neg_mul_add(f.entries[k][j], f.entries[i][j]);
                        }
                    });
                }
            });
        });
        f
    }

    /// C^-1 v.
    #[inline(always)]
    pub(super) fn solve(&self, v: &mut [V; D]) {
        unrolled!(k < D, {
            unrolled!(i < D, {
                if i > k {
                    let (mut a, mut b) = (v[k], v[i]);
                    exchange(self.exchanges[k][i], &mut a, &mut b);
                    v[k] = a;
                    v[i] = b;
                }
            });
        });
        unrolled!(k < D, {
            unrolled!(i < D, {
                if i > k {
                    v[i] = self.entries[i][k].neg_mul_add(v[k], v[i]);
                }
            });
        });
        unrolled!(c < D, {
            let k = D - 1 - c;
            unrolled!(j < D, {
                if j > k {
                    v[k] = self.entries[k][j].neg_mul_add(v[j], v[k]);
                }
            });
            v[k] = v[k] * self.reciprocals[k];
        });
    }

    /// C^-T v.
    #[inline(always)]
    pub(super) fn solve_transposed(&self, v: &mut [V; D]) {
        unrolled!(k < D, {
            unrolled!(j < D, {
                if j < k {
                    v[k] = self.entries[j][k].neg_mul_add(v[j], v[k]);
                }
            });
            v[k] = v[k] * self.reciprocals[k];
        });
        unrolled!(c < D, {
            let k = D - 1 - c;
            unrolled!(i < D, {
                if i > k {
                    v[k] = self.entries[i][k].neg_mul_add(v[i], v[k]);
                }
            });
        });
        unrolled!(c < D, {
            let k = D - 1 - c;
            unrolled!(e < D, {
                let i = D - 1 - e;
                if i > k {
                    let (mut a, mut b) = (v[k], v[i]);
                    exchange(self.exchanges[k][i], &mut a, &mut b);
                    v[k] = a;
                    v[i] = b;
                }
            });
        });
    }

    /// Differences that make weights of C^-1 times something.
    #[inline(always)]
    fn spread<const R: usize>(total: f64, v: &[V; D]) -> [V; R] {
        let mut w = [V::zero(); R];
        w[0] = V::splat(total) - v[0];
        unrolled!(r < D, {
            if r > 0 {
                w[r] = v[r - 1] - v[r];
            }
        });
        w[D] = v[D - 1];
        w
    }

    /// Weights of mass 1 with moments b.
    #[inline(always)]
    pub(super) fn weights<const R: usize>(&self, b: &[V; 4]) -> [V; R] {
        let mut v = [V::zero(); D];
        unrolled!(i < D, {
            v[i] = b[i] - self.base[i];
        });
        self.solve(&mut v);
        Self::spread(1.0, &v)
    }

    /// The signs of weights.
    #[inline(always)]
    pub(super) fn signs<const R: usize>(&self, w: &[V; R], tolerances: WeightTolerances) -> Signs<V::Mask> {
        // One vector of signs estimates the size of all rows.
        let mut v = [V::splat(1.0); D];
        v[1 % D] = V::splat(-1.0);
        self.solve(&mut v);
        let size: [V; R] = Self::spread(0.0, &v);
        let WeightTolerances { relative, absolute, doubt } = tolerances;
        let (mut negative, mut doubtful) = (self.singular, self.singular);
        unrolled!(r < R, {
            let size = size[r].abs();
            negative = negative | !w[r].at_least(V::splat(relative).neg_mul_add(size, V::splat(-absolute)));
            doubtful = doubtful | !w[r].at_least(V::splat(doubt) * size);
        });
        Signs { negative, doubtful }
    }

    /// (y_0, y) of costs at the basic columns.
    #[inline(always)]
    pub(super) fn dual<const R: usize>(&self, costs: &[V; R]) -> (V, [V; D]) {
        let mut y = [V::zero(); D];
        unrolled!(r < D, {
            y[r] = costs[r + 1] - costs[r];
        });
        self.solve_transposed(&mut y);
        let mut y0 = costs[0];
        unrolled!(i < D, {
            y0 = y[i].neg_mul_add(self.base[i], y0);
        });
        (y0, y)
    }
}
