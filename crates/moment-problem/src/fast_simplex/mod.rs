//! Certified lower bounds by the million: MSM15 Algorithm 1 on one finite support for many kernels.
//!
//! The candidate search of MSM15 section 3.2 solves the same small linear program over and over: 2 to 9 rows, one
//! support, ever new moments. [`FastSimplex`] keeps what does not change. For one basis and one z_f the dual polytope
//! {y: y . a(z_j) <= p_j for all j} is always the same, so its vertices are kept, each with a bound on what it may lack
//! of feasibility; y . b of any of them is a proved lower bound. A new fragment starts at the vertex that is best for
//! it and is done at once if the weights there are not negative, or if y . b has reached F, which no lower bound
//! exceeds. Otherwise the dual simplex method goes on from there.
//!
//! Everything is `f64` over rows that were made orthonormal in double-double. What cannot be certified to the
//! tolerance is decided by the simplex method of [`ExchangeSimplex`](crate::ExchangeSimplex) in double-double on the
//! same support, and is counted.

// Loops run over several small arrays by one index, and closures of iterator chains are not always compiled for the
// vector width of the function that they are in.
#![allow(clippy::needless_range_loop)]

mod engine;
mod exact;
mod lanes;
mod pricing;
mod start;
pub(crate) mod support;
mod vertex;

use crate::arithmetic::DoubleDouble;
use engine::{Engine, Job};
pub(crate) use exact::bound as exact_bound;
pub use exact::{good_lp_bound, reference_bound};
use lanes::{Lanes, Portable};
use serde::{Deserialize, Serialize};
pub use support::{FunctionTable, SupportColumns, SupportDistribution, snap};

/// Largest number of rows: 1 and eight functions.
pub const MAX_ROWS: usize = 9;

/// Solutions for other bases that are looked at.
const MAX_GUESSES: usize = 2;

/// A fragment: which distribution, at which depth of the support.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FastFragment {
    /// Index of its distribution.
    pub kernel: u32,
    /// z_f as an index into the support.
    pub step: u16,
    /// F = Z(z < z_f), see [`SupportDistribution::cdf`].
    pub mass_before: f64,
}

/// A lower bound with its proof.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FastBound {
    /// G, the objective of weights on the support; F where the proof has reached it to the tolerance.
    pub lower: f64,
    /// Proved: no distribution on the support with these moments has less mass before z_f.
    pub lower_proved: f64,
    /// Index of the vertex that proves it in [`FastSolution::vertices`].
    pub vertex: u32,
}

/// A vertex of the dual polytope: the certificate of all bounds that refer to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FastVertex {
    /// z_f as an index into the support.
    pub step: u16,
    /// y over the orthonormal rows, zero beyond the rank.
    pub dual: [f64; MAX_ROWS],
    /// What `dual` lacks of y, zero unless the exact route found it.
    pub dual_low: [f64; MAX_ROWS],
    /// Ascending indices of the basic depths, 0 beyond the rank.
    pub support: [u16; MAX_ROWS],
    /// Number of rows.
    pub rank: u8,
    /// y . a(z_j) - p_j is at most this on the support, rounding included.
    pub lacking: f64,
}

impl FastVertex {
    /// y . a(z_j) - p_j in double-double: how far the dual vector passes the step at a depth of the support. Whoever
    /// does not trust a bound checks that this is at most `lacking` for all j.
    ///
    /// # Panics
    /// If the support has no depth j.
    pub fn excess(&self, columns: &SupportColumns, j: usize) -> f64 {
        let cost = if j < usize::from(self.step) { 1.0 } else { 0.0 };
        let mut sum = DoubleDouble::from(-cost);
        for (i, &a) in columns.column(j)[..columns.rank()].iter().enumerate() {
            let y = DoubleDouble::from(self.dual[i]) + DoubleDouble::from(self.dual_low[i]);
            sum = sum + y * DoubleDouble::from(a);
        }
        sum.to_f64()
    }
}

/// Bounds in the order of the fragments, and their certificates.
#[derive(Clone, Debug, Default)]
pub struct FastSolution {
    /// One bound for each fragment.
    pub bounds: Vec<FastBound>,
    /// Certificates.
    pub vertices: Vec<FastVertex>,
    /// Simplex pivots.
    pub pivots: u64,
    /// Fragments that the exact route decided.
    pub exact: usize,
    /// Fragments that nobody could certify, by index; their bounds hold but are not sharp to the tolerance.
    pub uncertified: Vec<usize>,
}

/// Where the distributions of a solution lie: what another basis needs of it, a twentieth of its memory.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
pub struct FastStart {
    rank: usize,
    /// Ascending indices of the basic depths, `rank` for each fragment; all 0 where there is no vertex of that rank.
    supports: Vec<u16>,
}

impl FastStart {
    /// Number of fragments.
    pub fn len(&self) -> usize {
        self.supports.len() / self.rank.max(1)
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.supports.is_empty()
    }

    /// The depths for a fragment, if the rank is that of the basis to be solved.
    pub(crate) fn guess(&self, fragment: usize, rank: usize) -> &[u16] {
        let depths =
            if rank == self.rank { &self.supports[fragment * rank..(fragment + 1) * rank] } else { &[] };
        if depths.iter().any(|&depth| depth > 0) { depths } else { &[] }
    }
}

impl FastSolution {
    /// The start for other bases of the same rank.
    pub fn start(&self) -> FastStart {
        let rank = usize::from(self.vertices.iter().map(|vertex| vertex.rank).max().unwrap_or(1));
        let none = [0; MAX_ROWS];
        let supports = self.bounds.iter().flat_map(|bound| {
            let vertex = self.vertices.get(bound.vertex as usize);
            let support = vertex.filter(|v| usize::from(v.rank) == rank).map_or(&none, |v| &v.support);
            support[..rank].iter().copied()
        });
        FastStart { rank, supports: supports.collect() }
    }
}

/// The solver for one basis on one support.
#[derive(Clone, Copy, Debug)]
pub struct FastSimplex<'a> {
    columns: &'a SupportColumns,
    tolerance: f64,
    early: bool,
    width: Width,
}

/// How wide the vectors are that the solver was compiled for. Results are the same for all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Width {
    #[cfg(target_arch = "x86_64")]
    Avx2,
    Portable,
}

impl Width {
    fn widest() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                return Self::Avx2;
            }
        }
        Self::Portable
    }
}

impl<'a> FastSimplex<'a> {
    /// A solver whose bounds differ from what is proved by at most `tolerance`, such as 1e-6.
    pub fn new(columns: &'a SupportColumns, tolerance: f64) -> Self {
        Self { columns, tolerance, early: true, width: Width::widest() }
    }

    /// The same, but each program is solved to its optimal vertex even where F is proved before: a better start for
    /// [`FastSimplex::solve_near`].
    pub fn thorough(self) -> Self {
        Self { early: false, ..self }
    }

    /// The same with the portable code path, for comparison.
    pub fn portable(self) -> Self {
        Self { width: Width::Portable, ..self }
    }

    /// Bounds for fragments of `kernels` in ascending order of `step` (any order works, but it costs time).
    ///
    /// The result depends on the input alone, not on the machine's vector width.
    ///
    /// # Panics
    /// If a fragment names a kernel or a step that does not exist.
    pub fn solve(&self, kernels: &[SupportDistribution], fragments: &[FastFragment]) -> FastSolution {
        self.run(kernels, fragments, &[])
    }

    /// The same, starting at solutions for other bases of the same rank, tried in turn: the depths of an optimal
    /// distribution depend little on the basis. Where none of them helps, a program starts from the distribution itself.
    ///
    /// # Panics
    /// As [`FastSimplex::solve`], and if a start is not one for these fragments.
    pub fn solve_near(
        &self,
        kernels: &[SupportDistribution],
        fragments: &[FastFragment],
        others: &[&FastStart],
    ) -> FastSolution {
        let fits = |other: &&FastStart| other.len() == fragments.len();
        assert!(others.iter().all(fits), "a start is one for other fragments");
        self.run(kernels, fragments, others)
    }

    fn run(
        &self,
        kernels: &[SupportDistribution],
        fragments: &[FastFragment],
        others: &[&FastStart],
    ) -> FastSolution {
        let task = Task {
            columns: self.columns,
            tolerance: self.tolerance,
            early: self.early,
            kernels,
            fragments,
            others,
        };
        let (mut solution, hints) = match self.width {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the features were detected when the width was chosen.
            Width::Avx2 => unsafe { solve_avx2(&task) },
            Width::Portable => solve_portable(&task),
        };
        exact::settle(&task, &mut solution, &hints);
        solution
    }
}

/// For each uncertified fragment the columns of bases near the optimum, one after the other.
type Hints = Vec<Vec<u16>>;

/// What is to be solved.
struct Task<'a> {
    columns: &'a SupportColumns,
    tolerance: f64,
    early: bool,
    kernels: &'a [SupportDistribution],
    fragments: &'a [FastFragment],
    others: &'a [&'a FastStart],
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn solve_avx2(task: &Task<'_>) -> (FastSolution, Hints) {
    by_rank::<lanes::Avx2>(task)
}

fn solve_portable(task: &Task<'_>) -> (FastSolution, Hints) {
    by_rank::<Portable>(task)
}

#[inline(always)]
fn by_rank<V: Lanes>(task: &Task<'_>) -> (FastSolution, Hints) {
    match task.columns.rank() {
        2 => solve::<V, 2, 1>(task),
        3 => solve::<V, 3, 1>(task),
        4 => solve::<V, 4, 1>(task),
        5 => solve::<V, 5, 1>(task),
        6 => solve::<V, 6, 1>(task),
        7 => solve::<V, 7, 1>(task),
        8 => solve::<V, 8, 1>(task),
        _ => solve::<V, 9, 2>(task),
    }
}

#[inline(always)]
fn solve<V: Lanes, const R: usize, const K: usize>(task: &Task<'_>) -> (FastSolution, Hints) {
    let mut hints = Hints::new();
    let mut solution =
        FastSolution { bounds: Vec::with_capacity(task.fragments.len()), ..FastSolution::default() };
    let leading = |moments: [f64; MAX_ROWS]| -> [f64; R] { std::array::from_fn(|i| moments[i]) };
    let moments: Vec<[f64; R]> =
        task.kernels.iter().map(|kernel| leading(task.columns.moments(kernel))).collect();
    let mut engine = Engine::<V, R, K>::new(task.columns);
    let mut present = None;
    for (index, fragment) in task.fragments.iter().enumerate() {
        if present != Some(fragment.step) {
            present = Some(fragment.step);
            engine.begin(fragment.step);
        }
        let kernel = fragment.kernel as usize;
        let mut guesses: [&[u16]; MAX_GUESSES] = [&[]; MAX_GUESSES];
        for (guess, other) in guesses.iter_mut().zip(task.others) {
            *guess = other.guess(index, R);
        }
        let job = Job {
            kernel: &task.kernels[kernel],
            moments: &moments[kernel],
            guesses,
            early: task.early,
            mass_before: fragment.mass_before,
        };
        let bound = engine.bound(&job, task.tolerance, &mut solution.vertices);
        if bound.is_none() {
            solution.uncertified.push(index);
            let mut places = Vec::new();
            places.extend_from_slice(&engine.last);
            guesses.iter().for_each(|guess| places.extend_from_slice(guess));
            hints.push(places);
        }
        solution.bounds.push(bound.unwrap_or_default());
    }
    solution.pivots = engine.pivots;
    (solution, hints)
}
