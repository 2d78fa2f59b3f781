//! Kernels: the two-pass filter of a whole map, and the same for a single fragment.
//!
//! Border: a kernel that reaches over the border reads the nearest texel instead (clamp to edge), in every filter and
//! in percentage-closer filtering alike. Each output row is computed by one thread in a fixed order, so the result
//! does not depend on the number of threads.

use super::StoredField;
use crate::depth_map::{ChannelMap, DepthMap};
use crate::error::FilteringError;
use crate::kernel::Kernel;
use crate::technique::{MAX_CHANNELS, Precision, Technique, each_texel};
use moment_problem::arithmetic::Real;
use rayon::prelude::*;

/// A point of a map in texels; the centre of the first texel is (0.5, 0.5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    /// To the right.
    pub x: f64,
    /// Downwards.
    pub y: f64,
}

impl Position {
    /// The centre of a texel.
    pub fn of_texel(x: usize, y: usize) -> Self {
        Self { x: x as f64 + 0.5, y: y as f64 + 0.5 }
    }
}

/// b(z) a texel before filtering and without storage, computed in `f64` and rounded to `P`.
///
/// # Errors
/// [`FilteringError::NotFinite`] if `P` cannot hold a value.
pub fn encode<P: Precision>(map: &DepthMap, technique: &Technique) -> Result<ChannelMap<P>, FilteringError> {
    each_texel(map, technique.channels(), |depth, texel: &mut [P]| {
        let mut b = [0.0; MAX_CHANNELS];
        let b = &mut b[..texel.len()];
        technique.evaluate(f64::from(depth), b);
        texel.iter_mut().zip(b).for_each(|(value, &mut exact)| *value = P::from_f64(exact));
    })
}

/// Filters all channels with a separable kernel: rows, then columns.
pub fn filter<R: Real + Send + Sync>(map: &ChannelMap<R>, kernel: &Kernel) -> ChannelMap<R> {
    filter_rounded(map, kernel, |value| value)
}

/// The same with a texture of some format behind each pass: `round` is what storing does to a value.
pub(crate) fn filter_rounded<R: Real + Send + Sync>(
    map: &ChannelMap<R>,
    kernel: &Kernel,
    round: impl Fn(R) -> R + Send + Sync,
) -> ChannelMap<R> {
    let (width, height, channels) = (map.width, map.height, map.channels);
    let (line, radius) = (width * channels, kernel.radius());
    let weights: Vec<R> = kernel.weights().iter().map(|&w| R::from_f64(w)).collect();
    let mut rows = vec![R::zero(); map.data.len()];
    rows.par_chunks_mut(line).zip(map.data.par_chunks(line)).for_each_init(Vec::new, |padded, (out, row)| {
        padded.clear();
        for _ in 0..radius {
            padded.extend_from_slice(&row[..channels]);
        }
        padded.extend_from_slice(row);
        for _ in 0..radius {
            padded.extend_from_slice(&row[line - channels..]);
        }
        for (tap, &weight) in weights.iter().enumerate() {
            add(out, weight, &padded[tap * channels..tap * channels + line]);
        }
        out.iter_mut().for_each(|value| *value = round(*value));
    });
    let mut data = vec![R::zero(); map.data.len()];
    data.par_chunks_mut(line).enumerate().for_each(|(y, out)| {
        for (tap, &weight) in weights.iter().enumerate() {
            let source = (y + tap).saturating_sub(radius).min(height - 1);
            add(out, weight, &rows[source * line..(source + 1) * line]);
        }
        out.iter_mut().for_each(|value| *value = round(*value));
    });
    ChannelMap { width, height, channels, data }
}

impl Technique {
    /// The whole map, stored and filtered in two passes, each through a texture of the format.
    ///
    /// # Errors
    /// As [`Technique::store`].
    pub fn filtered<P: Precision>(
        &self,
        map: &DepthMap,
        kernel: &Kernel,
    ) -> Result<ChannelMap<P>, FilteringError> {
        let format = self.encoding().format();
        Ok(filter_rounded(&self.store(map)?, kernel, |value: P| value.rounded(format)))
    }
}

/// A filtered map; regions are the filter's kernel around points, between texels mixed bilinearly.
impl<P: Precision> StoredField<P> for ChannelMap<P> {
    type Region = Position;

    fn mean(&self, at: Position, out: &mut [P]) -> Result<(), FilteringError> {
        let columns = Taps::new(at.x, self.width);
        let rows = Taps::new(at.y, self.height);
        out.fill(P::zero());
        for (y, v) in rows.used() {
            for (x, w) in columns.used() {
                add(out, P::from_f64(v) * P::from_f64(w), self.texel(x, y));
            }
        }
        Ok(())
    }
}

/// The same values as those of [`Technique::filtered`], bit for bit, for single points: only the texels under the kernel
/// are looked at.
pub struct KernelField<'a, P> {
    technique: &'a Technique,
    kernel: &'a Kernel,
    map: &'a DepthMap,
    /// Without it texels are encoded when they are asked for.
    stored: Option<ChannelMap<P>>,
}

impl<'a, P: Precision> KernelField<'a, P> {
    /// Encodes texels when they are asked for.
    pub fn new(technique: &'a Technique, map: &'a DepthMap, kernel: &'a Kernel) -> Self {
        Self { technique, kernel, map, stored: None }
    }

    /// Encodes all texels once, for many points.
    ///
    /// # Errors
    /// As [`Technique::store`].
    pub fn stored(
        technique: &'a Technique,
        map: &'a DepthMap,
        kernel: &'a Kernel,
    ) -> Result<Self, FilteringError> {
        Ok(Self { stored: Some(technique.store(map)?), ..Self::new(technique, map, kernel) })
    }

    fn texel(&self, x: usize, y: usize, out: &mut [P]) {
        match &self.stored {
            Some(stored) => out.copy_from_slice(stored.texel(x, y)),
            None => {
                let depth = self.map.depths()[y * self.map.width() + x];
                self.technique.encode(P::from_f64(f64::from(depth)), out);
            }
        }
    }

    /// One pass of the kernel over texels one after another, and its storage.
    fn pass(&self, texels: &[P], sum: &mut [P]) {
        let channels = sum.len();
        for (texel, &weight) in texels.chunks_exact(channels).zip(self.kernel.weights()) {
            add(sum, P::from_f64(weight), texel);
        }
        let format = self.technique.encoding().format();
        sum.iter_mut().for_each(|value| *value = value.rounded(format));
    }
}

impl<P: Precision> StoredField<P> for KernelField<'_, P> {
    type Region = Position;

    fn mean(&self, at: Position, out: &mut [P]) -> Result<(), FilteringError> {
        let (map, kernel) = (self.map, self.kernel);
        let (columns, rows) = (Taps::new(at.x, map.width()), Taps::new(at.y, map.height()));
        let (radius, channels) = (kernel.radius() as isize, out.len());
        let clamped = |place: isize, size: usize| place.clamp(0, size as isize - 1) as usize;
        // Encoded texels of a row under the kernel, their filtered values for each column, then the column pass.
        let width = kernel.size() + columns.span();
        let mut encoded = vec![P::zero(); width * channels];
        let height = kernel.size() + rows.span();
        let mut lines = vec![P::zero(); columns.used().count() * height * channels];
        let first = (columns.first() as isize - radius, rows.first() as isize - radius);
        for line in 0..height {
            let y = clamped(first.1 + line as isize, map.height());
            for (i, texel) in encoded.chunks_exact_mut(channels).enumerate() {
                self.texel(clamped(first.0 + i as isize, map.width()), y, texel);
            }
            for (c, (x, _)) in columns.used().enumerate() {
                let start = (x - columns.first()) * channels;
                self.pass(&encoded[start..], &mut lines[(c * height + line) * channels..][..channels]);
            }
        }
        out.fill(P::zero());
        let mut texel = [P::zero(); MAX_CHANNELS];
        let texel = &mut texel[..channels];
        for (y, v) in rows.used() {
            for (c, (_, w)) in columns.used().enumerate() {
                let start = (c * height + y - rows.first()) * channels;
                texel.fill(P::zero());
                self.pass(&lines[start..], texel);
                add(out, P::from_f64(v) * P::from_f64(w), texel);
            }
        }
        Ok(())
    }
}

#[inline]
fn add<R: Real>(sum: &mut [R], weight: R, values: &[R]) {
    sum.iter_mut().zip(values).for_each(|(sum, &value)| *sum = *sum + weight * value);
}

/// The two texels along an axis that a bilinear sample mixes.
struct Taps {
    texels: [usize; 2],
    weights: [f64; 2],
}

impl Taps {
    fn new(at: f64, size: usize) -> Self {
        let base = (at - 0.5).floor();
        // As graphics hardware, in single precision.
        let second = f64::from((at - 0.5 - base) as f32);
        let texel = |place: f64| place.clamp(0.0, size as f64 - 1.0) as usize;
        Self { texels: [texel(base), texel(base + 1.0)], weights: [1.0 - second, second] }
    }

    /// Texels with a weight.
    fn used(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.texels.iter().copied().zip(self.weights).filter(|&(_, weight)| weight > 0.0)
    }

    fn first(&self) -> usize {
        self.texels[0]
    }

    /// 1 where both texels are different ones.
    fn span(&self) -> usize {
        self.texels[1] - self.texels[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::TechniqueSpec;
    use quantization::NumberFormat;

    fn map() -> DepthMap {
        let depth = |t: usize| {
            let (x, y) = (t % 40, t / 40);
            let noise = (t * 7919 % 101) as f32 * 1e-4;
            if x + y < 30 { 0.2 + 0.004 * x as f32 + noise } else { 0.7 - 0.003 * y as f32 + noise }
        };
        DepthMap::new(40, 30, (0..40 * 30).map(depth).collect()).unwrap()
    }

    fn technique(toml: &str) -> Technique {
        toml::from_str::<TechniqueSpec>(toml).unwrap().build().unwrap()
    }

    #[test]
    fn a_single_sample_is_that_of_the_whole_map() {
        fn same<P: Precision>(technique: &Technique) {
            let (map, kernel) = (map(), Kernel::gaussian(5, 1.2).unwrap());
            let whole = technique.filtered::<P>(&map, &kernel).unwrap();
            let lazy = KernelField::<P>::new(technique, &map, &kernel);
            let stored = KernelField::<P>::stored(technique, &map, &kernel).unwrap();
            for at in [(0.5, 0.5), (17.25, 9.75), (0.1, 29.9), (39.9, 12.0), (20.0, 0.0), (12.5, 8.3)] {
                let at = Position { x: at.0, y: at.1 };
                let mut found = [0, 1, 2].map(|_| vec![P::zero(); technique.channels()]);
                whole.mean(at, &mut found[0]).unwrap();
                lazy.mean(at, &mut found[1]).unwrap();
                stored.mean(at, &mut found[2]).unwrap();
                assert!(found[0] == found[1] && found[0] == found[2], "{} at {at:?}", technique.name());
            }
        }
        for toml in [
            "bound = 'hamburger4'\ntransform = 'GDC16 four moments'\nformat = 'unorm16'\nalpha = 6e-5",
            "bound = 'evsm'\nexponent = 5.0\nnegative_exponent = 5.0\nformat = 'f16'",
            "bound = 'vsm'",
        ] {
            same::<f32>(&technique(toml));
            same::<f64>(&technique(toml));
        }
    }

    #[test]
    fn restored_moments_are_those_of_the_distribution() {
        let (map, kernel) = (map(), Kernel::gaussian(9, 2.4).unwrap());
        let toml = "bound = 'hamburger4'\ntransform = 'GDC16 four moments'\nformat = 'unorm16'";
        let technique = technique(toml);
        let mut b = [0.0f32; 4];
        let field = KernelField::new(&technique, &map, &kernel);
        technique.moments(&field, Position::of_texel(15, 14), &mut b).unwrap();
        let z = kernel.distribution(&map, 15, 14);
        for (k, b) in b.iter().enumerate() {
            let depths = z.depths().iter().zip(z.weights());
            let exact: f64 = depths.map(|(&z, w)| w.to_f64() * (2.0 * z - 1.0).powi(k as i32 + 1)).sum();
            assert!((f64::from(*b) - exact).abs() < 1e-4, "moment {}: {b} instead of {exact}", k + 1);
        }
    }

    #[test]
    fn a_fine_format_gives_the_filter_without_storage() {
        let (map, kernel) = (map(), Kernel::gaussian(9, 2.4).unwrap());
        let technique = technique("bound = 'hamburger6'\nformat = 'f32'");
        let field = technique.kernel_field(&map, &kernel).unwrap();
        let whole = filter(&technique.store::<f64>(&map).unwrap(), &kernel);
        let mut texel = [0.0; 6];
        for (x, y) in [(0, 0), (12, 8), (23, 11)] {
            field.mean(Position::of_texel(x, y), &mut texel).unwrap();
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
            let technique = technique(&format!("bound = 'hamburger4'\nrange = 'unit'\nformat = '{format}'"));
            let field = technique.kernel_field(&map, &kernel).unwrap();
            let raw = technique.store::<f64>(&map).unwrap();
            // Rows, rounded, then columns, rounded.
            let weights = kernel.weights();
            for (x, y) in (4..20).flat_map(|y| (4..20).map(move |x| (x, y))) {
                let (mut texel, mut expected) = ([0.0; 4], [0.0; 4]);
                field.mean(Position::of_texel(x, y), &mut texel).unwrap();
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
    fn bounds_do_not_depend_on_the_variable() {
        let (map, kernel) = (map(), Kernel::gaussian(9, 2.4).unwrap());
        let g = ["unit", "signed"].map(|range| {
            let technique = technique(&format!("bound = 'hamburger4'\nrange = '{range}'\nalpha = 0.0"));
            let mut b = [0.0; 4];
            let field = technique.kernel_field(&map, &kernel).unwrap();
            technique.moments(field.as_ref(), Position::of_texel(9, 9), &mut b).unwrap();
            technique.bounds(&b, 0.9).unwrap().lower
        });
        assert!((g[0] - g[1]).abs() < 1e-2 && g[0] > 0.5, "{g:?}");
    }

    #[test]
    fn impossible_combinations_name_what_is_wrong() {
        let fail = |toml: &str| {
            let spec: TechniqueSpec = toml::from_str(toml).unwrap();
            spec.build().and_then(|technique| technique.check_real_time()).unwrap_err().to_string()
        };
        assert!(fail("basis = 'power:2'").contains("shader"));
        let message = fail("bound = 'hamburger2'\ntransform = 'GDC16 four moments'");
        assert!(message.contains("order of the transform = 4"), "{message}");
        assert!(fail("bound = 'vsm'\nformat = 'u32/81'").contains("u32/81"));
    }
}
