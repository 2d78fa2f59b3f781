//! The simplex method itself, for a fixed number of rows.
//!
//! The dual polytope {y: y . a_j <= p_j} depends on z_f but not on the moments. For each z_f its vertices are kept as
//! they are found; a fragment starts at the vertex that is best for its moments, which is the optimum more often than
//! not, and continues with the dual simplex method otherwise.

use super::support::{LANES, SupportColumns};
use super::{FastBound, FastVertex, MAX_ROWS};

/// Slack that a dual vertex may lack at a column: the ratio test takes the step at which no column lacks more, and so
/// may prefer large pivots (Harris). A bound is lowered by what its vertex lacks in the end.
const SLACK_TOLERANCE: f64 = 1e-10;

/// A weight counts as negative below minus this times the size of its row of the inverse: some hundred roundings of the
/// products that it is the sum of. Absolute tolerances stall, since rows differ by many orders of magnitude.
const WEIGHT_TOLERANCE: f64 = 3e-14;

/// Pivot elements below this share of their row are rounding.
const PIVOT_TOLERANCE: f64 = 1e-11;

/// Pivots for one fragment; nearly all need fewer than ten. What needs more goes to the exact route.
const MAX_PIVOTS: usize = 60;

/// Pivots of the primal method between two depths; the first depth starts from scratch.
const MAX_PRIMAL_PIVOTS: usize = 2000;

/// Vertices kept for one z_f. Beyond it the search for the best costs more than the pivots that it saves.
const MAX_CACHED: usize = 512;

/// Pivots after which the inverse is computed afresh.
const REFRESH: usize = 8;

/// A basis of the linear program: `index[r]` is the column of row r.
#[derive(Clone, Copy)]
struct Vertex<const R: usize> {
    index: [u16; R],
    /// Inverse of the matrix of basic columns; row r gives the weight of column `index[r]`.
    inverse: [[f64; R]; R],
    dual: [f64; R],
}

/// Vertices of the dual polytope of one z_f.
struct Cache<const R: usize> {
    vertices: Vec<Vertex<R>>,
    /// Dual vectors in groups of lanes.
    duals: Vec<[[f64; LANES]; R]>,
    /// What each vertex lacks, rounding included; and its number in the solution, if a bound used it.
    lacking: Vec<f64>,
    used: Vec<u32>,
}

/// Not (yet) part of a solution.
const UNUSED: u32 = u32::MAX;

/// The solver for one basis.
pub(super) struct Engine<'a, const R: usize> {
    columns: &'a SupportColumns,
    rows: [&'a [f64]; R],
    /// Largest entry of each row.
    largest: [f64; R],
    /// Moments of a distribution that charges the whole support, and its optimal vertex for the present z_f.
    generic: [f64; R],
    start: Option<Vertex<R>>,
    cache: Cache<R>,
    pub(super) pivots: u64,
}

/// One fragment: moments E[a], F, and where the answer goes.
pub(super) struct Job<'a, const R: usize> {
    pub(super) moments: &'a [f64; MAX_ROWS],
    pub(super) mass_before: f64,
}

impl<'a, const R: usize> Engine<'a, R> {
    pub(super) fn new(columns: &'a SupportColumns) -> Self {
        let rows: [&[f64]; R] = std::array::from_fn(|i| columns.row(i));
        let count = columns.depths();
        // Unequal weights (golden-ratio sequence) so that no symmetry makes the start degenerate.
        let weight = |j: usize| 0.5 + (j as f64 * 0.618_033_988_749_895).fract();
        let total: f64 = (0..count).map(weight).sum();
        let generic = std::array::from_fn(|i| {
            rows[i][..count].iter().enumerate().map(|(j, a)| weight(j) * a).sum::<f64>() / total
        });
        let largest = std::array::from_fn(|i| rows[i].iter().fold(0.0, |m: f64, a| m.max(a.abs())));
        let cache = Cache { vertices: Vec::new(), duals: Vec::new(), lacking: Vec::new(), used: Vec::new() };
        Self { columns, rows, largest, generic, start: None, cache, pivots: 0 }
    }

    /// Begins with the fragments at the support's depth number `step`; false if no vertex was found.
    #[inline(always)]
    pub(super) fn begin(&mut self, step: u16) -> bool {
        self.cache.clear();
        if self.start.is_none() {
            self.start = self.phase_one();
        }
        let Some(mut vertex) = self.start else { return false };
        // Another z_f changes costs only: the vertex stays feasible for the generic moments.
        if !self.primal(&mut vertex, step) {
            self.start = None;
            return false;
        }
        self.start = Some(vertex);
        let (least, _) = self.least_slack(&vertex.dual, step);
        let lacking = self.lacking(&vertex.dual, least);
        self.cache.insert(&vertex, lacking);
        true
    }

    /// G for one fragment at the present step; `None` if the exact route has to decide. New entries of `vertices` are
    /// those that bounds refer to.
    #[inline(always)]
    pub(super) fn bound(
        &mut self,
        step: u16,
        job: &Job<'_, R>,
        tolerance: f64,
        vertices: &mut Vec<FastVertex>,
    ) -> Option<FastBound> {
        let b: [f64; R] = std::array::from_fn(|i| job.moments[i]);
        let enough = job.mass_before - 0.5 * tolerance;
        let best = self.cache.best(&b);
        let cached = &self.cache.vertices[best];
        let value = dot(&cached.dual, &b);
        let found = if value >= enough || leaving_row(cached, &b).is_none() {
            best
        } else {
            let mut vertex = *cached;
            self.dual(&mut vertex, &b, enough, step)?;
            let (least, _) = self.least_slack(&vertex.dual, step);
            let lacking = self.lacking(&vertex.dual, least);
            self.cache.insert(&vertex, lacking)
        };
        let vertex = &self.cache.vertices[found];
        let value = dot(&vertex.dual, &b);
        let rounding = (R + 2) as f64 * f64::EPSILON * dot_absolute(&vertex.dual, &b);
        let lower_proved = (value - self.cache.lacking[found] - rounding).max(0.0);
        let attained = if value >= enough { job.mass_before } else { attained(vertex, &b, step) };
        let attained = attained.clamp(0.0, job.mass_before.max(lower_proved));
        if attained - lower_proved > tolerance {
            return None;
        }
        if self.cache.used[found] == UNUSED {
            self.cache.used[found] = vertices.len() as u32;
            let mut padded = FastVertex { step, ..FastVertex::default() };
            padded.dual[..R].copy_from_slice(&vertex.dual);
            padded.support[..R].copy_from_slice(&vertex.index);
            padded.lacking = self.cache.lacking[found];
            vertices.push(padded);
        }
        Some(FastBound { lower: attained, lower_proved, vertex: self.cache.used[found] })
    }

    /// Slack that a dual vector provably does not lack anywhere on the support.
    #[inline(always)]
    fn lacking(&self, y: &[f64; R], least: f64) -> f64 {
        (-least).max(0.0) + (R + 2) as f64 * f64::EPSILON * (1.0 + dot_absolute(y, &self.largest))
    }

    /// Dual simplex method from a dual feasible vertex, until the weights are not negative or the value is enough.
    #[inline(always)]
    fn dual(&mut self, vertex: &mut Vertex<R>, b: &[f64; R], enough: f64, step: u16) -> Option<()> {
        for pivot in 1..=MAX_PIVOTS {
            let Some(row) = leaving_row(vertex, b) else {
                // The inverse has drifted: what it says must hold for a fresh one.
                vertex.refresh(self.columns, step)?;
                if leaving_row(vertex, b).is_none() {
                    return Some(());
                }
                continue;
            };
            let entering = self.entering(vertex, row, step)?;
            self.pivots += 1;
            vertex.replace(row, entering, self.columns)?;
            if pivot % REFRESH == 0 {
                vertex.refresh(self.columns, step)?;
            } else {
                vertex.price(step);
            }
            if dot(&vertex.dual, b) >= enough {
                vertex.refresh(self.columns, step)?;
                if dot(&vertex.dual, b) >= enough {
                    return Some(());
                }
            }
        }
        None
    }

    /// Column at which the slack vanishes first as the dual vector moves along a row of the inverse.
    #[inline(always)]
    fn entering(&self, vertex: &Vertex<R>, row: usize, step: u16) -> Option<usize> {
        let (y, rho) = (&vertex.dual, &vertex.inverse[row]);
        let floor = PIVOT_TOLERANCE * dot_absolute(rho, &self.largest);
        let mut numerator = [1.0f64; LANES];
        let mut divisor = [0.0f64; LANES];
        let mut group = [0.0f64; LANES];
        for start in (0..self.rows[0].len()).step_by(LANES) {
            let (slack, alpha) = self.slack_and_row(y, rho, start, step);
            let at = start as f64;
            for lane in 0..LANES {
                let size = -alpha[lane];
                let slack = slack[lane] + SLACK_TOLERANCE;
                // slack / size < numerator / divisor without a division.
                let better = (size > floor) & (slack * divisor[lane] < numerator[lane] * size);
                numerator[lane] = if better { slack } else { numerator[lane] };
                divisor[lane] = if better { size } else { divisor[lane] };
                group[lane] = if better { at } else { group[lane] };
            }
        }
        let mut best = 0;
        for lane in 1..LANES {
            if numerator[lane] * divisor[best] < numerator[best] * divisor[lane] {
                best = lane;
            }
        }
        (divisor[best] > 0.0).then(|| (group[best] as usize + best).min(self.columns.depths() - 1))
    }

    /// Slacks p - y . a and products rho . a of one group of columns.
    #[inline(always)]
    fn slack_and_row(
        &self,
        y: &[f64; R],
        rho: &[f64; R],
        start: usize,
        step: u16,
    ) -> ([f64; LANES], [f64; LANES]) {
        let mut slack = costs(start, step);
        let mut alpha = [0.0; LANES];
        for i in 0..R {
            let row = &self.rows[i][start..start + LANES];
            for lane in 0..LANES {
                slack[lane] = (-y[i]).mul_add(row[lane], slack[lane]);
                alpha[lane] = rho[i].mul_add(row[lane], alpha[lane]);
            }
        }
        (slack, alpha)
    }

    /// Least slack over the support and where it is.
    #[inline(always)]
    fn least_slack(&self, y: &[f64; R], step: u16) -> (f64, usize) {
        let mut least = [f64::INFINITY; LANES];
        let mut group = [0.0f64; LANES];
        for start in (0..self.rows[0].len()).step_by(LANES) {
            let mut slack = costs(start, step);
            for i in 0..R {
                let row = &self.rows[i][start..start + LANES];
                for lane in 0..LANES {
                    slack[lane] = (-y[i]).mul_add(row[lane], slack[lane]);
                }
            }
            let at = start as f64;
            for lane in 0..LANES {
                let better = slack[lane] < least[lane];
                least[lane] = if better { slack[lane] } else { least[lane] };
                group[lane] = if better { at } else { group[lane] };
            }
        }
        let mut best = 0;
        for lane in 1..LANES {
            if least[lane] < least[best] {
                best = lane;
            }
        }
        (least[best], (group[best] as usize + best).min(self.columns.depths() - 1))
    }

    /// Primal simplex method for the generic moments from a feasible vertex of another step.
    #[inline(always)]
    fn primal(&mut self, vertex: &mut Vertex<R>, step: u16) -> bool {
        vertex.price(step);
        for pivot in 1..=MAX_PRIMAL_PIVOTS {
            let (least, entering) = self.least_slack(&vertex.dual, step);
            if least >= -SLACK_TOLERANCE {
                return vertex.refresh(self.columns, step).is_some();
            }
            self.pivots += 1;
            let direction = vertex.direction(self.columns.column(entering));
            let Some(row) = blocking_row(&direction, &vertex.weights(&self.generic)) else { return false };
            if vertex.replace(row, entering, self.columns).is_none() {
                return false;
            }
            if pivot % REFRESH == 0 {
                if vertex.refresh(self.columns, step).is_none() {
                    return false;
                }
            } else {
                vertex.price(step);
            }
        }
        false
    }

    /// A feasible vertex for the generic moments: artificial columns are driven out by the primal method.
    #[inline(always)]
    fn phase_one(&mut self) -> Option<Vertex<R>> {
        let sign: [f64; R] = self.generic.map(|b| if b < 0.0 { -1.0 } else { 1.0 });
        let mut inverse = [[0.0; R]; R];
        for (i, row) in inverse.iter_mut().enumerate() {
            row[i] = sign[i];
        }
        let mut vertex = Vertex { index: [u16::MAX; R], inverse, dual: [0.0; R] };
        for _ in 0..MAX_PRIMAL_PIVOTS {
            let Some(_) = vertex.index.iter().position(|&j| j == u16::MAX) else {
                // Only now do costs mean anything.
                return vertex.refresh(self.columns, 0).map(|()| vertex);
            };
            // Cost 1 for artificial columns, 0 for the others: the dual vector sums the rows of the former.
            let mut y = [0.0; R];
            for (row, _) in vertex.inverse.iter().zip(&vertex.index).filter(|(_, j)| **j == u16::MAX) {
                y.iter_mut().zip(row).for_each(|(y, value)| *y += value);
            }
            let (_, entering) = self.least_slack(&y, 0);
            let direction = vertex.direction(self.columns.column(entering));
            let row = blocking_row(&direction, &vertex.weights(&self.generic))?;
            self.pivots += 1;
            vertex.replace(row, entering, self.columns)?;
        }
        None
    }
}

impl<const R: usize> Vertex<R> {
    /// Weights of the basic columns for moments b.
    #[inline(always)]
    fn weights(&self, b: &[f64; R]) -> [f64; R] {
        std::array::from_fn(|r| dot(&self.inverse[r], b))
    }

    /// Weights by which the basic columns make up another column.
    #[inline(always)]
    fn direction(&self, column: &[f64]) -> [f64; R] {
        std::array::from_fn(|r| (0..R).fold(0.0, |sum, i| self.inverse[r][i].mul_add(column[i], sum)))
    }

    /// Replaces the basic column of a row.
    #[inline(always)]
    fn replace(&mut self, row: usize, entering: usize, columns: &SupportColumns) -> Option<()> {
        let direction = self.direction(columns.column(entering));
        let pivot = direction[row];
        if !pivot.is_normal() {
            return None;
        }
        let inverse = 1.0 / pivot;
        let scaled = self.inverse[row].map(|value| value * inverse);
        for r in 0..R {
            for i in 0..R {
                self.inverse[r][i] = (-direction[r]).mul_add(scaled[i], self.inverse[r][i]);
            }
        }
        self.inverse[row] = scaled;
        self.index[row] = entering as u16;
        Some(())
    }

    /// y = p_B B^-1: the sum of the rows of columns in front of z_f.
    #[inline(always)]
    fn price(&mut self, step: u16) {
        let mut y = [0.0; R];
        for r in 0..R {
            let cost: f64 = if self.index[r] < step { 1.0 } else { 0.0 };
            for i in 0..R {
                y[i] = cost.mul_add(self.inverse[r][i], y[i]);
            }
        }
        self.dual = y;
    }

    /// Inverse and dual vector from the columns themselves (Gauss-Jordan elimination with row exchanges).
    #[inline(always)]
    fn refresh(&mut self, columns: &SupportColumns, step: u16) -> Option<()> {
        // Row i of the matrix of basic columns; solving for the identity.
        let mut matrix = [[0.0; R]; R];
        for (r, &j) in self.index.iter().enumerate() {
            let column = columns.column(usize::from(j));
            for i in 0..R {
                matrix[i][r] = column[i];
            }
        }
        let mut inverse = [[0.0; R]; R];
        for (i, row) in inverse.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        for k in 0..R {
            let mut best = k;
            for i in k + 1..R {
                if matrix[i][k].abs() > matrix[best][k].abs() {
                    best = i;
                }
            }
            matrix.swap(k, best);
            inverse.swap(k, best);
            let pivot = matrix[k][k];
            if !pivot.is_normal() {
                return None;
            }
            let factor = 1.0 / pivot;
            matrix[k] = matrix[k].map(|value| value * factor);
            inverse[k] = inverse[k].map(|value| value * factor);
            let (matrix_row, inverse_row) = (matrix[k], inverse[k]);
            for i in 0..R {
                if i != k {
                    let factor = -matrix[i][k];
                    for c in 0..R {
                        matrix[i][c] = factor.mul_add(matrix_row[c], matrix[i][c]);
                        inverse[i][c] = factor.mul_add(inverse_row[c], inverse[i][c]);
                    }
                }
            }
        }
        self.inverse = inverse;
        self.price(step);
        Some(())
    }
}

impl<const R: usize> Cache<R> {
    #[inline(always)]
    fn clear(&mut self) {
        self.vertices.clear();
        self.duals.clear();
        self.lacking.clear();
        self.used.clear();
    }

    /// Adds a vertex and returns its place; a full cache replaces its newest entry.
    #[inline(always)]
    fn insert(&mut self, vertex: &Vertex<R>, lacking: f64) -> usize {
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
    fn best(&self, b: &[f64; R]) -> usize {
        let mut largest = [f64::NEG_INFINITY; LANES];
        let mut group = [0.0f64; LANES];
        for (number, duals) in self.duals.iter().enumerate() {
            let mut value = [0.0; LANES];
            for i in 0..R {
                for lane in 0..LANES {
                    value[lane] = b[i].mul_add(duals[i][lane], value[lane]);
                }
            }
            let at = number as f64;
            for lane in 0..LANES {
                let better = value[lane] > largest[lane];
                largest[lane] = if better { value[lane] } else { largest[lane] };
                group[lane] = if better { at } else { group[lane] };
            }
        }
        let mut best = 0;
        for lane in 1..LANES {
            if largest[lane] > largest[best] {
                best = lane;
            }
        }
        // Lanes beyond the last vertex hold y = 0, which is feasible but no vertex.
        (group[best] as usize * LANES + best).min(self.vertices.len() - 1)
    }
}

/// p over one group of columns.
#[inline(always)]
fn costs(start: usize, step: u16) -> [f64; LANES] {
    std::array::from_fn(|lane| if start + lane < usize::from(step) { 1.0 } else { 0.0 })
}

/// Objective of the weights that are not negative.
#[inline(always)]
fn attained<const R: usize>(vertex: &Vertex<R>, b: &[f64; R], step: u16) -> f64 {
    let weights = vertex.weights(b);
    (0..R).fold(0.0, |sum, r| if vertex.index[r] < step { sum + weights[r].max(0.0) } else { sum })
}

/// The row with the most negative weight relative to the size of its row of the inverse.
#[inline(always)]
fn leaving_row<const R: usize>(vertex: &Vertex<R>, b: &[f64; R]) -> Option<usize> {
    let mut worst = (WEIGHT_TOLERANCE, 1.0, R);
    for r in 0..R {
        let row = &vertex.inverse[r];
        let (mut weight, mut size) = (0.0, 0.0);
        for i in 0..R {
            weight = row[i].mul_add(b[i], weight);
            size += row[i].abs();
        }
        if -weight * worst.1 > worst.0 * size {
            worst = (-weight, size, r);
        }
    }
    (worst.2 < R).then_some(worst.2)
}

/// The row whose weight vanishes first as the entering column grows.
#[inline(always)]
fn blocking_row<const R: usize>(direction: &[f64; R], weights: &[f64; R]) -> Option<usize> {
    let largest = direction.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
    let mut best: Option<(usize, f64)> = None;
    for r in 0..R {
        if direction[r] > PIVOT_TOLERANCE * largest {
            let ratio = weights[r].max(0.0) / direction[r];
            if best.is_none_or(|(_, least)| ratio < least) {
                best = Some((r, ratio));
            }
        }
    }
    best.map(|(row, _)| row)
}

#[inline(always)]
fn dot<const R: usize>(a: &[f64; R], b: &[f64; R]) -> f64 {
    (0..R).fold(0.0, |sum, i| a[i].mul_add(b[i], sum))
}

#[inline(always)]
fn dot_absolute<const R: usize>(a: &[f64; R], b: &[f64; R]) -> f64 {
    (0..R).fold(0.0, |sum, i| a[i].abs().mul_add(b[i].abs(), sum))
}
