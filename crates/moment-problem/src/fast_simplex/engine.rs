//! The simplex method itself, for a fixed number of rows.
//!
//! The dual polytope {y: y . a_j <= p_j} depends on z_f but not on the moments. For each z_f its vertices are kept as
//! they are found; a fragment starts at the vertex that is best for its moments, which often is the optimum. If not,
//! the dual simplex method looks in the neighbourhood. On a fine support it moves each point of contact by one depth a
//! pivot, so what is far away is reached from the distribution itself by the primal method, whose pivots jump.

use super::lanes::Lanes;
use super::pricing::{PIVOT_TOLERANCE, SLACK_TOLERANCE, dot, dot_absolute};
use super::support::{LANES, SupportColumns, SupportDistribution};
use super::vertex::{ARTIFICIAL, Cache, Rows, UNUSED, Vertex};
use super::{FastBound, FastVertex, MAX_GUESSES};

/// A weight counts as negative below minus this times the size of its row of the inverse: some hundred roundings of the
/// products that it is the sum of. Absolute tolerances stall, since rows differ by many orders of magnitude.
pub(super) const WEIGHT_TOLERANCE: f64 = 3e-14;

/// Pivots of the dual method for one fragment.
const MAX_DUAL_PIVOTS: usize = 4;

/// Pivots of the primal method for one fragment; what needs more goes to the exact route.
const MAX_PRIMAL_PIVOTS: usize = 100;

/// Weight given to each basic column at the start of the primal method, once to three times: without it, distributions
/// of few depths would be degenerate and the method might cycle. The optimum moves by some hundred times this at most.
const PERTURBATION: f64 = 1e-10;

/// Pivots of the primal method after which the inverse is computed afresh.
const REFRESH: usize = 12;

/// The solver for one basis of R rows, K vectors of lanes.
pub(super) struct Engine<'a, V: Lanes, const R: usize, const K: usize> {
    pub(super) columns: &'a SupportColumns,
    pub(super) rows: [&'a [[f64; LANES]]; R],
    /// Largest entry of each row.
    pub(super) largest: [f64; R],
    /// p over the support, and the z_f that it belongs to.
    pub(super) costs: Vec<[f64; LANES]>,
    pub(super) step: u16,
    cache: Cache<V, R, K>,
    /// The columns of one distribution, in groups of lanes.
    pub(super) own: Vec<[[f64; LANES]; R]>,
    pub(super) pivots: u64,
    /// The columns where the primal method ended for the present fragment.
    pub(super) last: [u16; R],
}

/// A vertex, and its least slack if that is known.
type Found<V, const R: usize, const K: usize> = (Vertex<V, R, K>, Option<f64>);

/// One fragment: its distribution, moments E[a] and F.
pub(super) struct Job<'a, const R: usize> {
    pub(super) kernel: &'a SupportDistribution,
    pub(super) moments: &'a [f64; R],
    /// Whether a proof of F is enough.
    pub(super) early: bool,
    /// Ascending indices of columns that may be near the optimal ones, or none.
    pub(super) guesses: [&'a [u16]; MAX_GUESSES],
    pub(super) mass_before: f64,
}

impl<'a, V: Lanes, const R: usize, const K: usize> Engine<'a, V, R, K> {
    pub(super) fn new(columns: &'a SupportColumns) -> Self {
        let rows = std::array::from_fn(|i| columns.row(i));
        let entries = |row: &[[f64; LANES]]| row.iter().flatten().fold(0.0, |m: f64, a| m.max(a.abs()));
        Self {
            columns,
            rows,
            largest: rows.map(entries),
            costs: vec![[0.0; LANES]; rows[0].len()],
            step: 0,
            cache: Cache::new(),
            own: Vec::new(),
            pivots: 0,
            last: [ARTIFICIAL; R],
        }
    }

    /// Begins with the fragments at another depth.
    #[inline(always)]
    pub(super) fn begin(&mut self, step: u16) {
        self.cache.clear();
        self.step = step;
        for (group, costs) in self.costs.iter_mut().enumerate() {
            for (lane, cost) in costs.iter_mut().enumerate() {
                *cost = if group * LANES + lane < usize::from(step) { 1.0 } else { 0.0 };
            }
        }
    }

    /// G for one fragment at the present depth; `None` if the exact route has to decide. New entries of `vertices` are
    /// those that bounds refer to.
    #[inline(always)]
    pub(super) fn bound(
        &mut self,
        job: &Job<'_, R>,
        tolerance: f64,
        vertices: &mut Vec<FastVertex>,
    ) -> Option<FastBound> {
        self.last = [ARTIFICIAL; R];
        let b = *job.moments;
        let enough = if job.early { job.mass_before - 0.5 * tolerance } else { f64::INFINITY };
        let found = match self.cache.best(&b) {
            Some(best) if self.is_settled(&self.cache.vertices[best], &b, enough) => best,
            best => {
                let mut guessed = None;
                for guess in job.guesses {
                    if let Some(vertex) = self.shifted(guess, &b) {
                        guessed = self.primal(vertex, &b, enough);
                        break;
                    }
                }
                let near = || self.dual(self.cache.vertices[best?], &b, enough);
                let (vertex, least) = match guessed.or_else(near) {
                    Some(found) => found,
                    None => {
                        let vertex = self.reduced(job.kernel, &b)?;
                        self.primal(vertex, &b, enough)?
                    }
                };
                let least = least.unwrap_or_else(|| self.least(&vertex.dual));
                let lacking = self.lacking(&vertex.dual, least);
                self.cache.insert(&vertex, lacking)
            }
        };
        let vertex = &self.cache.vertices[found];
        let value = dot(&vertex.dual, &b);
        let rounding = (R + 2) as f64 * f64::EPSILON * dot_absolute(&vertex.dual, &b);
        let lower_proved = (value - self.cache.lacking[found] - rounding).max(0.0);
        let attained = if value >= enough { job.mass_before } else { self.attained(vertex, &b) };
        let attained = attained.clamp(0.0, job.mass_before.max(lower_proved));
        if attained - lower_proved > tolerance {
            return None;
        }
        if self.cache.used[found] == UNUSED {
            self.cache.used[found] = vertices.len() as u32;
            let mut padded = FastVertex { step: self.step, ..FastVertex::default() };
            padded.dual[..R].copy_from_slice(&vertex.dual);
            padded.support[..R].copy_from_slice(&vertex.index);
            padded.support[..R].sort_unstable();
            padded.rank = R as u8;
            padded.lacking = self.cache.lacking[found];
            vertices.push(padded);
        }
        Some(FastBound { lower: attained, lower_proved, vertex: self.cache.used[found] })
    }

    /// Whether a vertex is optimal for moments b, or proves as much as can be.
    #[inline(always)]
    fn is_settled(&self, vertex: &Vertex<V, R, K>, b: &[f64; R], enough: f64) -> bool {
        dot(&vertex.dual, b) >= enough || vertex.negative_row(&vertex.solve(b), WEIGHT_TOLERANCE).is_none()
    }

    /// An upper bound of G: the objective of the vertex's weights, and what the error of their moments can make up.
    ///
    /// The inverse may have drifted; its error is squared once by iterative refinement.
    #[inline(always)]
    fn attained(&self, vertex: &Vertex<V, R, K>, b: &[f64; R]) -> f64 {
        let mut weights = vertex.solve(b);
        let residual = self.residual(vertex, &weights, b);
        let correction = vertex.solve(&residual);
        let mut objective = 0.0;
        for k in 0..K {
            weights[k] = V::zero().max(weights[k].add(correction[k]));
        }
        for r in 0..R {
            objective += if vertex.index[r] < self.step { weights[r / LANES].lane(r) } else { 0.0 };
        }
        let residual = self.residual(vertex, &weights, b);
        // y . b is at most the objective plus y . residual for a feasible y, this one among them.
        objective + dot_absolute(&vertex.dual, &residual)
    }

    /// b - B w.
    #[inline(always)]
    fn residual(&self, vertex: &Vertex<V, R, K>, weights: &Rows<V, K>, b: &[f64; R]) -> [f64; R] {
        let mut residual = [V::zero(); K];
        let mut padded = [[0.0; LANES]; K];
        padded.as_flattened_mut()[..R].copy_from_slice(b);
        for k in 0..K {
            residual[k] = V::load(&padded[k]);
        }
        for r in 0..R {
            let weight = V::splat(weights[r / LANES].lane(r));
            let column = self.columns.column(usize::from(vertex.index[r])).as_chunks::<LANES>().0;
            for k in 0..K {
                residual[k] = weight.neg_mul_add(V::load(&column[k]), residual[k]);
            }
        }
        for k in 0..K {
            residual[k].store(&mut padded[k]);
        }
        let mut result = [0.0; R];
        result.copy_from_slice(&padded.as_flattened()[..R]);
        result
    }

    /// Slack that a dual vector provably does not lack anywhere on the support.
    #[inline(always)]
    fn lacking(&self, y: &[f64; R], least: f64) -> f64 {
        (-least).max(0.0) + (R + 2) as f64 * f64::EPSILON * (1.0 + dot_absolute(y, &self.largest))
    }

    /// Dual simplex method from a dual feasible vertex, until the weights are not negative or the value is enough.
    #[inline(always)]
    fn dual(&mut self, mut vertex: Vertex<V, R, K>, b: &[f64; R], enough: f64) -> Option<Found<V, R, K>> {
        for _ in 0..MAX_DUAL_PIVOTS {
            let Some(row) = vertex.negative_row(&vertex.solve(b), WEIGHT_TOLERANCE) else {
                return Some((vertex, None));
            };
            let (entering, slack) = self.entering(&vertex.dual, &vertex.row(row))?;
            self.pivots += 1;
            let direction = vertex.solve(self.columns.column(entering));
            vertex.replace(row, entering, &direction, slack)?;
            if dot(&vertex.dual, b) >= enough {
                return Some((vertex, None));
            }
        }
        vertex.negative_row(&vertex.solve(b), WEIGHT_TOLERANCE).is_none().then_some((vertex, None))
    }

    /// Primal simplex method, from a basis without negative weights to the optimum.
    #[inline(always)]
    fn primal(&mut self, mut vertex: Vertex<V, R, K>, b: &[f64; R], enough: f64) -> Option<Found<V, R, K>> {
        let mut weights = vertex.solve(b);
        for (k, weights) in weights.iter_mut().enumerate() {
            let mut extra = [0.0; LANES];
            for (lane, extra) in extra.iter_mut().enumerate() {
                let r = k * LANES + lane;
                *extra =
                    if r < R { PERTURBATION * (1.0 + (r * 7 % R) as f64 * (2.0 / R as f64)) } else { 0.0 };
            }
            *weights = V::zero().max(*weights).add(V::load(&extra));
        }
        let perturbed = self.moments_of(&vertex, &weights);
        vertex.price(self.step);
        for pivot in 1..=MAX_PRIMAL_PIVOTS {
            let (least, entering) = self.least_slack(&vertex.dual);
            if least >= -SLACK_TOLERANCE {
                return self.polished(vertex, least, b, enough);
            }
            self.pivots += 1;
            self.enter(&mut vertex, &mut weights, entering, least)?;
            if pivot % REFRESH == 0 {
                vertex.invert(self.columns)?;
                vertex.price(self.step);
                weights = vertex.solve(&perturbed).map(|w| V::zero().max(w));
            }
        }
        None
    }

    /// The optimum for b near that for perturbed moments.
    #[inline(always)]
    fn polished(
        &mut self,
        vertex: Vertex<V, R, K>,
        least: f64,
        b: &[f64; R],
        enough: f64,
    ) -> Option<Found<V, R, K>> {
        self.last = vertex.index;
        if vertex.negative_row(&vertex.solve(b), WEIGHT_TOLERANCE).is_none() {
            return Some((vertex, Some(least)));
        }
        self.dual(vertex, b, enough)
    }

    /// Brings a column into a feasible basis.
    #[inline(always)]
    pub(super) fn enter(
        &self,
        vertex: &mut Vertex<V, R, K>,
        weights: &mut Rows<V, K>,
        entering: usize,
        slack: f64,
    ) -> Option<()> {
        let direction = vertex.solve(self.columns.column(entering));
        let mut largest = V::zero();
        for k in 0..K {
            largest = largest.max(direction[k].abs());
        }
        let most = -V::zero().add(largest.mul(V::splat(-1.0))).least().0;
        let floor = V::splat(PIVOT_TOLERANCE * most);
        let mut blocking = (f64::INFINITY, None);
        for k in 0..K {
            let ratio = weights[k].div(direction[k]);
            let (least, lane) = floor.where_less(direction[k], ratio, V::splat(f64::INFINITY)).least();
            if least < blocking.0 {
                blocking = (least, Some(k * LANES + lane));
            }
        }
        let (level, row) = (blocking.0, blocking.1?);
        for k in 0..K {
            weights[k] = V::zero().max(V::splat(level).neg_mul_add(direction[k], weights[k]));
        }
        let mut entry = [0.0; LANES];
        weights[row / LANES].store(&mut entry);
        entry[row % LANES] = level;
        weights[row / LANES] = V::load(&entry);
        vertex.replace(row, entering, &direction, slack)
    }

    /// B w.
    #[inline(always)]
    fn moments_of(&self, vertex: &Vertex<V, R, K>, weights: &Rows<V, K>) -> [f64; R] {
        let mut sum = [0.0; R];
        for r in 0..R {
            let column = self.columns.column(usize::from(vertex.index[r]));
            let weight = weights[r / LANES].lane(r);
            for i in 0..R {
                sum[i] = weight.mul_add(column[i], sum[i]);
            }
        }
        sum
    }
}
