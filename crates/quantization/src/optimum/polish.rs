//! Rows that are optimal on the continuum, not on a grid.
//!
//! Where a row program has its optimum, c is a combination of the f(t_j) at the r depths where the row touches its
//! range, and there the row is extreme (Karush, Kuhn and Tucker):
//! sum_j l_j f(t_j) = c, f(t_j) . x = sign(l_j) / 2, and f'(t_j) . x = 0 unless t_j is an end of the interval.
//! Newton's method solves these equations; as the program is convex, a solution with a valid range is an optimum.

use super::ascent::{Ascent, cofactors};
use super::chebyshev;
use super::row_program::{Block, Row, Vertex};
use nalgebra::{DMatrix, DVector};

/// Newton steps: convergence is quadratic from the grid's solution.
const NEWTON_STEPS: usize = 12;

/// Residual of the equations, whose terms are of order 1 to 100, that counts as solved.
const SOLVED: f64 = 1e-11;

/// Singular values below this share of the largest are taken for zero: where fewer depths touch than the row has
/// unknowns, x is not unique, and the step of least size is taken.
const RANK_TOLERANCE: f64 = 1e-11;

/// A solution's range may exceed 1 by this much before it counts as a failure; what is left is divided out.
const RANGE_TOLERANCE: f64 = 1e-10;

/// Multipliers below this share of the largest belong to depths that do not matter.
const NO_MULTIPLIER: f64 = 1e-8;

/// Depths closer than this many grid angles are one depth that lies between the samples.
const SAME_DEPTH: f64 = 2.5;

/// A sweep that gains less than this many bits ends the polish: rounding of a determinant is about as large.
const SETTLED_BITS: f64 = 1e-13;

/// Sweeps: convergence is linear, mostly with a factor below 1/2.
const MAX_SWEEPS: usize = 300;

/// Rows whose range on the continuum has width 1, centred on 0.
#[derive(Clone, Debug)]
pub(crate) struct Polished {
    /// log2 |det| of the rows in working coordinates.
    pub(crate) bits: f64,
    /// Row functions' coefficients of each row.
    pub(crate) rows: Vec<Vec<f64>>,
}

/// Climbs on from an ascent on the grid; `None` if the rows became dependent.
pub(crate) fn polish(block: &Block, start: &Vertex, ascent: &Ascent) -> Option<Polished> {
    let (m, n) = (block.rows, block.unknowns());
    let mut supports: Vec<Vec<(f64, f64)>> =
        ascent.rows.iter().map(|row| merged(block, &row.support)).collect();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for row in &ascent.rows {
        rows.push(feasible(block, &row.x)?);
    }
    let mut vertices = vec![start.clone(); m];
    let matrix = |rows: &[Vec<f64>]| DMatrix::from_fn(m, m, |i, j| rows[i][j]);
    for _ in 0..MAX_SWEEPS {
        let mut gained = 0.0;
        for i in 0..m {
            let c = cofactors(&matrix(&rows).try_inverse()?, i, n);
            let exact = solve(block, &c, &rows[i], &supports[i]).or_else(|| {
                let row: Row = vertices[i].maximise(block, &c);
                let support = merged(block, &row.support);
                solve(block, &c, &row.x, &support).or(Some((row.x, support)))
            });
            let Some((x, support)) = exact else { continue };
            let Some(x) = feasible(block, &x) else { continue };
            let factor: f64 = c.iter().zip(&x).take(m).map(|(c, x)| c * x).sum();
            supports[i] = support;
            if factor.abs() > 1.0 {
                gained += factor.abs().log2();
                rows[i] = x;
            }
        }
        if gained < SETTLED_BITS {
            break;
        }
    }
    let bits = matrix(&rows).determinant().abs().log2();
    bits.is_finite().then(|| Polished { bits, rows: rows.into_iter().map(|row| row[..m].to_vec()).collect() })
}

/// The row scaled, and centred by its constant, to a range from -1/2 to 1/2.
fn feasible(block: &Block, x: &[f64]) -> Option<Vec<f64>> {
    let (min, max) = chebyshev::extremes(&block.series(x), block.low, 1.0);
    let mut x = x.to_vec();
    let width = if x.len() > block.rows {
        x[block.rows] -= 0.5 * (min + max);
        max - min
    } else {
        2.0 * max.max(-min)
    };
    x.iter_mut().for_each(|value| *value /= width);
    x.iter().all(|value| value.is_finite()).then_some(x)
}

/// Neighbouring samples of one sign become the depth between them.
fn merged(block: &Block, support: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let largest = support.iter().fold(0.0, |max: f64, (_, l)| max.max(l.abs()));
    let mut points: Vec<(f64, f64)> =
        support.iter().copied().filter(|(_, l)| l.abs() > NO_MULTIPLIER * largest).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let angle = SAME_DEPTH * (1f64.asin() - block.low.asin()) / (block.grid.len() - 1) as f64;
    let mut merged: Vec<(f64, f64)> = Vec::new();
    for (t, l) in points {
        match merged.last_mut() {
            Some((t0, l0)) if (*l0 < 0.0) == (l < 0.0) && t.asin() - t0.asin() <= angle => {
                *t0 = (*t0 * *l0 + t * l) / (*l0 + l);
                *l0 += l;
            }
            _ => merged.push((t, l)),
        }
    }
    merged
}

/// A row of theta, and its points of contact with their multipliers.
type Optimum = (Vec<f64>, Vec<(f64, f64)>);

/// Newton's method from a guess; `None` unless it ends in an optimum.
fn solve(block: &Block, c: &[f64], x: &[f64], support: &[(f64, f64)]) -> Option<Optimum> {
    let (n, r) = (c.len(), support.len());
    let (mut x, mut t): (Vec<f64>, Vec<f64>) = (x.to_vec(), support.iter().map(|s| s.0).collect());
    let mut l: Vec<f64> = support.iter().map(|s| s.1).collect();
    // At an end the row need not be flat.
    let free: Vec<usize> = (0..r).filter(|&j| t[j] > block.low && t[j] < 1.0).collect();
    let size = n + r + free.len();
    let slopes: Vec<Vec<f64>> = block.functions.iter().map(|f| chebyshev::derivative(f)).collect();
    let bends: Vec<Vec<f64>> = slopes.iter().map(|f| chebyshev::derivative(f)).collect();
    let at = |functions: &[Vec<f64>], t: f64| -> Vec<f64> {
        functions.iter().map(|f| chebyshev::evaluate(f, t)).collect()
    };
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let mut solved = false;
    for _ in 0..NEWTON_STEPS {
        let (mut jacobian, mut residual) = (DMatrix::zeros(size, size), DVector::zeros(size));
        residual.rows_mut(0, n).copy_from_slice(&c.iter().map(|c| -c).collect::<Vec<_>>());
        for j in 0..r {
            let (f, d) = (at(&block.functions, t[j]), at(&slopes, t[j]));
            for k in 0..n {
                residual[k] += l[j] * f[k];
                jacobian[(k, n + j)] = f[k];
                jacobian[(n + j, k)] = f[k];
            }
            residual[n + j] = dot(&f, &x) - 0.5 * support[j].1.signum();
            if let Some(q) = free.iter().position(|&index| index == j).map(|q| n + r + q) {
                for k in 0..n {
                    jacobian[(k, q)] = l[j] * d[k];
                    jacobian[(q, k)] = d[k];
                }
                residual[q] = dot(&d, &x);
                jacobian[(n + j, q)] = residual[q];
                jacobian[(q, q)] = dot(&at(&bends, t[j]), &x);
            }
        }
        solved = residual.amax() < SOLVED;
        if solved {
            break;
        }
        let svd = jacobian.svd(true, true);
        let cut = RANK_TOLERANCE * svd.singular_values.amax();
        let step = svd.solve(&residual, cut).ok()?;
        x.iter_mut().enumerate().for_each(|(k, x)| *x -= step[k]);
        l.iter_mut().enumerate().for_each(|(j, l)| *l -= step[n + j]);
        for (q, &j) in free.iter().enumerate() {
            t[j] = (t[j] - step[n + r + q]).clamp(block.low, 1.0);
        }
        if x.iter().chain(&l).any(|value| !value.is_finite()) {
            return None;
        }
    }
    if !solved || l.iter().zip(support).any(|(l, s)| l * s.1 < 0.0) {
        return None;
    }
    // Where x is not unique, the grid has picked one at random; the smallest is the smoothest.
    let count = r + free.len();
    let touching = DMatrix::from_fn(count, n, |i, k| match i.checked_sub(r) {
        None => chebyshev::evaluate(&block.functions[k], t[i]),
        Some(q) => chebyshev::evaluate(&slopes[k], t[free[q]]),
    });
    let target = DVector::from_fn(count, |i, _| if i < r { 0.5 * support[i].1.signum() } else { 0.0 });
    let svd = touching.svd(true, true);
    let smallest = svd.solve(&target, RANK_TOLERANCE * svd.singular_values.amax()).ok();
    let candidates = smallest.map(|v| v.as_slice().to_vec()).into_iter().chain([x]);
    let valid = |x: &Vec<f64>| {
        let (min, max) = chebyshev::extremes(&block.series(x), block.low, 1.0);
        max.max(-min) <= 0.5 + RANGE_TOLERANCE
    };
    let x = candidates.into_iter().find(valid)?;
    Some((x, t.into_iter().zip(l).collect()))
}
