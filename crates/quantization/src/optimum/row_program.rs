//! One row of the transform while the others are fixed: a linear program.
//!
//! The determinant is linear in the row, c . x with the cofactors c, and the row must keep its range: |f(t) . x| <= 1/2
//! for all t, where f holds the row's functions and, unless they are odd, a constant that centres the range (MSM15
//! section 4.3: the bounding box is \[0, 1\]^m). The dual is to write c = sum of l_k f(t_k) with the least sum of |l_k|:
//! any independent t_k are feasible, whichever signs the l_k have, so that neither an artificial start nor a second
//! phase is needed and the optimum of one program starts the next.

use super::chebyshev;
use nalgebra::DMatrix;

/// Samples of the grid for each degree of the functions: an extremum of a polynomial lies within pi / 64 / degree of a
/// sample in angle and exceeds it by 0.1 % at most. The range on the continuum is settled later, see [`crate::polish`].
const SAMPLES_A_DEGREE: usize = 32;

/// Fewest samples.
const MIN_SAMPLES: usize = 256;

/// Coefficients below this share of the largest do not move an extremum to another sample.
const INSIGNIFICANT: f64 = 1e-3;

/// A sample enters if it exceeds the range by this much: far above rounding, far below what decides between optima.
const VIOLATION: f64 = 1e-11;

/// A column counts as a candidate to leave above this; smaller pivots would spoil the inverse.
const SMALLEST_PIVOT: f64 = 1e-9;

/// Exchanges of one program: typically 5 to 40 are needed.
const MAX_EXCHANGES: usize = 400;

/// Exchanges after which the inverse is computed anew.
const REFACTOR_AFTER: usize = 40;

/// Rows that are optimised together: all of them, or those of one parity.
#[derive(Debug)]
pub(crate) struct Block {
    /// Series of the row functions, then that of the constant unless the block is odd.
    pub(crate) functions: Vec<Vec<f64>>,
    /// Number of rows, and of row functions.
    pub(crate) rows: usize,
    /// First t: -1, or 0 where symmetry settles the rest.
    pub(crate) low: f64,
    /// Sample depths.
    pub(crate) grid: Vec<f64>,
    /// f at the samples, n values each.
    samples: Vec<f64>,
}

impl Block {
    pub(crate) fn new(series: Vec<Vec<f64>>, constant: bool, low: f64) -> Self {
        let rows = series.len();
        let degree = series.iter().map(|series| effective_degree(series)).max().unwrap_or(1);
        let mut functions = series;
        if constant {
            functions.push(vec![1.0]);
        }
        let count = (SAMPLES_A_DEGREE * degree).max(MIN_SAMPLES);
        let (from, to) = (low.asin(), 1f64.asin());
        let grid: Vec<f64> = (0..=count)
            .map(|i| (from + (to - from) * i as f64 / count as f64).sin().clamp(low, 1.0))
            .collect();
        let samples =
            grid.iter().flat_map(|&t| functions.iter().map(move |f| chebyshev::evaluate(f, t))).collect();
        Self { functions, rows, low, grid, samples }
    }

    /// Number of unknowns of a row.
    pub(crate) fn unknowns(&self) -> usize {
        self.functions.len()
    }

    fn sample(&self, index: usize) -> &[f64] {
        let n = self.unknowns();
        &self.samples[index * n..(index + 1) * n]
    }

    /// Series of the row x.
    pub(crate) fn series(&self, x: &[f64]) -> Vec<f64> {
        chebyshev::combination(&self.functions, x)
    }

    /// Samples that are far from dependent: each the one that the samples before it describe worst.
    fn spread(&self) -> Vec<usize> {
        let n = self.unknowns();
        let mut residuals: Vec<Vec<f64>> = (0..self.grid.len()).map(|i| self.sample(i).to_vec()).collect();
        let mut chosen = Vec::with_capacity(n);
        for _ in 0..n {
            let size = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
            let best = (0..residuals.len())
                .max_by(|&a, &b| size(&residuals[a]).total_cmp(&size(&residuals[b])))
                .unwrap_or_default();
            chosen.push(best);
            let direction = residuals[best].clone();
            let square = size(&direction);
            for residual in &mut residuals {
                let along = residual.iter().zip(&direction).map(|(a, b)| a * b).sum::<f64>() / square;
                residual.iter_mut().zip(&direction).for_each(|(r, d)| *r -= along * d);
            }
        }
        chosen
    }
}

/// Degree of the polynomial that the series amounts to on the grid.
fn effective_degree(series: &[f64]) -> usize {
    let largest = series.iter().fold(0.0, |max: f64, c| max.max(c.abs()));
    series.iter().rposition(|c| c.abs() > INSIGNIFICANT * largest).unwrap_or_default()
}

/// A vertex of the dual: n samples with the inverse of the matrix of their f.
#[derive(Clone, Debug)]
pub(crate) struct Vertex {
    nodes: Vec<usize>,
    /// Column-major inverse of the matrix whose row k is f(t_k).
    inverse: Vec<f64>,
    exchanges: usize,
}

/// Optimum of a row program on the grid.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    /// The unknowns.
    pub(crate) x: Vec<f64>,
    /// Depths t at which the row touches its range, with the multipliers l, whose signs are those of the row there.
    pub(crate) support: Vec<(f64, f64)>,
}

impl Vertex {
    /// A start for every program of the block; `None` if its functions are dependent.
    pub(crate) fn start(block: &Block) -> Option<Self> {
        let mut vertex = Self { nodes: block.spread(), inverse: Vec::new(), exchanges: 0 };
        vertex.refactor(block).then_some(vertex)
    }

    fn refactor(&mut self, block: &Block) -> bool {
        let n = self.nodes.len();
        let matrix = DMatrix::from_fn(n, n, |k, j| block.sample(self.nodes[k])[j]);
        self.exchanges = 0;
        match matrix.try_inverse() {
            Some(inverse) if inverse.iter().all(|v| v.is_finite()) => {
                self.inverse = inverse.as_slice().to_vec();
                true
            }
            _ => false,
        }
    }

    /// inverse^T v: coefficients of v over the f(t_k).
    fn expand(&self, v: &[f64], out: &mut [f64]) {
        for (column, value) in self.inverse.chunks_exact(v.len()).zip(out) {
            *value = column.iter().zip(v).map(|(a, b)| a * b).sum();
        }
    }

    /// Maximises c . x on the grid, exchanging samples.
    pub(crate) fn maximise(&mut self, block: &Block, c: &[f64]) -> Row {
        let n = c.len();
        let (mut multipliers, mut direction, mut x) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        for _ in 0..MAX_EXCHANGES {
            self.expand(c, &mut multipliers);
            x.fill(0.0);
            for (column, &l) in self.inverse.chunks_exact(n).zip(&multipliers) {
                let half = if l < 0.0 { -0.5 } else { 0.5 };
                x.iter_mut().zip(column).for_each(|(x, a)| *x += half * a);
            }
            let Some((entering, sign)) = worst(block, &x) else { break };
            self.expand(block.sample(entering), &mut direction);
            let Some(leaving) = leaving(&multipliers, &direction, sign) else { break };
            self.exchange(entering, leaving, &direction);
            if self.exchanges >= REFACTOR_AFTER && !self.refactor(block) {
                break;
            }
        }
        let support = self.nodes.iter().zip(&multipliers).map(|(&k, &l)| (block.grid[k], l)).collect();
        Row { x, support }
    }

    fn exchange(&mut self, entering: usize, leaving: usize, direction: &[f64]) {
        let n = self.nodes.len();
        let pivot = direction[leaving];
        let column: Vec<f64> =
            self.inverse[leaving * n..(leaving + 1) * n].iter().map(|value| value / pivot).collect();
        for (k, other) in self.inverse.chunks_exact_mut(n).enumerate() {
            if k == leaving {
                other.copy_from_slice(&column);
            } else {
                other.iter_mut().zip(&column).for_each(|(o, c)| *o -= c * direction[k]);
            }
        }
        self.nodes[leaving] = entering;
        self.exchanges += 1;
    }
}

/// The sample that exceeds the range most, with the sign of the row there.
fn worst(block: &Block, x: &[f64]) -> Option<(usize, f64)> {
    let mut worst = (0.5 + VIOLATION, None);
    for (index, sample) in block.samples.chunks_exact(x.len()).enumerate() {
        let value: f64 = sample.iter().zip(x).map(|(a, b)| a * b).sum();
        if value.abs() > worst.0 {
            worst = (value.abs(), Some((index, value.signum())));
        }
    }
    worst.1
}

/// The node whose multiplier vanishes first when the entering one's grows.
fn leaving(multipliers: &[f64], direction: &[f64], sign: f64) -> Option<usize> {
    let mut best: Option<(f64, usize)> = None;
    for (k, (&l, &d)) in multipliers.iter().zip(direction).enumerate() {
        let rate = sign * if l < 0.0 { -d } else { d };
        if rate > SMALLEST_PIVOT {
            let step = l.abs() / rate;
            if best.is_none_or(|(least, _)| step < least) {
                best = Some((step, k));
            }
        }
    }
    best.map(|(_, k)| k)
}
