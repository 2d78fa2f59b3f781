//! A basis of the linear program with its inverse, and the vertices that are kept for one z_f.

use super::lanes::Lanes;
use super::support::{LANES, SupportColumns};

/// Index of an artificial column.
pub(super) const ARTIFICIAL: u16 = u16::MAX;

/// Rows, padded to whole vectors: K vectors of lanes hold R rows.
pub(super) type Rows<V, const K: usize> = [V; K];

/// R basic columns.
#[derive(Clone, Copy)]
pub(super) struct Vertex<V: Lanes, const R: usize, const K: usize> {
    pub(super) index: [u16; R],
    /// Column i of the inverse of the matrix of basic columns; its row r gives the weight of column `index[r]`.
    pub(super) inverse: [Rows<V, K>; R],
    /// y = p_B B^-1.
    pub(super) dual: [f64; R],
}

impl<V: Lanes, const R: usize, const K: usize> Vertex<V, R, K> {
    /// Artificial columns with the signs of the moments: their weights are the moments' absolute values.
    #[inline(always)]
    pub(super) fn artificial(b: &[f64; R]) -> Self {
        let mut inverse = [[V::zero(); K]; R];
        for i in 0..R {
            let mut column = [[0.0; LANES]; K];
            column[i / LANES][i % LANES] = if b[i] < 0.0 { -1.0 } else { 1.0 };
            inverse[i] = load(&column);
        }
        Self { index: [ARTIFICIAL; R], inverse, dual: [0.0; R] }
    }

    /// B^-1 v: weights of the basic columns for moments, or those that make up another column.
    #[inline(always)]
    pub(super) fn solve(&self, v: &[f64]) -> Rows<V, K> {
        let mut sum = [V::zero(); K];
        for i in 0..R {
            let factor = V::splat(v[i]);
            for k in 0..K {
                sum[k] = self.inverse[i][k].mul_add(factor, sum[k]);
            }
        }
        sum
    }

    /// Row r of the inverse.
    #[inline(always)]
    pub(super) fn row(&self, r: usize) -> [f64; R] {
        let mut row = [0.0; R];
        for i in 0..R {
            row[i] = self.inverse[i][r / LANES].lane(r);
        }
        row
    }

    /// The row with the most negative weight relative to the size of its row of the inverse, if that exceeds what
    /// rounding can do.
    #[inline(always)]
    pub(super) fn negative_row(&self, weights: &Rows<V, K>, tolerance: f64) -> Option<usize> {
        let mut worst = (-tolerance, None);
        for k in 0..K {
            // Rows of padding have size 0: 0 over the smallest number is 0.
            let mut size = V::splat(f64::MIN_POSITIVE);
            for i in 0..R {
                size = size.add(self.inverse[i][k].abs());
            }
            let (least, lane) = weights[k].div(size).least();
            if least < worst.0 {
                worst = (least, Some(k * LANES + lane));
            }
        }
        worst.1
    }

    /// Replaces the basic column of a row by one with reduced cost `slack`; `direction` is B^-1 times it.
    #[inline(always)]
    pub(super) fn replace(
        &mut self,
        row: usize,
        entering: usize,
        direction: &Rows<V, K>,
        slack: f64,
    ) -> Option<()> {
        let pivot = direction[row / LANES].lane(row);
        if !pivot.is_normal() {
            return None;
        }
        let inverse = 1.0 / pivot;
        let theta = slack * inverse;
        let mut selected = [[0.0; LANES]; K];
        selected[row / LANES][row % LANES] = 1.0;
        let selected = load::<V, K>(&selected);
        let half = V::splat(0.5);
        for i in 0..R {
            let old = self.inverse[i][row / LANES].lane(row);
            self.dual[i] = theta.mul_add(old, self.dual[i]);
            let scaled = V::splat(old * inverse);
            for k in 0..K {
                let moved = direction[k].neg_mul_add(scaled, self.inverse[i][k]);
                self.inverse[i][k] = half.where_less(selected[k], scaled, moved);
            }
        }
        self.index[row] = entering as u16;
        Some(())
    }

    /// y = p_B B^-1: the sum of the rows of columns in front of z_f.
    #[inline(always)]
    pub(super) fn price(&mut self, step: u16) {
        self.dual = self.rows_where(|index| index < step);
    }

    /// Sum of the rows whose columns satisfy a condition.
    #[inline(always)]
    pub(super) fn rows_where(&self, holds: impl Fn(u16) -> bool) -> [f64; R] {
        let mut chosen = [[0.0; LANES]; K];
        for r in 0..R {
            chosen[r / LANES][r % LANES] = if holds(self.index[r]) { 1.0 } else { 0.0 };
        }
        let chosen = load::<V, K>(&chosen);
        let mut sums = [0.0; R];
        for i in 0..R {
            let mut products = [0.0; LANES];
            let mut sum = 0.0;
            for k in 0..K {
                chosen[k].mul(self.inverse[i][k]).store(&mut products);
                sum += ((products[0] + products[1]) + (products[2] + products[3]))
                    + ((products[4] + products[5]) + (products[6] + products[7]));
            }
            sums[i] = sum;
        }
        sums
    }

    /// Inverse from the columns themselves (Gauss-Jordan elimination with row exchanges).
    ///
    /// The transposed matrix has the basic columns as rows, as they are stored, and its inverse has the columns of the
    /// inverse as rows, as they are stored here.
    #[inline(always)]
    pub(super) fn invert(&mut self, columns: &SupportColumns) -> Option<()> {
        let mut matrix = [[[0.0; LANES]; K]; R];
        let mut identity = [[[0.0; LANES]; K]; R];
        for r in 0..R {
            let column = columns.column(usize::from(self.index[r]));
            for k in 0..K {
                matrix[r][k].copy_from_slice(&column[k * LANES..(k + 1) * LANES]);
            }
            identity[r][r / LANES][r % LANES] = 1.0;
        }
        for c in 0..R {
            let mut best = c;
            for i in c + 1..R {
                if matrix[i][c / LANES][c % LANES].abs() > matrix[best][c / LANES][c % LANES].abs() {
                    best = i;
                }
            }
            if best != c {
                matrix.swap(c, best);
                identity.swap(c, best);
            }
            let pivot = matrix[c][c / LANES][c % LANES];
            if !pivot.is_normal() {
                return None;
            }
            let factor = V::splat(1.0 / pivot);
            let mut left = [V::zero(); K];
            let mut right = [V::zero(); K];
            for k in 0..K {
                left[k] = V::load(&matrix[c][k]).mul(factor);
                right[k] = V::load(&identity[c][k]).mul(factor);
                left[k].store(&mut matrix[c][k]);
                right[k].store(&mut identity[c][k]);
            }
            for i in 0..R {
                if i != c {
                    let factor = V::splat(matrix[i][c / LANES][c % LANES]);
                    for k in 0..K {
                        left[k].neg_mul_add(factor, V::load(&matrix[i][k])).store(&mut matrix[i][k]);
                        right[k].neg_mul_add(factor, V::load(&identity[i][k])).store(&mut identity[i][k]);
                    }
                }
            }
        }
        for i in 0..R {
            self.inverse[i] = load(&identity[i]);
        }
        Some(())
    }
}

/// Vectors from arrays.
#[inline(always)]
pub(super) fn load<V: Lanes, const K: usize>(values: &[[f64; LANES]; K]) -> Rows<V, K> {
    let mut rows = [V::zero(); K];
    for k in 0..K {
        rows[k] = V::load(&values[k]);
    }
    rows
}

/// Vertices of the dual polytope of one z_f.
pub(super) struct Cache<V: Lanes, const R: usize, const K: usize> {
    pub(super) vertices: Vec<Vertex<V, R, K>>,
    /// Dual vectors in groups of lanes.
    duals: Vec<[[f64; LANES]; R]>,
    /// What each vertex lacks, rounding included; and its number in the solution, if a bound used it.
    pub(super) lacking: Vec<f64>,
    pub(super) used: Vec<u32>,
}

/// Not (yet) part of a solution.
pub(super) const UNUSED: u32 = u32::MAX;

/// Vertices kept for one z_f. Beyond it the search for the best costs more than the pivots that it saves.
const MAX_CACHED: usize = 1024;

impl<V: Lanes, const R: usize, const K: usize> Cache<V, R, K> {
    pub(super) fn new() -> Self {
        Self { vertices: Vec::new(), duals: Vec::new(), lacking: Vec::new(), used: Vec::new() }
    }

    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.vertices.clear();
        self.duals.clear();
        self.lacking.clear();
        self.used.clear();
    }

    /// Adds a vertex and returns its place; a full cache replaces its newest entry.
    #[inline(always)]
    pub(super) fn insert(&mut self, vertex: &Vertex<V, R, K>, lacking: f64) -> usize {
        let place = self.vertices.len().min(MAX_CACHED - 1);
        let (group, lane) = (place / LANES, place % LANES);
        if group == self.duals.len() {
            self.duals.push([[0.0; LANES]; R]);
        }
        if place == self.vertices.len() {
            self.vertices.push(*vertex);
            self.lacking.push(lacking);
            self.used.push(UNUSED);
        } else {
            self.vertices[place] = *vertex;
            self.lacking[place] = lacking;
            self.used[place] = UNUSED;
        }
        for i in 0..R {
            self.duals[group][i][lane] = vertex.dual[i];
        }
        place
    }

    /// The vertex with the largest y . b.
    #[inline(always)]
    pub(super) fn best(&self, b: &[f64; R]) -> Option<usize> {
        let (_, place) = largest_product::<V, R>(&self.duals, b);
        // Lanes beyond the last vertex hold y = 0, which is feasible but no vertex.
        Some(place.min(self.vertices.len().checked_sub(1)?))
    }
}

/// Largest y . a over columns in groups of lanes, and its place.
#[inline(always)]
pub(super) fn largest_product<V: Lanes, const R: usize>(
    columns: &[[[f64; LANES]; R]],
    y: &[f64; R],
) -> (f64, usize) {
    let mut factors = [V::zero(); R];
    for i in 0..R {
        factors[i] = V::splat(-y[i]);
    }
    let mut least = V::splat(f64::INFINITY);
    let mut group = V::zero();
    for (number, columns) in columns.iter().enumerate() {
        let mut value = V::zero();
        for i in 0..R {
            value = factors[i].mul_add(V::load(&columns[i]), value);
        }
        group = value.where_less(least, V::splat(number as f64), group);
        least = value.where_less(least, value, least);
    }
    let (least, lane) = least.least();
    (-least, group.lane(lane) as usize * LANES + lane)
}
