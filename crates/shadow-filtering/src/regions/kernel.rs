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
