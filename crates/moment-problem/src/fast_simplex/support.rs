//! The finite support I of Algorithm 1 with the columns of the linear program over it.

use super::MAX_ROWS;
use crate::arithmetic::{DoubleDouble, Field, Real};
use crate::basis::BasisFunction;
use crate::dense::dot;
use crate::error::MomentError;
use serde::{Deserialize, Serialize};

/// Columns are priced in groups of so many, whatever the width of the machine's vectors, so that results do not depend
/// on it.
pub(super) const LANES: usize = 8;

/// Largest number of depths in a support: indices are stored in 16 bits.
const MAX_SUPPORT: usize = 1 << 15;

/// A row whose norm over the support falls by this factor under projection carries no information of its own. The
/// 4-subsets of the default family keep more than 2e-6.
pub(crate) const DEPENDENCE_TOLERANCE: f64 = 1e-12;

/// Functions sampled on a support to double-double precision: shared by all bases of a family.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct FunctionTable {
    depths: Vec<f64>,
    samples: Vec<Vec<DoubleDouble>>,
}

impl FunctionTable {
    /// Samples functions on ascending depths in \[0, 1\].
    ///
    /// # Errors
    /// [`MomentError::OutsideInterval`] for depths outside or out of order, [`MomentError::Unsupported`] for fewer
    /// than two or more than 32768, and a [`BasisError`](crate::BasisError) for a function that is not
    /// finite there.
    pub fn new(functions: &[BasisFunction], depths: &[f64]) -> Result<Self, MomentError> {
        if !(2..=MAX_SUPPORT).contains(&depths.len()) {
            let count = depths.len();
            return Err(MomentError::Unsupported(format!(
                "a support of {count} depths: it needs 2 to {MAX_SUPPORT}"
            )));
        }
        let mut before = f64::NEG_INFINITY;
        for (index, &z) in depths.iter().enumerate() {
            if !((0.0..=1.0).contains(&z) && z > before) {
                let name = format!("depth {index} of the support (ascending)");
                return Err(MomentError::OutsideInterval { name, value: z });
            }
            before = z;
        }
        let mut samples = Vec::new();
        for function in functions {
            let row: Vec<DoubleDouble> =
                depths.iter().map(|&z| function.evaluate(DoubleDouble::from(z))).collect();
            if let Some(index) = row.iter().position(|value| !value.to_f64().is_finite()) {
                let name = function.name().to_owned();
                return Err(crate::BasisError::NotFinite { name, z: depths[index] }.into());
            }
            samples.push(row);
        }
        Ok(Self { depths: depths.to_vec(), samples })
    }

    /// The ends of `cells` equal cells of \[0, 1\].
    pub fn uniform_depths(cells: usize) -> Vec<f64> {
        (0..=cells).map(|i| i as f64 / cells as f64).collect()
    }

    /// The support I.
    pub fn depths(&self) -> &[f64] {
        &self.depths
    }

    /// The functions on the support, row by row.
    pub(crate) fn samples(&self) -> &[Vec<DoubleDouble>] {
        &self.samples
    }
}

/// The matrix of Algorithm 1 over a finite support: column j holds the orthonormalised rows a(z_j).
///
/// Rows span 1, b_1, ..., b_m and are orthonormal over the support; they are computed in double-double and rounded
/// once. Functions that depend on earlier ones give no row.
#[derive(Clone, Debug)]
pub struct SupportColumns {
    depths: usize,
    rank: usize,
    padded: usize,
    /// Row-major in groups of lanes, `padded` values a row; beyond the support the last column is repeated.
    rows: Vec<[f64; LANES]>,
    /// Column-major, `LANES` or 2 `LANES` values a column, zero beyond the rank.
    columns: Vec<f64>,
    dropped: Vec<usize>,
}

impl SupportColumns {
    /// The columns of the basis that consists of some functions of a table.
    ///
    /// # Errors
    /// [`MomentError::Unsupported`] for more than [`MAX_ROWS`] - 1 independent functions or none.
    pub fn new(table: &FunctionTable, functions: &[usize]) -> Result<Self, MomentError> {
        let count = table.depths.len();
        let scale = DoubleDouble::one() / DoubleDouble::from(count as f64);
        let norm = |v: &[DoubleDouble]| (dot(v, v) * scale).sqrt();
        let mut directions = vec![vec![DoubleDouble::one(); count]];
        let mut dropped = Vec::new();
        for &function in functions {
            let mut sample = table.samples[function].clone();
            let before = norm(&sample).to_f64();
            // Once more, because the first pass leaves rounding of what it removes.
            for _ in 0..2 {
                for direction in &directions {
                    let factor = dot(direction, &sample) * scale;
                    for (value, &d) in sample.iter_mut().zip(direction) {
                        *value = *value - factor * d;
                    }
                }
            }
            let after = norm(&sample);
            if after.to_f64() <= DEPENDENCE_TOLERANCE * before {
                dropped.push(function);
                continue;
            }
            let inverse = DoubleDouble::one() / after;
            directions.push(sample.into_iter().map(|v| v * inverse).collect());
        }
        let rows: Vec<Vec<f64>> = directions
            .iter()
            .map(|direction| direction.iter().map(|value| value.to_f64()).collect())
            .collect();
        Self::of_rows(count, &rows, dropped)
    }

    /// From orthonormal rows over the support, the first one of ones.
    pub(crate) fn of_rows(
        count: usize,
        directions: &[Vec<f64>],
        dropped: Vec<usize>,
    ) -> Result<Self, MomentError> {
        let rank = directions.len();
        if !(2..=MAX_ROWS).contains(&rank) {
            return Err(MomentError::Unsupported(format!(
                "{} independent functions on the support: 1 to {} are possible",
                rank - 1,
                MAX_ROWS - 1
            )));
        }
        let padded = count.next_multiple_of(LANES);
        let stride = rank.next_multiple_of(LANES);
        let mut columns = Self {
            depths: count,
            rank,
            padded,
            rows: vec![[0.0; LANES]; rank * padded / LANES],
            columns: vec![0.0; count * stride],
            dropped,
        };
        for (i, direction) in directions.iter().enumerate() {
            for j in 0..padded {
                columns.rows[(i * padded + j) / LANES][j % LANES] = direction[j.min(count - 1)];
            }
            for (j, &value) in direction.iter().take(count).enumerate() {
                columns.columns[j * stride + i] = value;
            }
        }
        Ok(columns)
    }

    /// Number of depths in the support.
    pub fn depths(&self) -> usize {
        self.depths
    }

    /// Number of rows: 1 and the independent functions.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Functions that gave no row, because they are combinations of those before them, by their number in the table.
    pub fn dropped(&self) -> &[usize] {
        &self.dropped
    }

    /// Row i over the support, padded to whole groups of lanes.
    #[inline(always)]
    pub(super) fn row(&self, i: usize) -> &[[f64; LANES]] {
        let groups = self.padded / LANES;
        &self.rows[i * groups..(i + 1) * groups]
    }

    /// a(z_j), the rank's values first.
    #[inline(always)]
    pub(crate) fn column(&self, j: usize) -> &[f64] {
        let stride = self.columns.len() / self.depths;
        &self.columns[j * stride..(j + 1) * stride]
    }

    /// E\[a\] for a distribution on the support.
    #[inline(always)]
    pub fn moments(&self, kernel: &SupportDistribution) -> [f64; MAX_ROWS] {
        let mut sums = [0.0; 2 * LANES];
        for (&j, &w) in kernel.indices.iter().zip(&kernel.weights) {
            for (sum, &a) in sums.iter_mut().zip(self.column(usize::from(j))) {
                *sum += w * a;
            }
        }
        std::array::from_fn(|i| sums[i])
    }
}

/// A depth distribution whose depths lie on a support: ascending indices into it, with weights that sum to 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SupportDistribution {
    indices: Vec<u16>,
    weights: Vec<f64>,
}

impl SupportDistribution {
    /// Moves every depth to the nearest one of `cells` equal cells' ends and merges what meets there. Depths lie in
    /// \[0, 1\], weights sum to 1.
    pub fn snapped(taps: impl Iterator<Item = (f64, f64)>, cells: usize, scratch: &mut Vec<f64>) -> Self {
        scratch.clear();
        scratch.resize(cells + 1, 0.0);
        for (z, w) in taps {
            scratch[snap(z, cells)] += w;
        }
        let mut distribution = Self::default();
        for (j, &w) in scratch.iter().enumerate().filter(|(_, w)| **w > 0.0) {
            distribution.indices.push(j as u16);
            distribution.weights.push(w);
        }
        distribution
    }

    /// Indices into the support, ascending.
    pub fn indices(&self) -> &[u16] {
        &self.indices
    }

    /// Weights, in the same order.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// F: the weight of the depths strictly before the support's depth number `step`.
    pub fn cdf(&self, step: u16) -> f64 {
        let before = self.indices.partition_point(|&j| j < step);
        self.weights[..before].iter().sum()
    }
}

/// Index of the nearest end of `cells` equal cells of \[0, 1\]; depths outside are clamped.
pub fn snap(z: f64, cells: usize) -> usize {
    (z.clamp(0.0, 1.0) * cells as f64).round() as usize
}
