//! The space that the functions of a family span on a support: far fewer dimensions than there are functions and depths.
//!
//! Phi is an orthonormal basis of it over the support. A kernel's coordinates m = Phi^T Z are computed once; the moments of
//! any basis of the family are b = T m, and its columns a(z_j) = T Phi_j. The rows of T are orthonormal, so nothing cancels.

use super::batch::ProgramBatch;
use super::lanes::Quad;
use super::width::Width;
use crate::arithmetic::{DoubleDouble, Field, Real};
use crate::dense::dot;
use crate::error::MomentError;
use crate::fast_simplex::support::DEPENDENCE_TOLERANCE;
use crate::fast_simplex::{FunctionTable, SupportColumns, SupportDistribution};
use serde::{Deserialize, Serialize};

/// Dimensions in which no function has more than this share of its norm are left out. Orthonormalisation may enlarge the rest
/// by a million in the default family, which leaves it below the rounding of doubles.
const SPAN_TOLERANCE: f64 = 1e-22;

/// Numbers side by side in the loops over the support.
const PADDING: usize = 8;

/// An orthonormal basis of the span of a table's functions and 1, and the functions in it.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct FunctionSpan {
    depths: usize,
    padded: usize,
    dimensions: usize,
    /// Phi by dimension, `padded` values each, the first one 1.
    high: Vec<f64>,
    /// What `high` lacks.
    low: Vec<f64>,
    /// By function: its coordinates.
    functions: Vec<Vec<DoubleDouble>>,
}

impl FunctionSpan {
    /// The span of all functions of a table.
    pub fn new(table: &FunctionTable) -> Self {
        let count = table.depths().len();
        let scale = DoubleDouble::one() / DoubleDouble::from(count as f64);
        let norm = |v: &[DoubleDouble]| (dot(v, v) * scale).sqrt();
        let mut directions = vec![vec![DoubleDouble::one(); count]];
        let project = |sample: &mut [DoubleDouble], direction: &[DoubleDouble]| {
            let factor = dot(direction, sample) * scale;
            for (value, &d) in sample.iter_mut().zip(direction) {
                *value = *value - factor * d;
            }
        };
        let norms: Vec<f64> = table.samples().iter().map(|sample| norm(sample).to_f64()).collect();
        let mut rest: Vec<Vec<DoubleDouble>> = table.samples().to_vec();
        loop {
            let newest = &directions[directions.len() - 1];
            rest.iter_mut().for_each(|sample| project(sample, newest));
            let share = |i: usize| norm(&rest[i]).to_f64() / norms[i].max(f64::MIN_POSITIVE);
            let shares: Vec<f64> = (0..rest.len()).map(share).collect();
            let best = (0..rest.len()).max_by(|&a, &b| shares[a].total_cmp(&shares[b]));
            let Some(best) = best.filter(|&best| shares[best] > SPAN_TOLERANCE) else { break };
            let mut direction = rest[best].clone();
            // Once more, because the first pass leaves rounding of what it removed.
            let inverse = DoubleDouble::one() / norm(&direction);
            direction.iter_mut().for_each(|value| *value = *value * inverse);
            directions.iter().for_each(|other| project(&mut direction, other));
            let inverse = DoubleDouble::one() / norm(&direction);
            direction.iter_mut().for_each(|value| *value = *value * inverse);
            directions.push(direction);
        }
        let padded = count.next_multiple_of(PADDING);
        let dimensions = directions.len();
        let (mut high, mut low) = (vec![0.0; dimensions * padded], vec![0.0; dimensions * padded]);
        for (r, direction) in directions.iter().enumerate() {
            for (j, value) in direction.iter().enumerate() {
                high[r * padded + j] = value.to_f64();
                low[r * padded + j] = value.low();
            }
        }
        let coordinates = |sample: &Vec<DoubleDouble>| -> Vec<DoubleDouble> {
            directions.iter().map(|direction| dot(direction, sample) * scale).collect()
        };
        let functions = table.samples().iter().map(coordinates).collect();
        Self { depths: count, padded, dimensions, high, low, functions }
    }

    /// Number of dimensions, the constant function among them.
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// Number of depths in the support.
    pub fn depths(&self) -> usize {
        self.depths
    }

    /// Phi^T Z: its first entry is the mass of Z.
    pub fn coordinates(&self, kernel: &SupportDistribution) -> Vec<f64> {
        let mut sums = vec![DoubleDouble::zero(); self.dimensions];
        for (&j, &weight) in kernel.indices().iter().zip(kernel.weights()) {
            let weight = DoubleDouble::from(weight);
            for (r, sum) in sums.iter_mut().enumerate() {
                let at = r * self.padded + usize::from(j);
                *sum = *sum + weight * DoubleDouble::sum(self.high[at], self.low[at]);
            }
        }
        sums.iter().map(|sum| sum.to_f64()).collect()
    }

    /// The columns of the basis that consists of some functions of the table, the same as [`SupportColumns::new`] makes, and
    /// the way from coordinates to moments.
    ///
    /// # Errors
    /// As [`SupportColumns::new`].
    ///
    /// # Panics
    /// If the table has no such function.
    pub fn columns(&self, functions: &[usize]) -> Result<SpanColumns, MomentError> {
        let mut rows: Vec<Vec<DoubleDouble>> = Vec::new();
        let mut constant = vec![DoubleDouble::zero(); self.dimensions];
        constant[0] = DoubleDouble::one();
        rows.push(constant);
        let mut dropped = Vec::new();
        for &function in functions {
            let mut row = self.functions[function].clone();
            let before = dot(&row, &row).sqrt().to_f64();
            // Once more, because the first pass leaves rounding of what it removes.
            for _ in 0..2 {
                for other in &rows {
                    let factor = dot(other, &row);
                    for (value, &o) in row.iter_mut().zip(other) {
                        *value = *value - factor * o;
                    }
                }
            }
            let after = dot(&row, &row).sqrt();
            if after.to_f64() <= DEPENDENCE_TOLERANCE * before {
                dropped.push(function);
                continue;
            }
            let inverse = DoubleDouble::one() / after;
            rows.push(row.into_iter().map(|value| value * inverse).collect());
        }
        let mut values = vec![vec![0.0; self.padded]; rows.len()];
        let mut errors = vec![0.0; self.padded];
        for (row, values) in rows.iter().zip(&mut values) {
            errors.fill(0.0);
            for (r, factor) in row.iter().enumerate() {
                let (high, low) = (
                    &self.high[r * self.padded..][..self.padded],
                    &self.low[r * self.padded..][..self.padded],
                );
                Width::widest().accumulate((factor.to_f64(), factor.low()), (high, low), values, &mut errors);
            }
            values.iter_mut().zip(&errors).for_each(|(value, error)| *value += error);
        }
        let columns = SupportColumns::of_rows(self.depths, &values, dropped)?;
        let transform = (0..self.dimensions)
            .map(|r| Quad(std::array::from_fn(|i| rows.get(i + 1).map_or(0.0, |row| row[r].to_f64()))))
            .collect();
        Ok(SpanColumns { columns, transform })
    }
}

/// The matrix of Algorithm 1 for one basis, with the way from a [`FunctionSpan`]'s coordinates to its moments.
#[derive(Clone, Debug)]
pub struct SpanColumns {
    pub(super) columns: SupportColumns,
    /// T by dimension, without the row of ones.
    pub(super) transform: Vec<Quad>,
}

/// What rounding may do to a dual function and its value in double precision: the sum over rows i > 0 of
/// |y_i| (rows_i + value |b_i| + moment |m|), and |y_0| mass, with the norm |m| of a program's coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Rounding {
    /// By row behind that of ones, zero beyond the rank.
    pub rows: [f64; 4],
    /// See above.
    pub value: f64,
    /// See above.
    pub moment: f64,
    /// See above.
    pub mass: f64,
}

impl SpanColumns {
    /// The columns.
    pub fn columns(&self) -> &SupportColumns {
        &self.columns
    }

    /// T by dimension: entry i - 1 of each is the factor of that coordinate in moment i, zero beyond the rank.
    pub fn transform(&self) -> impl ExactSizeIterator<Item = [f64; 4]> + '_ {
        self.transform.iter().map(|quad| quad.0)
    }

    /// Rows 1 to 4 of the columns, zero beyond the rank.
    pub fn entries(&self) -> impl ExactSizeIterator<Item = [f64; 4]> + '_ {
        let rank = self.columns.rank().min(5);
        (0..self.columns.depths()).map(move |j| {
            let column = self.columns.column(j);
            std::array::from_fn(|i| if i + 1 < rank { column[i + 1] } else { 0.0 })
        })
    }

    /// Rounding where every moment is a sum of products in which each term goes through at most `chain` additions.
    pub fn rounding(&self, batch: &ProgramBatch<'_>, chain: usize) -> Rounding {
        const HALF: f64 = 0.5 * f64::EPSILON;
        // y_0 - p + y . a at a column: five operations and a margin.
        const SCAN: f64 = 6.0 * HALF;
        // y_0 + y . b: four, and a margin.
        const VALUE: f64 = 5.0 * HALF;
        let rows = std::array::from_fn(|i| {
            SCAN * self.entries().fold(0.0, |most: f64, column| most.max(column[i].abs()))
        });
        // Rounding of coordinates, factors and products comes before the additions; rows of T have the norm 1, so that the sum of
        // the products' sizes is at most |m|.
        let moment = (chain + 3) as f64 * HALF;
        Rounding { rows, value: VALUE, moment, mass: SCAN + VALUE + batch.mass_error }
    }
}
