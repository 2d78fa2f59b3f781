//! Summed-area tables in floating point: what the whole numbers of [`super::SummedMoments`] are there to avoid.

use moment_problem::arithmetic::Real;
use quantization::QuantizationError;

use super::{Fit, Means, MomentField, integrated};
use crate::region::Region;

/// Prefix sums in the precision `S`, made by two passes, rows first (BHS16 section 3.2). A difference of sums has the
/// rounding of the sums, which grow with the map: after 512 x 512 texels of value 1 a single float counts in steps of
/// 1/32. In double precision it stands for exact moments.
#[derive(Clone, Debug)]
pub struct PrefixSums<S> {
    sums: Vec<S>,
    size: [usize; 2],
    channels: usize,
}

impl<S: Real> PrefixSums<S> {
    /// Sums the values that `encode` makes of each depth.
    ///
    /// # Errors
    /// [`QuantizationError::Length`] for a size that does not fit the depths.
    pub fn new(
        size: [usize; 2],
        depths: &[f32],
        channels: usize,
        encode: impl Fn(f64, &mut [f64]),
    ) -> Result<Self, QuantizationError> {
        if size[0].checked_mul(size[1]) != Some(depths.len()) || depths.is_empty() {
            let expected = size[0].saturating_mul(size[1]);
            return Err(QuantizationError::Length { what: "prefix sums", expected, got: depths.len() });
        }
        let mut values = vec![0.0; channels];
        let mut sums = Vec::with_capacity(depths.len() * channels);
        for &depth in depths {
            encode(f64::from(depth), &mut values);
            sums.extend(values.iter().map(|&value| S::from_f64(value)));
        }
        let line = size[0] * channels;
        for row in sums.chunks_exact_mut(line) {
            for i in channels..line {
                row[i] = row[i] + row[i - channels];
            }
        }
        for i in line..sums.len() {
            sums[i] = sums[i] + sums[i - line];
        }
        Ok(Self { sums, size, channels })
    }

    /// The sum over all texels before column `x` and row `y`.
    fn before(&self, x: usize, y: usize, channel: usize) -> S {
        match (x.checked_sub(1), y.checked_sub(1)) {
            (Some(x), Some(y)) => self.sums[(y * self.size[0] + x) * self.channels + channel],
            (None, _) | (_, None) => S::zero(),
        }
    }
}

impl<R: Real, S: Real> MomentField<R> for PrefixSums<S> {
    fn means(&self, region: &Region<R>, fit: Fit) -> Result<Means<R>, QuantizationError> {
        integrated(fit.rectangle(region, self.size), self.channels, |rectangle, channel| {
            let [(left, top), (right, bottom)] =
                [rectangle.first, (rectangle.last.0 + 1, rectangle.last.1 + 1)];
            let at = |x, y| self.before(x, y, channel);
            let sum = at(right, bottom) - at(left, bottom) - at(right, top) + at(left, top);
            Ok(R::from_f64(sum.to_f64()))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Double precision is exact where single precision has lost the map: one texel of a map of ones.
    #[test]
    fn single_floats_lose_the_end_of_a_map() {
        let side = 1024;
        let depths: Vec<f32> = (0..side * side).map(|t| if t % 3 == 0 { 0.7 } else { 0.9 }).collect();
        let field = |texel: f64| Region { low: [texel; 2], high: [texel + 1.0; 2] };
        let first = |depth: f64, out: &mut [f64]| out[0] = depth;
        let double = PrefixSums::<f64>::new([side; 2], &depths, 1, first).unwrap();
        let single = PrefixSums::<f32>::new([side; 2], &depths, 1, first).unwrap();
        let worst = |range: std::ops::Range<usize>, single_wanted: bool| {
            let errors = range.map(|t| {
                let at = field(t as f64);
                let found: Means<f64> = if single_wanted {
                    single.means(&at, Fit::Covered).unwrap()
                } else {
                    double.means(&at, Fit::Covered).unwrap()
                };
                (found[0] - f64::from(depths[t * side + t])).abs()
            });
            errors.fold(0.0, f64::max)
        };
        assert!(worst(0..side, false) < 1e-9);
        assert!(worst(0..4, true) < 1e-5);
        assert!(worst(side - 50..side, true) > 0.02, "{}", worst(side - 50..side, true));
    }

    #[test]
    fn sizes_must_fit() {
        assert!(PrefixSums::<f64>::new([2, 2], &[0.0; 3], 1, |_, _| ()).is_err());
        assert!(PrefixSums::<f64>::new([0, 0], &[], 1, |_, _| ()).is_err());
    }
}
