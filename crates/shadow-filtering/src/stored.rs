//! Moment shadow maps as textures hold them: transformed (MSM15 section 4.3), rounded to a number format, and filtered
//! as hardware filters them.
//!
//! Two passes of a separable kernel read texels of the format and write texels of the format, so that a value is
//! rounded three times: when it is encoded and after each pass. Fixed point goes into a summed-area table instead and is
//! rounded once (BHS16 section 3.2). Everything else is computed in `f64`: what remains is the error of storage alone.

use crate::depth_map::{ChannelMap, DepthMap};
use crate::error::FilteringError;
use crate::kernel::Kernel;
use crate::technique::unit;
use crate::techniques::MomentBound;
use moment_problem::Interval;
use moment_problem::hamburger::Pair;
use quantization::{AffineTransform, DepthInterval, Encoding, NumberFormat, Rectangle, SummedAreaTable};
use rayon::prelude::*;

/// A bound with the storage of its moments.
#[derive(Clone, Debug)]
pub struct StoredMoments {
    bound: MomentBound,
    interval: DepthInterval,
    encoding: Encoding,
}

/// A shadow map before filtering, as it is stored.
#[derive(Clone, Debug)]
pub enum StoredMap {
    /// One texel each.
    Texels(ChannelMap<f64>),
    /// Sums over all texels above and to the left.
    Sums(SummedAreaTable),
}

impl StoredMoments {
    /// `interval` holds the values of the variable whose functions are stored: depth 0 is its start, 1 its end.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] for a transform of another order, or an interval other than \[0, 1\] where the
    /// bound depends on it.
    pub fn new(
        bound: MomentBound,
        interval: DepthInterval,
        transform: AffineTransform,
        format: NumberFormat,
    ) -> Result<Self, FilteringError> {
        if transform.order() != bound.order() {
            let reason = format!("{} stores {} moments", bound.name(), bound.order());
            return Err(FilteringError::parameter("order of the transform", transform.order(), reason));
        }
        if bound.interval() == Interval::Unit && interval != DepthInterval::UNIT {
            let reason = format!("{} needs depths from 0 to 1", bound.name());
            let range = format!("[{}, {}]", interval.start(), interval.end());
            return Err(FilteringError::parameter("depth range", range, reason));
        }
        Ok(Self { bound, interval, encoding: Encoding::new(transform, format) })
    }

    /// The bound.
    pub fn bound(&self) -> MomentBound {
        self.bound
    }

    /// The stored variable's values.
    pub fn interval(&self) -> DepthInterval {
        self.interval
    }

    /// Transform and format.
    pub fn encoding(&self) -> &Encoding {
        &self.encoding
    }

    /// Memory of a texel, with bits that the texture wastes.
    pub fn bits_per_texel(&self) -> usize {
        self.encoding.format().bits_per_texel(self.bound.order())
    }

    /// The stored variable at a depth in \[0, 1\].
    pub fn variable(&self, depth: f64) -> f64 {
        self.interval.at(2.0 * unit(depth) - 1.0)
    }

    /// Stores a shadow map.
    ///
    /// # Errors
    /// None for formats that [`NumberFormat`] makes from text.
    pub fn store(&self, map: &DepthMap) -> Result<StoredMap, FilteringError> {
        let channels = self.bound.order();
        let basis = self.bound.basis();
        let (transform, format) = (self.encoding.transform(), self.encoding.format());
        let mut values = vec![0.0; map.depths().len() * channels];
        let rows = values.par_chunks_mut(map.width() * channels).zip(map.depths().par_chunks(map.width()));
        rows.for_each(|(row, depths)| {
            for (texel, &depth) in row.chunks_exact_mut(channels).zip(depths) {
                let b = basis.evaluate(self.variable(f64::from(depth)));
                transform.apply(&b, texel);
                texel.iter_mut().for_each(|value| *value = format.round(*value));
            }
        });
        Ok(match format {
            NumberFormat::U32Fixed { texels } => {
                StoredMap::Sums(SummedAreaTable::new((map.width(), map.height(), channels), &values, texels)?)
            }
            _ => StoredMap::Texels(ChannelMap::new(map.width(), map.height(), channels, values)?),
        })
    }

    /// The stored texel at (x, y) after filtering: `out` has one value a moment, in the format.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] for fixed point with a kernel that is not uniform, has more texels than the format
    /// allows, or leaves the map.
    pub fn filtered(
        &self,
        stored: &StoredMap,
        kernel: &Kernel,
        (x, y): (usize, usize),
        out: &mut [f64],
    ) -> Result<(), FilteringError> {
        match stored {
            StoredMap::Texels(map) => {
                self.two_passes(map, kernel, (x, y), out);
                Ok(())
            }
            StoredMap::Sums(table) => {
                self.check_kernel(kernel)?;
                let radius = kernel.radius();
                let first = (x.wrapping_sub(radius), y.wrapping_sub(radius));
                let rectangle = Rectangle { first, last: (x + radius, y + radius) };
                for (channel, value) in out.iter_mut().enumerate() {
                    *value = table.mean(rectangle, channel)?;
                }
                Ok(())
            }
        }
    }

    /// Rejects kernels that the storage cannot filter with.
    ///
    /// # Errors
    /// As [`StoredMoments::filtered`].
    pub fn check_kernel(&self, kernel: &Kernel) -> Result<(), FilteringError> {
        let NumberFormat::U32Fixed { texels } = self.encoding.format() else { return Ok(()) };
        let weights = kernel.weights();
        let fail = |reason: &str| {
            Err(FilteringError::parameter("format", self.encoding.format().to_string(), reason))
        };
        if weights.iter().any(|weight| *weight != weights[0]) {
            return fail("a summed-area table needs a kernel of shape box");
        }
        if (kernel.size() * kernel.size()) as u64 > u64::from(texels) {
            return fail("the kernel has more texels than that");
        }
        Ok(())
    }

    fn two_passes(&self, map: &ChannelMap<f64>, kernel: &Kernel, (x, y): (usize, usize), out: &mut [f64]) {
        let (format, radius) = (self.encoding.format(), kernel.radius());
        let place =
            |centre: usize, tap: usize, size: usize| (centre + tap).saturating_sub(radius).min(size - 1);
        out.fill(0.0);
        let mut row = [0.0; MAX_CHANNELS];
        let row = &mut row[..out.len()];
        for (tap, &outer) in kernel.weights().iter().enumerate() {
            let line = place(y, tap, map.height());
            row.fill(0.0);
            for (tap, &inner) in kernel.weights().iter().enumerate() {
                let texel = map.texel(place(x, tap, map.width()), line);
                row.iter_mut().zip(texel).for_each(|(sum, value)| *sum += inner * value);
            }
            out.iter_mut().zip(&*row).for_each(|(sum, value)| *sum += outer * format.round(*value));
        }
        out.iter_mut().for_each(|value| *value = format.round(*value));
    }

    /// The moments of a filtered texel, in the stored variable.
    pub fn moments(&self, texel: &[f64], out: &mut [f64]) {
        self.encoding.transform().invert(texel, out);
    }

    /// Both bounds at a depth in \[0, 1\] for (biased) moments in the stored variable.
    ///
    /// # Panics
    /// For fewer moments than the bound has.
    pub fn bounds(&self, moments: &[f64], depth: f64) -> Pair<f64> {
        self.bound.bounds(moments, self.variable(depth))
    }
}

/// Most moments that a bound has.
const MAX_CHANNELS: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::filter;

    fn map() -> DepthMap {
        // Two slanted surfaces and some noise.
        let depth = |t: usize| {
            let (x, y) = (t % 24, t / 24);
            let noise = (t * 7919 % 101) as f32 * 1e-5;
            if x + y < 20 { 0.2 + 0.004 * x as f32 + noise } else { 0.7 - 0.003 * y as f32 + noise }
        };
        DepthMap::new(24, 24, (0..24 * 24).map(depth).collect()).unwrap()
    }

    fn stored(bound: MomentBound, interval: DepthInterval, format: NumberFormat) -> StoredMoments {
        StoredMoments::new(bound, interval, AffineTransform::identity(bound.order()), format).unwrap()
    }

    #[test]
    fn a_fine_format_gives_the_filter_without_storage() {
        let (map, kernel) = (map(), Kernel::gaussian(9, 2.4).unwrap());
        let storage = stored(MomentBound::Hamburger6, DepthInterval::SIGNED, NumberFormat::F32);
        let texels = storage.store(&map).unwrap();
        let StoredMap::Texels(raw) = &texels else { panic!("texels expected") };
        let whole = filter(raw, &kernel);
        let mut texel = [0.0; 6];
        for (x, y) in [(0, 0), (12, 8), (23, 11)] {
            storage.filtered(&texels, &kernel, (x, y), &mut texel).unwrap();
            for (one, other) in texel.iter().zip(whole.texel(x, y)) {
                // Two more roundings to 24 bits.
                assert!((one - other).abs() <= 1.3e-7 * other.abs().max(1e-3), "{one} {other}");
            }
        }
    }

    #[test]
    fn both_passes_write_codes_of_the_format() {
        let (map, kernel) = (map(), Kernel::gaussian(9, 2.4).unwrap());
        for format in [NumberFormat::Unorm10, NumberFormat::Unorm16, NumberFormat::F16] {
            let storage = stored(MomentBound::Hamburger4, DepthInterval::UNIT, format);
            let texels = storage.store(&map).unwrap();
            let StoredMap::Texels(raw) = &texels else { panic!("texels expected") };
            // Rows, rounded, then columns, rounded.
            let weights = kernel.weights();
            for (x, y) in (4..20).flat_map(|y| (4..20).map(move |x| (x, y))) {
                let (mut texel, mut expected) = ([0.0; 4], [0.0; 4]);
                storage.filtered(&texels, &kernel, (x, y), &mut texel).unwrap();
                for (tap, &outer) in weights.iter().enumerate() {
                    for (channel, value) in expected.iter_mut().enumerate() {
                        let inner = |i: usize| weights[i] * raw.texel(x + i - 4, y + tap - 4)[channel];
                        *value += outer * format.round((0..9).map(inner).sum());
                    }
                }
                assert_eq!(texel, expected.map(|value| format.round(value)), "{format} at {x}, {y}");
            }
        }
    }

    #[test]
    fn sums_are_the_box_filter_of_what_is_stored_once() {
        let (map, kernel) = (map(), Kernel::uniform(9).unwrap());
        let format = NumberFormat::U32Fixed { texels: 81 };
        let storage = stored(MomentBound::Hausdorff4, DepthInterval::UNIT, format);
        let table = storage.store(&map).unwrap();
        let mut texel = [0.0; 4];
        storage.filtered(&table, &kernel, (10, 12), &mut texel).unwrap();
        let z = kernel.distribution(&map, 10, 12);
        for (k, value) in texel.iter().enumerate() {
            let exact: f64 =
                z.depths().iter().zip(z.weights()).map(|(z, w)| z.powi(k as i32 + 1) * w.to_f64()).sum();
            assert!((value - exact).abs() <= format.step(), "{value} {exact}");
        }
        let gaussian = Kernel::gaussian(9, 2.4).unwrap();
        assert!(storage.filtered(&table, &gaussian, (10, 12), &mut texel).is_err());
        assert!(storage.filtered(&table, &kernel, (1, 12), &mut texel).is_err());
        assert!(storage.check_kernel(&Kernel::uniform(11).unwrap()).is_err());
    }

    #[test]
    fn bounds_do_not_depend_on_the_interval() {
        let (map, kernel) = (map(), Kernel::gaussian(9, 2.4).unwrap());
        let g = [DepthInterval::UNIT, DepthInterval::SIGNED].map(|interval| {
            let storage = stored(MomentBound::Hamburger4, interval, NumberFormat::F32);
            let texels = storage.store(&map).unwrap();
            let (mut texel, mut moments) = ([0.0; 4], [0.0; 4]);
            storage.filtered(&texels, &kernel, (9, 9), &mut texel).unwrap();
            storage.moments(&texel, &mut moments);
            storage.bounds(&moments, 0.9).lower
        });
        assert!((g[0] - g[1]).abs() < 1e-2 && g[0] > 0.5, "{g:?}");
        let signed = DepthInterval::SIGNED;
        let identity = AffineTransform::identity(4);
        let format = NumberFormat::Unorm16;
        assert!(StoredMoments::new(MomentBound::Hausdorff4, signed, identity.clone(), format).is_err());
        assert!(StoredMoments::new(MomentBound::Hamburger6, signed, identity, format).is_err());
    }
}
