//! Certified lower bounds by the hundred million: MSM15 Algorithm 1 with one program in each lane of a vector.
//!
//! The same programs as [`fast_simplex`](crate::fast_simplex) solves, for bases of up to four functions. Nothing but the
//! ascending basic columns of a program is carried from one stage to the next, and all stages but the last are written over
//! vectors with one program a lane:
//!
//! 1. moments of all kernels by one small product ([`FunctionSpan`]);
//! 2. Newton's method for points of contact, from the optima of two other bases;
//! 3. the certificate: the dual vector of the basis over the whole support. Two programs of three end here;
//! 4. the primal simplex method for the others, first for one in eight of them; Newton's method from the optima of these may
//!    give similar programs a better start. Few columns are priced first, then the best is improved, and only where
//!    nothing is found the neighbours of the basic columns are asked; then the certificate again;
//! 5. once more with all columns priced, for one of a thousand;
//! 6. the simplex method in double-double from the basis that was found, for what double precision cannot certify.
//!
//! A lane that is done takes the next program, and nothing that a lane computes depends on the others: results are the same to
//! the bit for all vector widths.

// Loops run over several small arrays by one index, and closures of iterator chains are not always compiled for the
// vector width of the function that they are in.
#![allow(clippy::needless_range_loop)]
// Unrolled blocks stand behind a condition that is false where an array ends.
#![allow(unconditional_panic)]

mod batch;
mod certificate;
mod exact;
mod factors;
mod lanes;
mod newton;
mod pairs;
mod pivots;
mod span;
#[cfg(target_arch = "x86_64")]
mod vectors;
mod width;

pub use batch::{LaneStarts, ProgramBatch};
pub use exact::{ExactBound, ExactSimplex};
use factors::WeightTolerances;
use lanes::{Lanes, Quad};
use pivots::Pricing;
pub use span::{FunctionSpan, Rounding, SpanColumns};
use width::{CHAINS, Width};

/// Largest number of functions of a basis.
pub const MAX_FUNCTIONS: usize = 4;

/// Programs that go through all stages together: what they need stays in the second-level cache.
const CHUNK: usize = 8192;

/// One in so many of the programs that Newton's method does not settle is solved first and gives a start to its neighbours.
const SEEDED: usize = 8;

/// Bounds in the order of the programs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BatchSolution {
    /// Number of rows of the basis.
    pub rank: usize,
    /// G, the objective of weights on the support, or what is proved where that is F to the tolerance.
    pub lower: Vec<f64>,
    /// Proved: no distribution on the support with these moments has less mass before z_f.
    pub proved: Vec<f64>,
    /// Ascending basic columns, `rank` for each program.
    pub supports: Vec<u16>,
    /// Simplex pivots in double precision.
    pub pivots: u64,
    /// Programs that the double-double route decided.
    pub exact: usize,
    /// Programs that nobody could certify; what is proved for them holds, but is not sharp to the tolerance.
    pub uncertified: Vec<usize>,
}

/// The solver for one basis.
#[derive(Clone, Copy, Debug)]
pub struct LaneSimplex<'a> {
    columns: &'a SpanColumns,
    tolerance: f64,
    width: Width,
    weight_tolerances: WeightTolerances,
}

impl<'a> LaneSimplex<'a> {
    /// A solver whose bounds differ from what is proved by at most `tolerance`, such as 1e-6; `None` for bases of more than
    /// [`MAX_FUNCTIONS`] independent functions.
    pub fn new(columns: &'a SpanColumns, tolerance: f64) -> Option<Self> {
        let served = columns.columns.rank() <= MAX_FUNCTIONS + 1;
        served.then(|| Self {
            columns,
            tolerance,
            width: Width::widest(),
            weight_tolerances: WeightTolerances::DEFAULT,
        })
    }

    /// The same with other vectors that this machine has, the widest first, for comparison.
    pub fn widths(self) -> impl Iterator<Item = (&'static str, Self)> {
        Width::all().into_iter().map(move |width| (width.name(), Self { width, ..self }))
    }

    /// Bounds for the programs of a batch.
    ///
    /// # Panics
    /// If the starts are for another rank or number of programs, or the batch for another span's support.
    pub fn solve(&self, batch: &ProgramBatch<'_>, starts: &LaneStarts) -> BatchSolution {
        let rank = self.columns.columns.rank();
        assert_eq!(starts.rank, rank, "starts for another rank");
        assert_eq!(starts.guesses[0].len(), rank * batch.len(), "starts for other programs");
        match rank {
            2 => self.run::<1, 2>(batch, starts),
            3 => self.run::<2, 3>(batch, starts),
            4 => self.run::<3, 4>(batch, starts),
            _ => self.run::<4, 5>(batch, starts),
        }
    }

    fn run<const D: usize, const R: usize>(
        &self,
        batch: &ProgramBatch<'_>,
        starts: &LaneStarts,
    ) -> BatchSolution {
        let columns = &self.columns.columns;
        let table: Vec<Quad> = (0..columns.depths())
            .map(|j| Quad(std::array::from_fn(|i| if i < D { columns.column(j)[i + 1] } else { 0.0 })))
            .collect();
        let errors = self.columns.rounding(batch, self.columns.transform.len().div_ceil(CHAINS) + 2);
        let exact = ExactSimplex::new(columns);
        let guesses = [&starts.guesses[0], &starts.guesses[1]].map(|guesses| guesses.as_chunks::<R>().0);
        let count = batch.len();
        let mut solution = BatchSolution {
            rank: R,
            lower: vec![0.0; count],
            proved: vec![0.0; count],
            supports: vec![0; R * count],
            ..BatchSolution::default()
        };
        let mut moments = vec![Quad::default(); CHUNK.min(count)];
        for start in (0..count).step_by(CHUNK) {
            let range = start..(start + CHUNK).min(count);
            let moments = &mut moments[..range.len()];
            self.width.moments(
                &self.columns.transform,
                &batch.coordinates,
                &batch.rows[range.clone()],
                moments,
            );
            let mut work = Work::<R> {
                table: &table,
                errors,
                tolerance: self.tolerance,
                weight_tolerances: self.weight_tolerances,
                depths: &batch.depths[range.clone()],
                steps: &batch.steps[range.clone()],
                masses: &batch.masses[range.clone()],
                norms: &batch.norms[range.clone()],
                guesses: guesses.map(|guesses| &guesses[range.clone()]),
                similar: &starts.similar[range.clone()],
                moments,
                supports: &mut solution.supports.as_chunks_mut::<R>().0[range.clone()],
                lower: &mut solution.lower[range.clone()],
                proved: &mut solution.proved[range.clone()],
                pivots: 0,
                rest: Vec::new(),
            };
            self.width.solve::<D, R>(&mut work);
            solution.pivots += work.pivots;
            for program in std::mem::take(&mut work.rest) {
                let at = program as usize;
                let fragment = &batch.fragments[start + at];
                let kernel = &batch.kernels[fragment.kernel as usize];
                solution.exact += 1;
                let found = exact.bound(kernel, fragment.step, fragment.mass_before, &work.supports[at]);
                let certified =
                    found.as_ref().is_some_and(|bound| bound.lower - bound.proved <= self.tolerance);
                if let Some(bound) = found {
                    work.lower[at] = bound.lower;
                    work.proved[at] = bound.proved;
                    work.supports[at].copy_from_slice(&bound.support);
                }
                if !certified {
                    solution.uncertified.push(start + at);
                }
            }
        }
        solution
    }
}

/// A chunk of programs on its way.
struct Work<'a, const R: usize> {
    table: &'a [Quad],
    errors: Rounding,
    tolerance: f64,
    weight_tolerances: WeightTolerances,
    /// Depths of kernels that have few.
    depths: &'a [[u16; pairs::MAX_RANK]],
    steps: &'a [u16],
    masses: &'a [f64],
    norms: &'a [f64],
    guesses: [&'a [[u16; R]]; 2],
    /// All programs, similar ones side by side.
    similar: &'a [u32],
    moments: &'a [Quad],
    supports: &'a mut [[u16; R]],
    lower: &'a mut [f64],
    proved: &'a mut [f64],
    pivots: u64,
    /// Programs that the exact route has to decide, ascending.
    rest: Vec<u32>,
}

impl<const R: usize> Work<'_, R> {
    fn count(&self) -> usize {
        self.steps.len()
    }

    /// Whether the basis of a program holds all depths of its kernel: then its weights are the kernel's and 0, whatever rounding
    /// says.
    fn is_distribution_of(&self, program: usize) -> bool {
        let support = &self.supports[program];
        self.depths[program].iter().all(|depth| support.contains(depth))
    }

    /// Columns for lanes that have no program yet.
    fn spread(&self) -> [u16; R] {
        let mut columns = [0; R];
        columns.copy_from_slice(&batch::spread(self.table.len(), R));
        columns
    }
}

#[inline(always)]
fn solve<V: Lanes, const D: usize, const R: usize>(work: &mut Work<'_, R>) {
    newton::newton::<V, D, R>(work);
    let mut rest = Vec::new();
    let mut list: Vec<u32> = (0..work.count() as u32).collect();
    let mut open = Vec::new();
    certificate::certify::<V, D, R>(work, &list, &mut open, &mut rest);
    let (seeds, others) = seeded(work, &open);
    pivots::pivots::<V, D, R>(work, &seeds, Pricing::Coarse);
    newton::from_seeds::<V, D, R>(work, &others);
    list.clear();
    list.extend(others.iter().map(|(program, _)| program));
    pivots::pivots::<V, D, R>(work, &list, Pricing::Coarse);
    list.clear();
    certificate::certify::<V, D, R>(work, &open, &mut list, &mut rest);
    open.clear();
    pivots::pivots::<V, D, R>(work, &list, Pricing::Full);
    certificate::certify::<V, D, R>(work, &list, &mut open, &mut rest);
    rest.extend(open);
    rest.sort_unstable();
    work.rest = rest;
}

/// A program and seeds for it.
type Seeded = (u32, [u32; 2]);

/// Divides programs into seeds and others, each with the nearest seeds of the same depth before and behind it.
fn seeded<const R: usize>(work: &Work<'_, R>, open: &[u32]) -> (Vec<u32>, Vec<Seeded>) {
    let mut is_open = vec![false; work.count()];
    open.iter().for_each(|&program| is_open[program as usize] = true);
    let sorted: Vec<u32> =
        work.similar.iter().copied().filter(|&program| is_open[program as usize]).collect();
    let seeds: Vec<u32> = sorted.iter().copied().step_by(SEEDED).collect();
    let mut others = Vec::with_capacity(sorted.len());
    for (group, programs) in sorted.chunks(SEEDED).enumerate() {
        let (before, behind) = (seeds[group], seeds.get(group + 1).copied());
        for (place, &program) in programs.iter().enumerate().skip(1) {
            let alike = |seed: &u32| work.steps[*seed as usize] == work.steps[program as usize];
            let mut pair = [Some(before), behind].map(|seed| seed.filter(alike).unwrap_or(newton::NONE));
            if place > SEEDED / 2 {
                pair.swap(0, 1);
            }
            others.push((program, pair));
        }
    }
    (seeds, others)
}

#[cfg(test)]
#[path = "../../tests/programs/mod.rs"]
mod programs;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Basis;
    use crate::fast_simplex::{FastSimplex, FunctionTable, SupportColumns};

    /// Dual vectors of 1e10 turn a weight that is negative by some roundings of 1 into an error that shows.
    #[test]
    fn an_absolute_tolerance_of_weights_would_accept_wrong_bounds() {
        let functions = ["z^2", "z^8", "exp(-2z)", "cos(3pi z)"].map(|f| f.parse().unwrap());
        let depths = FunctionTable::uniform_depths(256);
        let span = FunctionSpan::new(&FunctionTable::new(&functions, &depths).unwrap());
        let (kernels, fragments) = programs::narrow(20_000);
        let batch = ProgramBatch::new(&span, &kernels, &fragments);
        let columns = span.columns(&[0, 1, 2, 3]).unwrap();
        let power = FunctionTable::new(Basis::power(4).functions(), &depths).unwrap();
        let power = SupportColumns::new(&power, &[0, 1, 2, 3]).unwrap();
        let start = FastSimplex::new(&power, 1e-6).thorough().solve(&kernels, &fragments).start();
        let starts = LaneStarts::new(&batch, [&start, &start], 5);
        let solve = |weight_tolerances: WeightTolerances| {
            let solver = LaneSimplex { weight_tolerances, ..LaneSimplex::new(&columns, 1e-6).unwrap() };
            let solution = solver.solve(&batch, &starts);
            assert!(solution.uncertified.is_empty());
            solution.lower
        };
        // These bounds follow from their bases in rational arithmetic, see the other tests.
        let right = solve(WeightTolerances::DEFAULT);
        let planted =
            solve(WeightTolerances { absolute: 2e-14, doubt: f64::MIN, ..WeightTolerances::DEFAULT });
        let wrong =
            planted.iter().zip(&right).filter(|(a, b)| (*a - *b).is_nan() || (*a - *b).abs() > 2e-6).count();
        assert!(wrong > 0, "the planted tolerance goes unnoticed");
    }
}
