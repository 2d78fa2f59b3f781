//! Many programs on one support, in the form in which the solver walks through them.

use super::CHUNK;
use super::pairs::MAX_RANK;
use super::span::FunctionSpan;
use crate::fast_simplex::{FastFragment, FastStart, SupportDistribution};
use serde::{Deserialize, Serialize};

/// Programs of kernels with their coordinates in a [`FunctionSpan`]: what does not depend on the basis.
#[derive(Clone, Debug)]
pub struct ProgramBatch<'a> {
    pub(super) span: &'a FunctionSpan,
    pub(super) kernels: &'a [SupportDistribution],
    pub(super) fragments: &'a [FastFragment],
    /// Coordinates of kernels in the order in which fragments name them first.
    pub(super) coordinates: Vec<f64>,
    /// By fragment: which of them.
    pub(super) rows: Vec<u32>,
    pub(super) steps: Vec<u16>,
    pub(super) masses: Vec<f64>,
    /// By fragment: Euclidean norm of the coordinates.
    pub(super) norms: Vec<f64>,
    /// By fragment: all depths of its kernel, the first one repeated, or [`MANY`] if there are more.
    pub(super) depths: Vec<[u16; MAX_RANK]>,
    /// By how much a kernel's mass may differ from 1.
    pub(super) mass_error: f64,
}

impl<'a> ProgramBatch<'a> {
    /// The programs of `fragments`; ascending order of `step` costs least.
    ///
    /// # Panics
    /// If a fragment names a kernel that does not exist, or a kernel a depth that the span's support does not have.
    pub fn new(
        span: &'a FunctionSpan,
        kernels: &'a [SupportDistribution],
        fragments: &'a [FastFragment],
    ) -> Self {
        Self::build(span, kernels, fragments, |kernel, _| span.coordinates(kernel))
    }

    /// The same with the coordinates that a batch of these programs has, which take longest to compute; `None` if there are too
    /// many or too few of them.
    ///
    /// # Panics
    /// If a fragment names a kernel that does not exist, or a kernel a depth that the span's support does not have.
    pub fn with_coordinates(
        span: &'a FunctionSpan,
        kernels: &'a [SupportDistribution],
        fragments: &'a [FastFragment],
        coordinates: &[f64],
    ) -> Option<Self> {
        let dimensions = span.dimensions();
        let row = |_: &SupportDistribution, place: u32| {
            let given = coordinates.chunks_exact(dimensions).nth(place as usize);
            given.map_or_else(|| vec![0.0; dimensions], <[f64]>::to_vec)
        };
        let batch = Self::build(span, kernels, fragments, row);
        (batch.coordinates.len() == coordinates.len()).then_some(batch)
    }

    /// Coordinates of all kernels that fragments name, in the order in which they do so first.
    pub fn all_coordinates(&self) -> &[f64] {
        &self.coordinates
    }

    fn build(
        span: &'a FunctionSpan,
        kernels: &'a [SupportDistribution],
        fragments: &'a [FastFragment],
        row_of: impl Fn(&SupportDistribution, u32) -> Vec<f64>,
    ) -> Self {
        let mut places = vec![u32::MAX; kernels.len()];
        let mut coordinates = Vec::new();
        let mut used = 0;
        let mut rows = Vec::with_capacity(fragments.len());
        let mut norms = Vec::with_capacity(fragments.len());
        let mut of_kernels = Vec::new();
        let mut mass_error = f64::EPSILON;
        for fragment in fragments {
            let kernel = fragment.kernel as usize;
            if places[kernel] == u32::MAX {
                places[kernel] = used;
                let row = row_of(&kernels[kernel], used);
                used += 1;
                mass_error = mass_error.max((row[0] - 1.0).abs() + f64::EPSILON);
                of_kernels.push(row.iter().map(|value| value * value).sum::<f64>().sqrt());
                coordinates.extend(row);
            }
            rows.push(places[kernel]);
            norms.push(of_kernels[places[kernel] as usize]);
        }
        Self {
            span,
            kernels,
            fragments,
            coordinates,
            rows,
            steps: fragments.iter().map(|fragment| fragment.step).collect(),
            masses: fragments.iter().map(|fragment| fragment.mass_before).collect(),
            norms,
            depths: fragments.iter().map(|fragment| few(&kernels[fragment.kernel as usize])).collect(),
            mass_error,
        }
    }

    /// Number of programs.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Coordinates of a program's kernel.
    ///
    /// # Panics
    /// If there is no such program.
    pub fn coordinates(&self, program: usize) -> &[f64] {
        &self.coordinates[self.rows[program] as usize * self.span.dimensions()..][..self.span.dimensions()]
    }

    /// Euclidean norm of a program's coordinates: no moment is larger, and rounding of moments is in proportion to it.
    ///
    /// # Panics
    /// If there is no such program.
    pub fn norm(&self, program: usize) -> f64 {
        self.norms[program]
    }

    /// All depths of a program's kernel, the first one repeated; `None` if there are more.
    ///
    /// # Panics
    /// If there is no such program.
    pub fn few_depths(&self, program: usize) -> Option<[u16; MAX_RANK]> {
        let depths = self.depths[program];
        (depths[0] != MANY).then_some(depths)
    }

    /// The programs' fragments.
    pub fn fragments(&self) -> &'a [FastFragment] {
        self.fragments
    }

    /// The span that coordinates are in.
    pub fn span(&self) -> &'a FunctionSpan {
        self.span
    }
}

/// Stands for a kernel of many depths.
pub(super) const MANY: u16 = u16::MAX;

fn few(kernel: &SupportDistribution) -> [u16; MAX_RANK] {
    match kernel.indices() {
        [first, rest @ ..] if rest.len() < MAX_RANK => {
            let mut depths = [*first; MAX_RANK];
            depths[1..=rest.len()].copy_from_slice(rest);
            depths
        }
        _ => [MANY; MAX_RANK],
    }
}

/// Two guesses at the optimal columns of each program, from solutions for other bases of the same rank.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct LaneStarts {
    pub(super) rank: usize,
    /// Ascending columns, `rank` for each program.
    pub(super) guesses: [Vec<u16>; 2],
    /// By chunk: the places of its programs, those of one depth with similar guesses side by side.
    pub(super) similar: Vec<u32>,
}

impl LaneStarts {
    /// From solutions for the programs of a batch; columns spread evenly where there is none.
    ///
    /// # Panics
    /// If a start is one for another number of programs.
    pub fn new(batch: &ProgramBatch<'_>, starts: [&FastStart; 2], rank: usize) -> Self {
        assert!(starts.iter().all(|start| start.len() == batch.len()), "a start is one for other fragments");
        let spread = spread(batch.span.depths(), rank);
        let mut guesses = [Vec::new(), Vec::new()];
        for program in 0..batch.len() {
            let given = starts.map(|start| start.guess(program, rank));
            let first = given.into_iter().find(|guess| !guess.is_empty()).unwrap_or(&spread);
            let second = if given[1].is_empty() { first } else { given[1] };
            guesses[0].extend_from_slice(first);
            guesses[1].extend_from_slice(second);
        }
        let mut similar = Vec::with_capacity(batch.len());
        for start in (0..batch.len()).step_by(CHUNK) {
            let end = (start + CHUNK).min(batch.len());
            let guess = |at: u32| &guesses[0][(start + at as usize) * rank..][..rank];
            let mut places: Vec<u32> = (0..(end - start) as u32).collect();
            places.sort_by_key(|&at| (batch.steps[start + at as usize], guess(at), at));
            similar.extend(places);
        }
        Self { rank, guesses, similar }
    }

    /// The guesses for a program.
    ///
    /// # Panics
    /// If there is no such program.
    pub fn of(&self, program: usize) -> [&[u16]; 2] {
        [&self.guesses[0], &self.guesses[1]].map(|guesses| &guesses[program * self.rank..][..self.rank])
    }
}

/// Columns spread evenly over a support.
pub(super) fn spread(depths: usize, rank: usize) -> Vec<u16> {
    (0..rank).map(|r| (r * (depths - 1) / (rank - 1).max(1)) as u16).collect()
}
