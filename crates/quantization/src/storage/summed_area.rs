//! Summed-area tables of fixed-point moments in modular arithmetic (BHS16 section 3.2).
//!
//! Prefix sums overflow 32 bits all the time, which subtracts multiples of 2^32. A query subtracts prefix sums, and its
//! true result for at most N texels lies below 2^32 by the choice of the scale; modulo 2^32 it is therefore exact.

use super::format::NumberFormat;
use crate::error::QuantizationError;

/// Prefix sums of a map of channels.
#[derive(Clone, Debug, PartialEq)]
pub struct SummedAreaTable {
    width: usize,
    height: usize,
    channels: usize,
    texels: u32,
    /// Sums over all texels up to and including (x, y).
    sums: Vec<u32>,
}

/// Texels from `first` to `last`, both included, as (column, row).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rectangle {
    /// Upper left texel.
    pub first: (usize, usize),
    /// Lower right texel.
    pub last: (usize, usize),
}

impl SummedAreaTable {
    /// Stores values in \[0, 1\], row by row with interleaved channels, for kernels of at most `texels` texels. Values
    /// outside are clamped.
    ///
    /// # Errors
    /// [`QuantizationError::Length`] for a wrong number of values, [`QuantizationError::Parameter`] for `texels` = 0.
    pub fn new(
        (width, height, channels): (usize, usize, usize),
        values: &[f64],
        texels: u32,
    ) -> Result<Self, QuantizationError> {
        let format = NumberFormat::U32Fixed { texels };
        if texels == 0 {
            let reason = "a kernel has at least one texel".to_owned();
            return Err(QuantizationError::Parameter { key: "texels", value: texels.to_string(), reason });
        }
        let expected = width.checked_mul(height).and_then(|count| count.checked_mul(channels));
        if expected != Some(values.len()) || values.is_empty() {
            return Err(QuantizationError::Length {
                what: "summed-area table",
                expected: expected.unwrap_or(usize::MAX),
                got: values.len(),
            });
        }
        let mut sums: Vec<u32> = values.iter().map(|&value| format.encode(value)).collect();
        let line = width * channels;
        for row in sums.chunks_exact_mut(line) {
            for i in channels..line {
                row[i] = row[i].wrapping_add(row[i - channels]);
            }
        }
        for i in line..sums.len() {
            sums[i] = sums[i].wrapping_add(sums[i - line]);
        }
        Ok(Self { width, height, channels, texels, sums })
    }

    /// N.
    pub fn texels(&self) -> u32 {
        self.texels
    }

    /// Sums over all texels up to and including (x, y), modulo 2^32: row by row, channels interleaved.
    pub fn prefix_sums(&self) -> &[u32] {
        &self.sums
    }

    /// Sum of codes over a rectangle, exact for at most N texels.
    ///
    /// # Errors
    /// [`QuantizationError::Parameter`] for a rectangle that is larger, empty or leaves the map.
    pub fn sum(&self, rectangle: Rectangle, channel: usize) -> Result<u32, QuantizationError> {
        let Rectangle { first, last } = rectangle;
        let fail = |reason: String| QuantizationError::Parameter {
            key: "rectangle",
            value: format!("{first:?} to {last:?}"),
            reason,
        };
        let inside = first.0 <= last.0 && first.1 <= last.1 && last.0 < self.width && last.1 < self.height;
        if !inside || channel >= self.channels {
            return Err(fail(format!("is no part of {}x{}x{}", self.width, self.height, self.channels)));
        }
        let count = (last.0 - first.0 + 1) * (last.1 - first.1 + 1);
        if count as u64 > u64::from(self.texels) {
            return Err(fail(format!("{count} texels exceed {}, for which sums are exact", self.texels)));
        }
        let at = |x: Option<usize>, y: Option<usize>| match x.zip(y) {
            Some((x, y)) => self.sums[(y * self.width + x) * self.channels + channel],
            None => 0,
        };
        let (left, above) = (first.0.checked_sub(1), first.1.checked_sub(1));
        let (right, below) = (Some(last.0), Some(last.1));
        let sum = at(right, below).wrapping_sub(at(left, below)).wrapping_sub(at(right, above));
        Ok(sum.wrapping_add(at(left, above)))
    }

    /// Mean of the stored values over a rectangle.
    ///
    /// # Errors
    /// As [`SummedAreaTable::sum`].
    pub fn mean(&self, rectangle: Rectangle, channel: usize) -> Result<f64, QuantizationError> {
        let sum = f64::from(self.sum(rectangle, channel)?);
        let Rectangle { first, last } = rectangle;
        let count = ((last.0 - first.0 + 1) * (last.1 - first.1 + 1)) as f64;
        Ok(sum / (count * f64::from(NumberFormat::fixed_point_scale(self.texels))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random_stream::Random;

    /// Whole maps of ones are the worst case: prefix sums pass 2^32 many times, kernels reach it but for one code.
    #[test]
    fn sums_are_exact_up_to_the_stated_size_although_prefix_sums_overflow() {
        let (width, height) = (64, 48);
        for (texels, ones) in [(81, true), (81, false), (256, false), (7, true), (1, false)] {
            let mut random = Random::stream(3, u64::from(texels));
            let value = |r: &mut Random| if ones { 1.0 } else { r.unit() };
            let values: Vec<f64> = (0..width * height * 2).map(|_| value(&mut random)).collect();
            let table = SummedAreaTable::new((width, height, 2), &values, texels).unwrap();
            let format = NumberFormat::U32Fixed { texels };
            let total: u64 = values.iter().map(|&v| u64::from(format.encode(v))).sum();
            assert!(total > 1 << 33, "the test must overflow: {total}");
            let mut largest = 0;
            for _ in 0..4000 {
                let w = 1 + (random.unit() * f64::from(texels).sqrt() * 2.0) as usize;
                let h = (texels as usize / w).max(1);
                let (w, h) = (w.min(texels as usize).min(width), h.min(height));
                let x = (random.unit() * (width - w + 1) as f64) as usize;
                let y = (random.unit() * (height - h + 1) as f64) as usize;
                let rectangle = Rectangle { first: (x, y), last: (x + w - 1, y + h - 1) };
                let channel = usize::from(random.unit() < 0.5);
                let expected: u64 = (y..y + h)
                    .flat_map(|y| (x..x + w).map(move |x| (y * width + x) * 2 + channel))
                    .map(|index| u64::from(format.encode(values[index])))
                    .sum();
                assert_eq!(u64::from(table.sum(rectangle, channel).unwrap()), expected, "{rectangle:?}");
                largest = largest.max(expected);
            }
            assert!(!ones || largest > u64::from(u32::MAX) - u64::from(texels), "{largest}");
        }
    }

    #[test]
    fn larger_kernels_and_wrong_sizes_are_errors() {
        let table = SummedAreaTable::new((4, 4, 1), &[0.5; 16], 8).unwrap();
        let rectangle = |x, y| Rectangle { first: (0, 0), last: (x, y) };
        assert!((table.mean(rectangle(3, 1), 0).unwrap() - 0.5).abs() < 1e-8);
        assert!(table.sum(rectangle(2, 2), 0).unwrap_err().to_string().contains("9 texels exceed 8"));
        assert!(table.sum(rectangle(4, 0), 0).is_err());
        assert!(table.sum(rectangle(0, 0), 1).is_err());
        assert!(SummedAreaTable::new((4, 4, 1), &[0.5; 15], 8).is_err());
        assert!(SummedAreaTable::new((4, 4, 1), &[0.5; 16], 0).is_err());
    }
}
