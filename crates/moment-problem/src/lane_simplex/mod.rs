//! Certified lower bounds by the hundred million: MSM15 Algorithm 1 with one program in each lane of a vector.
//!
//! The same programs as [`fast_simplex`](crate::fast_simplex) solves, for bases of up to four functions. Nothing but the
//! ascending basic columns of a program is carried from one stage to the next, and all stages but the last are written over
//! vectors with one program a lane:
//!
//! 1. moments of all kernels by one small product ([`FunctionSpan`]);
//! 2. Newton's method for points of contact, from the optima of two other bases;
//! 3. the certificate: the dual vector of the basis over the whole support. Two programs of three end here;
//! 4. the primal simplex method for the others. Few columns are priced first, then the best is improved, and only where
//!    nothing is found the neighbours of the basic columns are asked; then the certificate again;
//! 5. once more with all columns priced, for one of a thousand;
//! 6. the simplex method in double-double from the basis that was found, for what double precision cannot certify.
//!
//! A lane that is done takes the next program. What a program gives does not depend on its neighbours, so results are the same
//! for all vector widths, orders and divisions of a batch.

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
mod pivots;
mod span;
#[cfg(target_arch = "x86_64")]
mod vectors;
mod width;

pub use batch::{LaneStarts, ProgramBatch};
use exact::ExactRoute;
use lanes::{Lanes, Quad};
use pivots::Pricing;
pub use span::{FunctionSpan, SpanColumns};
use width::{CHAINS, Width};

/// Largest number of functions of a basis.
pub const MAX_FUNCTIONS: usize = 4;

/// Programs that go through all stages together: what they need stays in the second-level cache.
const CHUNK: usize = 8192;

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
}

impl<'a> LaneSimplex<'a> {
    /// A solver whose bounds differ from what is proved by at most `tolerance`, such as 1e-6; `None` for bases of more than
    /// [`MAX_FUNCTIONS`] independent functions.
    pub fn new(columns: &'a SpanColumns, tolerance: f64) -> Option<Self> {
        let served = columns.columns.rank() <= MAX_FUNCTIONS + 1;
        served.then(|| Self { columns, tolerance, width: Width::widest() })
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
        let errors = Errors::new(&table, &self.columns.transform, batch);
        let exact = ExactRoute::new(columns);
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
            self.width.moments(&self.columns.transform, &batch.coordinates, &batch.rows[range.clone()], moments);
            let mut work = Work::<R> {
                table: &table,
                errors,
                tolerance: self.tolerance,
                steps: &batch.steps[range.clone()],
                masses: &batch.masses[range.clone()],
                guesses: guesses.map(|guesses| &guesses[range.clone()]),
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

/// What rounding may do to a dual function, for each unit of the dual vector.
#[derive(Clone, Copy, Debug)]
struct Errors {
    /// By row behind that of ones.
    rows: [f64; 4],
    mass: f64,
}

impl Errors {
    fn new(table: &[Quad], transform: &[Quad], batch: &ProgramBatch<'_>) -> Self {
        // Products of the dual function at a column, and of y . b: five operations at most, each with half an epsilon.
        const OPERATIONS: f64 = 8.0 * f64::EPSILON;
        // Rounding of coordinates and factors, then a chain of products for each moment.
        let chain = (transform.len().div_ceil(CHAINS) + 5) as f64 * 0.5 * f64::EPSILON;
        let rows = std::array::from_fn(|i| {
            let largest = table.iter().fold(0.0, |most: f64, column| most.max(column.0[i].abs()));
            let terms = transform.iter().zip(&batch.largest);
            let sum: f64 = terms.map(|(factor, largest)| factor.0[i].abs() * largest).sum();
            OPERATIONS * largest + chain * sum
        });
        Self { rows, mass: OPERATIONS + batch.mass_error }
    }
}

/// A chunk of programs on its way.
struct Work<'a, const R: usize> {
    table: &'a [Quad],
    errors: Errors,
    tolerance: f64,
    steps: &'a [u16],
    masses: &'a [f64],
    guesses: [&'a [[u16; R]]; 2],
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
    for pricing in [Pricing::Coarse, Pricing::Full] {
        std::mem::swap(&mut list, &mut open);
        open.clear();
        pivots::pivots::<V, D, R>(work, &list, pricing);
        certificate::certify::<V, D, R>(work, &list, &mut open, &mut rest);
    }
    rest.extend(open);
    rest.sort_unstable();
    work.rest = rest;
}
