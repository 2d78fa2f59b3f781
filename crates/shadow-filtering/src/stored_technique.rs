//! A real-time technique with its storage: transform, number format, filter passes through textures of that format,
//! bilinear sampling, and shading in single precision, as graphics hardware does all of it.

use crate::depth_map::{ChannelMap, DepthMap};
use crate::error::FilteringError;
use crate::filter::filter_rounded;
use crate::kernel::Kernel;
use crate::technique::Technique;
use quantization::{AffineTransform, NumberFormat};
use rayon::prelude::*;

/// A point of a map in texels; the centre of the first texel is (0.5, 0.5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    /// To the right.
    pub x: f64,
    /// Downwards.
    pub y: f64,
}

/// What a texture holds of a technique.
pub struct StoredTechnique {
    technique: Box<dyn Technique>,
    /// None where values are stored as they are.
    transform: Option<SingleTransform>,
    format: NumberFormat,
}

/// An affine transform and its inverse in single precision.
struct SingleTransform {
    matrix: Vec<f32>,
    offset: Vec<f32>,
    inverse: Vec<f32>,
    /// -inverse offset, multiplied in double precision.
    inverse_offset: Vec<f32>,
    is_diagonal: bool,
}

impl SingleTransform {
    fn new(transform: &AffineTransform) -> Self {
        let single = |values: &[f64]| values.iter().map(|&value| value as f32).collect();
        let rows = transform.inverse().chunks_exact(transform.order());
        let constant =
            rows.map(|row| -row.iter().zip(transform.offset()).map(|(a, o)| a * o).sum::<f64>() as f32);
        Self {
            matrix: single(transform.matrix()),
            offset: single(transform.offset()),
            inverse: single(transform.inverse()),
            inverse_offset: constant.collect(),
            is_diagonal: (0..transform.order() * transform.order())
                .all(|k| k % (transform.order() + 1) == 0 || transform.matrix()[k] == 0.0),
        }
    }
}

/// matrix values + offset; a diagonal matrix is worth a shorter way.
fn affine(matrix: &[f32], offset: &[f32], values: &[f32], out: &mut [f32], is_diagonal: bool) {
    if is_diagonal {
        let factors = matrix.iter().step_by(values.len() + 1);
        for (((out, &factor), &value), &offset) in out.iter_mut().zip(factors).zip(values).zip(offset) {
            *out = factor * value + offset;
        }
        return;
    }
    for ((out, row), &offset) in out.iter_mut().zip(matrix.chunks_exact(values.len())).zip(offset) {
        *out = row.iter().zip(values).fold(0.0, |sum, (m, v)| sum + m * v) + offset;
    }
}

impl StoredTechnique {
    /// `transform` maps b(z) to what is stored; `None` stores b(z) itself.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] for a technique that no shader computes, a transform of another order, or fixed
    /// point, which goes into summed-area tables.
    pub fn new(
        technique: Box<dyn Technique>,
        transform: Option<&AffineTransform>,
        format: NumberFormat,
    ) -> Result<Self, FilteringError> {
        let name = technique.name();
        if technique.real_time().is_none() {
            return Err(FilteringError::parameter("method", name, "cannot be computed by a shader"));
        }
        if let Some(transform) = transform.filter(|transform| transform.order() != technique.channels()) {
            let reason = format!("{name} stores {} values", technique.channels());
            return Err(FilteringError::parameter("order of the transform", transform.order(), reason));
        }
        if matches!(format, NumberFormat::U32Fixed { .. }) {
            return Err(FilteringError::parameter("format", format, "needs a summed-area table"));
        }
        Ok(Self { technique, transform: transform.map(SingleTransform::new), format })
    }

    /// The technique.
    pub fn technique(&self) -> &dyn Technique {
        self.technique.as_ref()
    }

    /// The number format.
    pub fn format(&self) -> NumberFormat {
        self.format
    }

    /// Memory of a texel, with bits that the texture wastes.
    pub fn bits_per_texel(&self) -> usize {
        self.format.bits_per_texel(self.technique.channels())
    }

    /// What a texel of one depth holds.
    pub fn encode(&self, depth: f32, out: &mut [f32]) {
        // `new` has refused techniques without a shader.
        let Some(real_time) = self.technique.real_time() else { return };
        match &self.transform {
            None => real_time.encode_single(depth, out),
            Some(transform) => {
                let mut b = [0.0; MAX_CHANNELS];
                let b = &mut b[..out.len()];
                real_time.encode_single(depth, b);
                affine(&transform.matrix, &transform.offset, b, out, transform.is_diagonal);
            }
        }
        out.iter_mut().for_each(|value| *value = self.format.round_single(*value));
    }

    /// The whole map, encoded and filtered in two passes, each through a texture of the format.
    ///
    /// # Errors
    /// None for depths in \[0, 1\].
    pub fn filtered(&self, map: &DepthMap, kernel: &Kernel) -> Result<ChannelMap<f32>, FilteringError> {
        let channels = self.technique.channels();
        let mut data = vec![0.0; map.depths().len() * channels];
        let rows = data.par_chunks_mut(map.width() * channels).zip(map.depths().par_chunks(map.width()));
        rows.for_each(|(row, depths)| {
            for (texel, &depth) in row.chunks_exact_mut(channels).zip(depths) {
                self.encode(depth, texel);
            }
        });
        let encoded = ChannelMap::new(map.width(), map.height(), channels, data)?;
        Ok(filter_rounded(&encoded, kernel, |value| self.format.round_single(value)))
    }

    /// A bilinear sample of a filtered map; beyond the border the nearest texels. `out` has one value a channel.
    pub fn sample(&self, filtered: &ChannelMap<f32>, at: Position, out: &mut [f32]) {
        let columns = Taps::new(at.x, filtered.width());
        let rows = Taps::new(at.y, filtered.height());
        out.fill(0.0);
        for (y, v) in rows.used() {
            for (x, w) in columns.used() {
                let texel = filtered.texel(x, y);
                out.iter_mut().zip(texel).for_each(|(sum, value)| *sum += v * w * value);
            }
        }
    }

    /// [`StoredTechnique::sample`] of [`StoredTechnique::filtered`], bit for bit, for a single position: only the texels
    /// under the kernel are encoded.
    pub fn sample_unfiltered(&self, map: &DepthMap, kernel: &Kernel, at: Position, out: &mut [f32]) {
        let (columns, rows) = (Taps::new(at.x, map.width()), Taps::new(at.y, map.height()));
        let (radius, channels) = (kernel.radius() as isize, out.len());
        let clamped = |place: isize, size: usize| place.clamp(0, size as isize - 1) as usize;
        // Encoded texels of a row under the kernel, their filtered values for each column, then the column pass.
        let width = kernel.size() + columns.span();
        let mut encoded = vec![0.0; width * channels];
        let height = kernel.size() + rows.span();
        let mut lines = vec![0.0; columns.used().count() * height * channels];
        let first = (columns.first() as isize - radius, rows.first() as isize - radius);
        for line in 0..height {
            let y = clamped(first.1 + line as isize, map.height());
            for (i, texel) in encoded.chunks_exact_mut(channels).enumerate() {
                let x = clamped(first.0 + i as isize, map.width());
                self.encode(map.depths()[y * map.width() + x], texel);
            }
            for (c, (x, _)) in columns.used().enumerate() {
                let start = (x - columns.first()) * channels;
                let sum = &mut lines[(c * height + line) * channels..][..channels];
                self.pass(kernel, &encoded[start..], sum);
            }
        }
        out.fill(0.0);
        let mut texel = [0.0; MAX_CHANNELS];
        let texel = &mut texel[..channels];
        for (y, v) in rows.used() {
            for (c, (_, w)) in columns.used().enumerate() {
                let start = (c * height + y - rows.first()) * channels;
                texel.fill(0.0);
                self.pass(kernel, &lines[start..], texel);
                out.iter_mut().zip(&*texel).for_each(|(sum, value)| *sum += v * w * value);
            }
        }
    }

    /// One pass of the kernel over texels one after another, and its storage.
    fn pass(&self, kernel: &Kernel, texels: &[f32], sum: &mut [f32]) {
        let channels = sum.len();
        for (texel, &weight) in texels.chunks_exact(channels).zip(kernel.weights()) {
            let weight = weight as f32;
            sum.iter_mut().zip(texel).for_each(|(sum, value)| *sum += weight * value);
        }
        sum.iter_mut().for_each(|value| *value = self.format.round_single(*value));
    }

    /// WGSL of `quantise` and `dequantise`, from `array<f32, CHANNELS>` to the same: the transform of
    /// [`StoredTechnique::encode`] before rounding, and [`StoredTechnique::decode`].
    pub fn transform_wgsl(&self) -> (String, String) {
        let Some(transform) = &self.transform else {
            let same = |name: &str| {
                format!(
                    "fn {name}(values: array<f32, CHANNELS>) -> array<f32, CHANNELS> {{\n    return values;\n}}\n"
                )
            };
            return (same("quantise"), same("dequantise"));
        };
        let function = |name: &str, matrix: &[f32], offset: &[f32]| {
            let rows = matrix.chunks_exact(offset.len()).zip(offset).map(|(row, offset)| {
                let factors = row.iter().enumerate().filter(|(_, factor)| **factor != 0.0);
                let terms: Vec<String> =
                    factors.map(|(j, factor)| format!("{factor:?}f * values[{j}]")).collect();
                format!("{} + {offset:?}f", terms.join(" + "))
            });
            let rows: Vec<String> = rows.collect();
            format!(
                "fn {name}(values: array<f32, CHANNELS>) -> array<f32, CHANNELS> {{\n    return array<f32, CHANNELS>({});\n}}\n",
                rows.join(", ")
            )
        };
        (
            function("quantise", &transform.matrix, &transform.offset),
            function("dequantise", &transform.inverse, &transform.inverse_offset),
        )
    }

    /// Operations of [`StoredTechnique::decode`]: a product and a sum for each factor that is not zero.
    pub fn decode_operations(&self) -> u64 {
        let factors = self.transform.iter().flat_map(|transform| &transform.inverse);
        2 * factors.filter(|&&factor| factor != 0.0).count() as u64
    }

    /// The moments of a sample.
    pub fn decode(&self, texel: &[f32], out: &mut [f32]) {
        match &self.transform {
            None => out.copy_from_slice(texel),
            Some(transform) => {
                affine(&transform.inverse, &transform.inverse_offset, texel, out, transform.is_diagonal);
            }
        }
    }
}

/// Most values that a technique stores: 64 coefficients or layers of two channels.
const MAX_CHANNELS: usize = 128;

/// The two texels along an axis that a bilinear sample mixes.
struct Taps {
    texels: [usize; 2],
    weights: [f32; 2],
}

impl Taps {
    fn new(at: f64, size: usize) -> Self {
        let base = (at - 0.5).floor();
        let second = (at - 0.5 - base) as f32;
        let texel = |place: f64| place.clamp(0.0, size as f64 - 1.0) as usize;
        Self { texels: [texel(base), texel(base + 1.0)], weights: [1.0 - second, second] }
    }

    /// Texels with a weight.
    fn used(&self) -> impl Iterator<Item = (usize, f32)> + '_ {
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
    use crate::spec::{MomentOptions, TechniqueSpec};
    use crate::technique::StorageFormat;
    use quantization::published::Published;

    fn map() -> DepthMap {
        let depth = |t: usize| {
            let (x, y) = (t % 40, t / 40);
            let noise = (t * 7919 % 101) as f32 * 1e-4;
            if x + y < 30 { 0.2 + 0.004 * x as f32 + noise } else { 0.7 - 0.003 * y as f32 + noise }
        };
        DepthMap::new(40, 30, (0..40 * 30).map(depth).collect()).unwrap()
    }

    fn stored() -> Vec<StoredTechnique> {
        let theta = Published::named("GDC16 four moments").unwrap().transform().unwrap();
        let options = MomentOptions { alpha: Some(6e-5), beta: 0.0 };
        let evsm = TechniqueSpec::Evsm { positive: 5.0, negative: Some(5.0), format: StorageFormat::F16 };
        vec![
            StoredTechnique::new(
                TechniqueSpec::Hamburger4(options).build().unwrap(),
                Some(&theta),
                NumberFormat::Unorm16,
            )
            .unwrap(),
            StoredTechnique::new(evsm.build().unwrap(), None, NumberFormat::F16).unwrap(),
            StoredTechnique::new(TechniqueSpec::Vsm {}.build().unwrap(), None, NumberFormat::F32).unwrap(),
        ]
    }

    #[test]
    fn a_single_sample_is_that_of_the_whole_map() {
        let (map, kernel) = (map(), Kernel::gaussian(5, 1.2).unwrap());
        for technique in stored() {
            let channels = technique.technique().channels();
            let whole = technique.filtered(&map, &kernel).unwrap();
            for at in [(0.5, 0.5), (17.25, 9.75), (0.1, 29.9), (39.9, 12.0), (20.0, 0.0), (12.5, 8.3)] {
                let at = Position { x: at.0, y: at.1 };
                let (mut one, mut other) = (vec![0.0; channels], vec![0.0; channels]);
                technique.sample(&whole, at, &mut one);
                technique.sample_unfiltered(&map, &kernel, at, &mut other);
                assert_eq!(one, other, "{} at {at:?}", technique.technique().name());
            }
        }
    }

    #[test]
    fn decoded_moments_are_those_of_the_distribution() {
        let (map, kernel) = (map(), Kernel::gaussian(9, 2.4).unwrap());
        let technique = &stored()[0];
        let mut sample = [0.0; 4];
        technique.sample_unfiltered(&map, &kernel, Position { x: 15.5, y: 14.5 }, &mut sample);
        let mut b = [0.0; 4];
        technique.decode(&sample, &mut b);
        let z = kernel.distribution(&map, 15, 14);
        for (k, b) in b.iter().enumerate() {
            let depths = z.depths().iter().zip(z.weights());
            let exact: f64 = depths.map(|(&z, w)| w.to_f64() * (2.0 * z - 1.0).powi(k as i32 + 1)).sum();
            assert!((f64::from(*b) - exact).abs() < 1e-4, "moment {}: {b} instead of {exact}", k + 1);
        }
    }

    #[test]
    fn impossible_combinations_name_what_is_wrong() {
        let fail = |spec: TechniqueSpec, transform: Option<&AffineTransform>, format| {
            StoredTechnique::new(spec.build().unwrap(), transform, format).err().unwrap().to_string()
        };
        let certified = TechniqueSpec::Certified { basis: "power:2".to_owned() };
        assert!(fail(certified, None, NumberFormat::F32).contains("shader"));
        let two = AffineTransform::identity(2);
        let message = fail(
            TechniqueSpec::Esm { exponent: 5.0, format: StorageFormat::F32 },
            Some(&two),
            NumberFormat::F32,
        );
        assert!(message.contains("order of the transform = 2"), "{message}");
        assert!(fail(TechniqueSpec::Vsm {}, None, NumberFormat::U32Fixed { texels: 81 }).contains("u32/81"));
    }
}
