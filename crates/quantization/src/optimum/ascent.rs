//! Cyclic ascent over the rows from many random starts.

use super::row_program::{Block, Row, Vertex};
use nalgebra::DMatrix;
use random_stream::Random;

/// A sweep over all rows that gains less than this many bits ends an ascent on the grid, whose own error is larger.
const SETTLED_BITS: f64 = 1e-7;

/// Sweeps of one ascent: typically 5 to 50 are needed.
const MAX_SWEEPS: usize = 500;

/// An ascent's end.
#[derive(Clone, Debug)]
pub(crate) struct Ascent {
    /// log2 |det| of the rows in working coordinates, ranges on the grid.
    pub(crate) bits: f64,
    pub(crate) rows: Vec<Row>,
}

/// Cofactors of a row divided by the determinant, over all unknowns of the row.
pub(crate) fn cofactors(inverse: &DMatrix<f64>, row: usize, unknowns: usize) -> Vec<f64> {
    let mut c: Vec<f64> = inverse.column(row).iter().copied().collect();
    c.resize(unknowns, 0.0);
    c
}

/// Climbs from random rows; `None` if they happened to be dependent.
pub(crate) fn ascend(block: &Block, start: &Vertex, random: &mut Random) -> Option<Ascent> {
    let (m, n) = (block.rows, block.unknowns());
    let mut matrix = DMatrix::from_fn(m, m, |_, _| random.unit() - 0.5);
    let mut vertices = vec![start.clone(); m];
    let mut rows: Vec<Option<Row>> = vec![None; m];
    for _ in 0..MAX_SWEEPS {
        let mut gained = 0.0;
        for i in 0..m {
            let inverse = matrix.clone().try_inverse()?;
            let row = vertices[i].maximise(block, &cofactors(&inverse, i, n));
            // The old row's value is 1; the product is the factor by which the determinant grows.
            let factor: f64 = inverse.column(i).iter().zip(&row.x).map(|(c, x)| c * x).sum();
            gained += factor.abs().log2();
            matrix.row_mut(i).iter_mut().zip(&row.x).for_each(|(entry, x)| *entry = *x);
            rows[i] = Some(row);
        }
        if rows.iter().all(Option::is_some) && gained.abs() < SETTLED_BITS {
            break;
        }
    }
    let bits = matrix.determinant().abs().log2();
    bits.is_finite().then(|| Ascent { bits, rows: rows.into_iter().flatten().collect() })
}
