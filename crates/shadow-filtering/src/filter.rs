//! Encoding depths into channels, and the two-pass filter.
//!
//! Border: a kernel that reaches over the border reads the nearest texel instead (clamp to edge), in every filter and
//! in percentage-closer filtering alike. Each output row is computed by one thread in a fixed order, so the result
//! does not depend on the number of threads.

use crate::depth_map::{ChannelMap, DepthMap};
use crate::error::FilteringError;
use crate::kernel::Kernel;
use crate::technique::Technique;
use moment_problem::arithmetic::Real;
use rayon::prelude::*;

/// The shadow map of a technique before filtering: b(z) a texel, computed in `f64` and rounded to `R`.
///
/// # Errors
/// [`FilteringError::NotFinite`] if `R` cannot hold a value.
pub fn encode<R: Real + Send + Sync>(
    map: &DepthMap,
    technique: &dyn Technique,
) -> Result<ChannelMap<R>, FilteringError> {
    let channels = technique.channels();
    let mut data = vec![R::zero(); map.depths().len() * channels];
    let rows = data.par_chunks_mut(map.width() * channels).zip(map.depths().par_chunks(map.width()));
    rows.for_each(|(row, depths)| {
        let mut vector = vec![0.0; channels];
        for (out, &depth) in row.chunks_exact_mut(channels).zip(depths) {
            technique.encode(f64::from(depth), &mut vector);
            for (value, &exact) in out.iter_mut().zip(&vector) {
                *value = R::from_f64(exact);
            }
        }
    });
    ChannelMap::new(map.width(), map.height(), channels, data)
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
            accumulate(out, weight, &padded[tap * channels..tap * channels + line]);
        }
        out.iter_mut().for_each(|value| *value = round(*value));
    });
    let mut data = vec![R::zero(); map.data.len()];
    data.par_chunks_mut(line).enumerate().for_each(|(y, out)| {
        for (tap, &weight) in weights.iter().enumerate() {
            let source = (y + tap).saturating_sub(radius).min(height - 1);
            accumulate(out, weight, &rows[source * line..(source + 1) * line]);
        }
        out.iter_mut().for_each(|value| *value = round(*value));
    });
    ChannelMap { width, height, channels, data }
}

#[inline]
fn accumulate<R: Real>(out: &mut [R], weight: R, row: &[R]) {
    for (sum, &value) in out.iter_mut().zip(row) {
        *sum = *sum + weight * value;
    }
}
