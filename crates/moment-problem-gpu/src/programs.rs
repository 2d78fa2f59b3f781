//! What goes to a card and what comes back.

use crate::shader::GROUP;
use bytemuck::{Pod, Zeroable};
use moment_problem::lane_simplex::{LaneStarts, ProgramBatch};

/// What a program counts for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weighting {
    /// What its bound is compared with.
    pub reference: f64,
    /// What |G - reference| is compared with.
    pub control: f64,
    /// Factor in the sums.
    pub count: f64,
}

/// Programs to be kept on a card.
#[derive(Clone, Copy)]
pub struct Programs<'a> {
    /// The programs.
    pub batch: &'a ProgramBatch<'a>,
    /// Their starts.
    pub starts: &'a LaneStarts,
    /// What they count for.
    pub weighting: &'a [Weighting],
    /// Which of them, in which order; `None` for one that counts nothing, which fills up a group.
    pub order: &'a [Option<u32>],
}

/// A program that the card could not certify.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Left {
    /// Which of the candidates.
    pub candidate: u32,
    /// Place in the order of the programs.
    pub program: u32,
    /// Ascending columns of the basis that was found.
    pub support: [u16; 5],
}

/// Sums over a group of [`GROUP`](crate::GROUP) programs, with d = |G - reference| - control.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct GroupSums {
    /// Of count d.
    pub difference: f64,
    /// Of count d^2.
    pub square: f64,
    /// One bound of the group, to be checked; -1 if it was not certified.
    pub sample: f64,
    unused: f64,
}

/// What the card says about a batch of candidates.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// Groups of programs.
    pub groups: usize,
    /// By candidate and group of programs, over the certified ones.
    pub sums: Vec<GroupSums>,
    /// Programs that the exact route has to decide, ascending; they are in no sum.
    pub left: Vec<Left>,
}

impl Answer {
    /// Place of the program whose bound is the sample of a group.
    pub fn sampled(&self, candidate: usize, group: usize) -> usize {
        group * GROUP as usize + (group * 97 + candidate * 31) % GROUP as usize
    }
}

/// Time of a stage.
#[derive(Clone, Debug)]
pub struct Pass {
    /// Name of the entry point.
    pub name: &'static str,
    /// Seconds on the card.
    pub seconds: f64,
}
