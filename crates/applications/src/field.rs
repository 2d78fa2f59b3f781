//! Filtered fields: means of stored functions of depth over regions of one's choice.

use moment_problem::MomentBound;
use moment_problem::arithmetic::Real;
use quantization::{NumberFormat, QuantizationError, Rectangle, SummedAreaTable};

use crate::region::{Pieces, Region};

mod prefix_sums;
mod stored_sums;

pub use prefix_sums::PrefixSums;
pub use stored_sums::{StoredSums, Table};

/// Most channels of a field.
pub const MAX_CHANNELS: usize = MomentBound::MAX_ORDER;

/// Means of the channels, as many as the field has; the others are 0.
pub type Means<R> = [R; MAX_CHANNELS];

/// How a rectangle is fitted to texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fit {
    /// Taken as it is, by up to nine regions (BHS16 section 3.4).
    Covered,
    /// Extended to whole texels (BHS16 section 3.5).
    Outwards,
    /// Moved to the nearest texel borders, "without interpolation".
    Nearest,
}

impl Fit {
    /// The texels of one axis.
    pub fn pieces(self, low: f64, high: f64, size: usize) -> Pieces {
        match self {
            Self::Covered => Pieces::covered(low, high, size),
            Self::Outwards => Pieces::outwards(low, high, size),
            Self::Nearest => Pieces::nearest(low, high, size),
        }
    }
}

/// What a soft shadow asks.
pub trait MomentField<R> {
    /// Means over a region.
    ///
    /// # Errors
    /// [`QuantizationError::Parameter`] if the region exceeds what the field can sum.
    fn means(&self, region: &Region<R>, fit: Fit) -> Result<Means<R>, QuantizationError>;
}

/// A summed-area table of moments in 32-bit fixed point (BHS16 section 3.2).
#[derive(Clone, Debug)]
pub struct SummedMoments {
    table: SummedAreaTable,
    size: [usize; 2],
    channels: usize,
}

impl SummedMoments {
    /// Stores the values that `encode` makes of each depth, at most [`MAX_CHANNELS`] in \[0, 1\]. Regions may have up
    /// to `texels` texels.
    ///
    /// # Errors
    /// [`QuantizationError`] for sizes that do not fit together and `texels` = 0.
    pub fn new(
        size: [usize; 2],
        depths: &[f32],
        channels: usize,
        texels: u32,
        encode: impl Fn(f64, &mut [f64]),
    ) -> Result<Self, QuantizationError> {
        let mut values = vec![0.0; depths.len() * channels];
        for (depth, out) in depths.iter().zip(values.chunks_exact_mut(channels)) {
            encode(f64::from(*depth), out);
        }
        let table = SummedAreaTable::new((size[0], size[1], channels), &values, texels)?;
        Ok(Self { table, size, channels })
    }

    /// The table itself, as a graphics processor holds it.
    pub fn table(&self) -> &SummedAreaTable {
        &self.table
    }

    /// Number of regions that a query takes and the texels of the largest.
    pub fn regions(&self, region: &Region<f64>, fit: Fit) -> (usize, usize) {
        let [columns, rows] = self.pieces(region, fit);
        let longest = |pieces: &Pieces| pieces.as_slice().iter().map(|p| p.texels()).max().unwrap_or(0);
        (columns.as_slice().len() * rows.as_slice().len(), longest(&columns) * longest(&rows))
    }

    fn pieces<R: Real>(&self, region: &Region<R>, fit: Fit) -> [Pieces; 2] {
        fit.rectangle(region, self.size)
    }
}

impl Fit {
    /// The texels of both axes.
    fn rectangle<R: Real>(self, region: &Region<R>, size: [usize; 2]) -> [Pieces; 2] {
        [0, 1].map(|k| self.pieces(region.low[k].to_f64(), region.high[k].to_f64(), size[k]))
    }
}

/// Sums over whole texels, each weighted by how much of its texels is covered, over the covered area.
fn integrated<R: Real>(
    [columns, rows]: [Pieces; 2],
    channels: usize,
    sum: impl Fn(Rectangle, usize) -> Result<R, QuantizationError>,
) -> Result<Means<R>, QuantizationError> {
    let mut means = [R::zero(); MAX_CHANNELS];
    let mut area = R::zero();
    for row in rows.as_slice() {
        for column in columns.as_slice() {
            let share = R::from_f64(column.covered) * R::from_f64(row.covered);
            area = area + share * R::from_f64((column.texels() * row.texels()) as f64);
            let rectangle = Rectangle { first: (column.first, row.first), last: (column.last, row.last) };
            for (channel, mean) in means.iter_mut().enumerate().take(channels) {
                *mean = *mean + share * sum(rectangle, channel)?;
            }
        }
    }
    Ok(means.map(|mean| mean / area))
}

impl<R: Real> MomentField<R> for SummedMoments {
    /// Sums are whole numbers up to here; they become `R` one region at a time, as in a shader.
    fn means(&self, region: &Region<R>, fit: Fit) -> Result<Means<R>, QuantizationError> {
        let sum = |rectangle, channel| Ok(R::from_f64(f64::from(self.table.sum(rectangle, channel)?)));
        let means = integrated(self.pieces(region, fit), self.channels, sum)?;
        let one = R::from_f64(f64::from(NumberFormat::fixed_point_scale(self.table.texels())));
        Ok(means.map(|mean| mean / one))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random_stream::Random;

    fn powers(depth: f64, out: &mut [f64]) {
        let mut power = 1.0;
        for value in out {
            power *= depth;
            *value = power;
        }
    }

    /// Brute force over all texels, weighted by overlap.
    fn mean(depths: &[f32], size: [usize; 2], low: [f64; 2], high: [f64; 2], order: i32) -> f64 {
        let overlap = |k: usize, t: usize| (high[k].min(t as f64 + 1.0) - low[k].max(t as f64)).max(0.0);
        let texels = depths.iter().enumerate();
        let weighted = texels.map(|(i, &d)| {
            let weight = overlap(0, i % size[0]) * overlap(1, i / size[0]);
            (weight, weight * f64::from(d).powi(order))
        });
        let (area, sum) = weighted.fold((0.0, 0.0), |(a, s), (weight, value)| (a + weight, s + value));
        sum / area
    }

    #[test]
    fn real_rectangles_are_integrated() {
        let size = [40, 30];
        let mut random = Random::stream(8, 0);
        let depths: Vec<f32> = (0..1200).map(|_| random.unit() as f32).collect();
        let field = SummedMoments::new(size, &depths, 4, 600, powers).unwrap();
        for i in 0..500 {
            let low = [30.0 * random.unit(), 20.0 * random.unit()];
            let widths = [20.0 * random.unit(), 18.0 * random.unit()];
            let mut high = [0, 1].map(|k| (low[k] + widths[k]).min(size[k] as f64));
            if i % 5 == 0 {
                high[0] = low[0].floor() + 1.0;
            }
            let region = Region { low, high };
            let found: Means<f64> = field.means(&region, Fit::Covered).unwrap();
            let single = field
                .means(&Region { low: low.map(|c| c as f32), high: high.map(|c| c as f32) }, Fit::Covered)
                .unwrap();
            for order in 1..=4 {
                let expected = mean(&depths, size, low, high, order as i32);
                // Half a step of the fixed point.
                assert!((found[order - 1] - expected).abs() < 0.5 * 600.0 / 4.29e9 + 1e-13, "{region:?}");
                assert!((f64::from(single[order - 1]) - expected).abs() < 4e-5, "{region:?}");
            }
        }
        assert_eq!(field.regions(&Region { low: [0.5, 3.0], high: [3.5, 3.5] }, Fit::Covered), (3, 2));
    }

    /// The fault to avoid: prefix sums that have wrapped around, turned into floats before they are subtracted.
    #[test]
    fn wrapped_sums_must_be_subtracted_as_integers() {
        let side = 64;
        let mut random = Random::stream(9, 0);
        let depths: Vec<f32> = (0..side * side).map(|_| random.unit() as f32).collect();
        let format = NumberFormat::U32Fixed { texels: 64 };
        let mut sums = vec![0u32; side * side];
        for y in 0..side {
            let mut line = 0u32;
            for x in 0..side {
                line = line.wrapping_add(format.encode(f64::from(depths[y * side + x])));
                sums[y * side + x] = if y > 0 { sums[(y - 1) * side + x].wrapping_add(line) } else { line };
            }
        }
        let field = SummedMoments::new([side; 2], &depths, 1, 64, powers).unwrap();
        let scale = f64::from(NumberFormat::fixed_point_scale(64)) * 64.0;
        let mut wrong = 0;
        for first in 8..side - 8 {
            let at = |x: usize, y: usize| f64::from(sums[(y - 1) * side + x - 1]);
            let end = first + 8;
            let float = (at(end, end) - at(first, end) - at(end, first) + at(first, first)) / scale;
            let region = Region { low: [first as f64; 2], high: [end as f64; 2] };
            let found: Means<f64> = field.means(&region, Fit::Covered).unwrap();
            let expected = mean(&depths, [side; 2], region.low, region.high, 1);
            assert!((found[0] - expected).abs() < 1e-8);
            wrong += usize::from((float - expected).abs() > 0.1);
        }
        assert!(wrong > 20, "{wrong}");
    }

    #[test]
    fn regions_beyond_n_are_errors() {
        let field = SummedMoments::new([8, 8], &[1.0; 64], 2, 16, powers).unwrap();
        let square = |w: f64| Region { low: [0.0; 2], high: [w; 2] };
        assert!(
            (MomentField::<f64>::means(&field, &square(4.0), Fit::Covered).unwrap()[1] - 1.0).abs() < 1e-8
        );
        let error = MomentField::<f64>::means(&field, &square(4.5), Fit::Outwards).unwrap_err().to_string();
        assert!(error.contains("25 texels exceed 16"), "{error}");
        // 4.5 x 4.5 is nine regions of at most 16.
        assert!(MomentField::<f64>::means(&field, &square(4.5), Fit::Covered).is_ok());
    }
}
