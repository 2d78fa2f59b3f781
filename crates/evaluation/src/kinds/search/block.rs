//! Parts of the sample on which candidates are judged one after another.

use moment_problem::fast_simplex::{FastFragment, SupportDistribution};

/// A part of the sample, itself spread over all views.
#[derive(Default)]
pub(crate) struct Block {
    pub(crate) kernels: Vec<SupportDistribution>,
    /// Distinct and with F_Z > 0, in ascending order of their depth.
    pub(crate) fragments: Vec<FastFragment>,
    /// In the same order.
    pub(crate) entries: Vec<Entry>,
    /// By view.
    pub(crate) sampled: Vec<u32>,
    /// By view: sum of F where F_Z = 0, the error of any basis there.
    pub(crate) idle: Vec<f64>,
}

/// What a fragment counts for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub(crate) view: u16,
    /// How many fragments of the sample are the same one.
    pub(crate) count: u32,
    /// F.
    pub(crate) reference: f64,
}

/// The block of a position in the sample: the first one takes every 2^(blocks - 1)-th, the next the middles between
/// these, and so on.
pub(super) fn block_of(position: usize, blocks: usize) -> usize {
    match position % (1 << (blocks - 1)) {
        0 => 0,
        rest => blocks - 1 - rest.trailing_zeros() as usize,
    }
}

impl Block {
    /// Fragments of the sample in this block.
    pub(crate) fn fragments_drawn(&self) -> usize {
        self.sampled.iter().map(|&n| n as usize).sum()
    }

    /// Fragments of the same depth together: they share the vertices of a program's dual.
    pub(super) fn sorted(mut self) -> Self {
        let mut order: Vec<usize> = (0..self.fragments.len()).collect();
        order.sort_by_key(|&i| (self.fragments[i].step, i));
        self.fragments = order.iter().map(|&i| self.fragments[i]).collect();
        self.entries = order.iter().map(|&i| self.entries[i]).collect();
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_nested_halves() {
        let blocks: Vec<usize> = (0..16).map(|position| block_of(position, 4)).collect();
        assert_eq!(blocks, [0, 3, 2, 3, 1, 3, 2, 3, 0, 3, 2, 3, 1, 3, 2, 3]);
        assert!((0..9).all(|position| block_of(position, 1) == 0));
    }
}
