//! The transform that gains most, found by ascents from many random starts.

use super::ascent::{Ascent, ascend};
use super::bound::bound_of;
use super::chebyshev;
use super::gain::gain_bits;
use super::polish::{Polished, polish};
use super::row_program::{Block, Vertex};
use super::working_basis::{Parity, WorkingBasis};
use crate::error::QuantizationError;
use crate::interval::DepthInterval;
use crate::storage::{AffineTransform, ranges};
use moment_problem::Basis;
use moment_problem::arithmetic::{DoubleDouble, Real};
use random_stream::Random;
use rayon::prelude::*;

/// Which entries of the matrix may differ from zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Structure {
    /// All.
    #[default]
    Dense,
    /// Rows are even or odd about the middle of the interval: with depths from -1 to 1 half of the entries are zero
    /// (GDC16).
    Parity,
}

/// How a transform is searched for. The result depends on nothing else: not on threads, not on time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Search {
    /// Structure of the matrix.
    pub structure: Structure,
    /// Random starts; without it 48 up to order 4, then more: 256, 1024, beyond order 8 as many as a minute allows.
    pub starts: Option<usize>,
    /// Seed of the starts.
    pub seed: u64,
}

/// The best transform found, and how good any can be.
#[derive(Clone, Debug)]
pub struct Optimum {
    /// The transform, of rows with ascending number of extrema.
    pub transform: AffineTransform,
    /// The depths over which the transform's functions run: the interval asked for, or \[-1, 1\] where rounding the
    /// matrix of powers of that interval's depths would spoil the range. The interval must then be mapped there first.
    pub depths: DepthInterval,
    /// Bits gained, see [`gain_bits`].
    pub gain_bits: f64,
    /// Least stored value over the interval, proved.
    pub range_min: f64,
    /// Largest stored value over the interval, proved.
    pub range_max: f64,
    /// No transform gains more, proved; see [`crate::bound`].
    pub bound_bits: f64,
    /// Random starts.
    pub starts: usize,
    /// How many of them reached the best gain to a ten-thousandth of a bit: a hint that there is no better one.
    pub hits: usize,
}

impl Optimum {
    /// The transform, if its functions run over this interval.
    ///
    /// # Errors
    /// [`QuantizationError::Rescaled`] if depths must be mapped to another one first.
    pub fn transform_on(self, interval: DepthInterval) -> Result<AffineTransform, QuantizationError> {
        if self.depths == interval {
            return Ok(self.transform);
        }
        Err(QuantizationError::Rescaled { interval, depths: self.depths })
    }
}

/// Starts that found the best known transform of power bases several times over with three different seeds; beyond
/// order 8 as many as a minute allows.
fn default_starts(order: usize) -> usize {
    match order {
        0..=4 => 48,
        5 | 6 => 256,
        7 | 8 => 1024,
        _ => 512,
    }
}

/// Ends of different ascents that are polished: the grid may misplace neighbours by its own error.
const POLISHED: usize = 12;

/// Ascents that differ by less end in the same place, or in its mirror image.
const SAME_BITS: f64 = 1e-6;

/// For [`Optimum::hits`].
const HIT_BITS: f64 = 1e-4;

/// How far stored values may lie outside of \[0, 1\]: a thousandth of the rounding of 20 bits, a hundred times what
/// rounding the matrix of eight power moments leaves.
pub const RANGE_TOLERANCE: f64 = 1e-9;

/// A gain above its proved bound by more bits than this is a contradiction: rounding of the matrix moves a determinant
/// by about as much as a range.
const BOUND_TOLERANCE: f64 = 1e-9;

/// Maximises |det theta| subject to theta(b(z)) in \[0, 1\]^m for all z of the interval (MSM15 section 4.3).
///
/// Powers of depths from one interval span the powers of depths from another, so that they are optimised on \[-1, 1\]
/// (or on \[0, 1\] as it stands): gain and bound are the same for all intervals.
///
/// # Errors
/// [`QuantizationError`] for a flat or unusable basis, no starts, a basis without parity where that is asked for, and
/// a transform whose rounded matrix leaves its box or its bound.
pub fn optimise(
    basis: &Basis,
    interval: DepthInterval,
    search: &Search,
) -> Result<Optimum, QuantizationError> {
    let starts = search.starts.unwrap_or_else(|| default_starts(basis.len()));
    if starts == 0 {
        return Err(QuantizationError::NoStarts);
    }
    let working = WorkingBasis::normalised(basis, interval)?;
    let m = working.len();
    let bound_bits = gain_bits(basis, working.interval, bound_of(&working)?);
    let mut rows = Vec::with_capacity(m);
    let mut hits = usize::MAX;
    for (number, (indices, parity)) in blocks(&working, search.structure)?.into_iter().enumerate() {
        let series = indices.iter().map(|&i| working.series[i].clone()).collect();
        let low = if parity.is_some() { 0.0 } else { -1.0 };
        let block = Block::new(series, parity != Some(Parity::Odd), low);
        let (best, count) = best_of(&block, starts, search.seed, number as u64)?;
        hits = hits.min(count);
        rows.extend(best.rows.into_iter().map(|row| {
            let mut full = vec![0.0; m];
            indices.iter().zip(row).for_each(|(&i, value)| full[i] = value);
            full
        }));
    }
    let rows = exact_rows(&working, rows);
    let on = |depths: DepthInterval| -> Result<Optimum, QuantizationError> {
        let rows: Vec<Vec<DoubleDouble>> =
            rows.iter().map(|row| substituted(row, working.interval, depths)).collect();
        let transform = assemble(basis, depths, rows)?;
        let (range_min, range_max) = transform_range(basis, depths, &transform);
        let gain_bits = gain_bits(basis, depths, transform.log2_determinant());
        let optimum =
            Optimum { transform, depths, gain_bits, range_min, range_max, bound_bits, starts, hits };
        let fits = range_min >= -RANGE_TOLERANCE && range_max <= 1.0 + RANGE_TOLERANCE;
        // NaN is neither.
        if fits && gain_bits <= bound_bits + BOUND_TOLERANCE {
            return Ok(optimum);
        }
        Err(QuantizationError::Contradicted { range_min, range_max, gain_bits, bound_bits })
    };
    let found = if fits_single_precision(basis, interval) {
        on(interval)
    } else {
        Err(QuantizationError::Overflow { basis: basis.to_string(), interval })
    };
    // Far from 0 the rounded powers cancel: the transform then leaves its box, or wastes some of it.
    let fills = |optimum: &Optimum| {
        optimum.range_min <= RANGE_TOLERANCE && optimum.range_max >= 1.0 - RANGE_TOLERANCE
    };
    if basis.power_order().is_some() && interval != DepthInterval::SIGNED && !found.as_ref().is_ok_and(fills)
    {
        return on(DepthInterval::SIGNED);
    }
    found
}

/// Whether shaders can compute the functions at all.
fn fits_single_precision(basis: &Basis, interval: DepthInterval) -> bool {
    sizes(basis, interval).iter().all(|&size| size < f64::from(f32::MAX))
}

/// Largest size of each function over an interval, sampled.
pub(crate) fn sizes(basis: &Basis, interval: DepthInterval) -> Vec<f64> {
    const SAMPLES: usize = 64;
    let mut sizes = vec![0.0f64; basis.len()];
    for t in chebyshev::points(SAMPLES) {
        let values = basis.evaluate(interval.at(t));
        sizes.iter_mut().zip(values).for_each(|(size, value)| *size = size.max(value.abs()));
    }
    sizes
}

/// Coefficients over 1, z, ..., z^m of depths in `from` as those of depths in `to`; of any function if both are equal.
fn substituted(row: &[DoubleDouble], from: DepthInterval, to: DepthInterval) -> Vec<DoubleDouble> {
    if from == to {
        return row.to_vec();
    }
    // from = slope to + shift, exact up to the rounding of double-double.
    let length = |interval: DepthInterval| DoubleDouble::sum(interval.end(), -interval.start());
    let slope = length(from) / length(to);
    let shift = DoubleDouble::from(from.start()) - slope * DoubleDouble::from(to.start());
    // Horner's scheme over polynomials.
    let mut result = vec![DoubleDouble::zero(); row.len()];
    for &coefficient in row.iter().rev() {
        for k in (0..row.len()).rev() {
            let lower = if k == 0 { coefficient } else { result[k - 1] * slope };
            result[k] = result[k] * shift + lower;
        }
    }
    result
}

/// Least and largest stored value over an interval of depths, both proved: nothing lies outside.
///
/// # Panics
/// If the transform's order is not the basis'.
pub fn transform_range(basis: &Basis, interval: DepthInterval, transform: &AffineTransform) -> (f64, f64) {
    let rows: Vec<Vec<DoubleDouble>> = (0..transform.order())
        .map(|i| {
            let row = std::iter::once(&transform.offset()[i]).chain(transform.row(i));
            row.map(|&c| DoubleDouble::from(c)).collect()
        })
        .collect();
    let ranges = ranges(basis, &rows, interval);
    ranges.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), row| {
        (min.min(row.proved_min), max.max(row.proved_max))
    })
}

/// Indices of functions that are optimised together, with their parity.
type Group = (Vec<usize>, Option<Parity>);

/// The groups of a structure.
fn blocks(working: &WorkingBasis, structure: Structure) -> Result<Vec<Group>, QuantizationError> {
    if structure == Structure::Dense {
        return Ok(vec![((0..working.len()).collect(), None)]);
    }
    let parities = working.parities()?;
    let of =
        |wanted: Parity| -> Vec<usize> { (0..parities.len()).filter(|&i| parities[i] == wanted).collect() };
    let blocks = [Parity::Odd, Parity::Even].map(|parity| (of(parity), Some(parity)));
    Ok(blocks.into_iter().filter(|(indices, _)| !indices.is_empty()).collect())
}

/// The best of all starts, polished, and how many came as far.
fn best_of(
    block: &Block,
    starts: usize,
    seed: u64,
    stream: u64,
) -> Result<(Polished, usize), QuantizationError> {
    let dependent = QuantizationError::NotInvertible { rows: block.rows, determinant: 0.0 };
    let Some(vertex) = Vertex::start(block) else { return Err(dependent) };
    let number = |start: usize| (start as u64) << 1 | stream;
    let mut ascents: Vec<Ascent> = (0..starts)
        .into_par_iter()
        .filter_map(|start| ascend(block, &vertex, &mut Random::stream(seed, number(start))))
        .collect();
    // Stable: equal gains stay in the order of their starts, whatever the threads did.
    ascents.sort_by(|a, b| b.bits.total_cmp(&a.bits));
    let top = ascents.first().map_or(0.0, |ascent| ascent.bits);
    let hits = ascents.iter().filter(|ascent| ascent.bits > top - HIT_BITS).count();
    ascents.dedup_by(|b, a| a.bits - b.bits < SAME_BITS);
    ascents.truncate(POLISHED);
    let polished: Vec<Polished> =
        ascents.par_iter().filter_map(|ascent| polish(block, &vertex, ascent)).collect();
    let best = polished.into_iter().reduce(|best, other| if other.bits > best.bits { other } else { best });
    best.map(|best| (best, hits)).ok_or(dependent)
}

/// Rows in working coordinates, upright and in order, as coefficients over 1, b_1, ..., b_m.
fn exact_rows(working: &WorkingBasis, rows: Vec<Vec<f64>>) -> Vec<Vec<DoubleDouble>> {
    let mut ordered: Vec<(usize, Vec<f64>)> = rows.into_iter().map(|row| upright(working, row)).collect();
    ordered.sort_by(|a, b| a.0.cmp(&b.0).then(b.1[0].total_cmp(&a.1[0])));
    ordered.iter().map(|(_, row)| working.over_basis(row)).collect()
}

/// From rows over 1, b_1, ..., b_m to a rounded matrix and an offset with range \[0, 1\].
fn assemble(
    basis: &Basis,
    interval: DepthInterval,
    mut rows: Vec<Vec<DoubleDouble>>,
) -> Result<AffineTransform, QuantizationError> {
    let sizes = sizes(basis, interval);
    let exact = ranges(basis, &rows, interval);
    for (row, range) in rows.iter_mut().zip(exact) {
        let width = DoubleDouble::sum(range.proved_max, -range.proved_min);
        let scaled: Vec<f64> = row.iter().map(|&c| (c / width).to_f64()).collect();
        let part = |(entry, size): (&f64, &f64)| (entry * size).abs();
        let largest = scaled[1..].iter().zip(&sizes).map(part).fold(0.0, f64::max);
        for (j, (entry, value)) in row.iter_mut().zip(scaled).enumerate().skip(1) {
            let negligible = part((&value, &sizes[j - 1])) < NEGLIGIBLE * largest;
            *entry = DoubleDouble::from(if negligible { 0.0 } else { value });
        }
        row[0] = DoubleDouble::zero();
    }
    // Once more, of the very numbers that are stored: what rounding added to the width is shared by both ends.
    let stored = ranges(basis, &rows, interval);
    let offset = stored.iter().map(|range| 0.5 - 0.5 * (range.proved_min + range.proved_max) + 0.0).collect();
    let matrix = rows.iter().flat_map(|row| row[1..].iter().map(|c| c.to_f64())).collect();
    AffineTransform::new(matrix, offset)
}

/// Entries whose function contributes less than this share of a row's largest part are zeros that rounding has blurred.
const NEGLIGIBLE: f64 = 1e-13;

/// Number of extrema inside the interval, and the row with the sign that starts in the lower half of its range.
fn upright(working: &WorkingBasis, mut row: Vec<f64>) -> (usize, Vec<f64>) {
    let series = chebyshev::combination(&working.series, &row);
    let extrema = chebyshev::sign_changes(&chebyshev::derivative(&series), -1.0, 1.0).len();
    let (min, max) = chebyshev::extremes(&series, -1.0, 1.0);
    if chebyshev::evaluate(&series, -1.0) > 0.5 * (min + max) {
        row.iter_mut().for_each(|value| *value = -*value);
    }
    (extrema, row)
}
