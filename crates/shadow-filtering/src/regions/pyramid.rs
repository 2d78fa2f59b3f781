//! The other linear filters of a filterable shadow map: mip chain and multisample resolve.

use super::StoredField;
use crate::depth_map::ChannelMap;
use crate::error::FilteringError;
use crate::technique::Precision;
use moment_problem::arithmetic::Real;

/// A texel of a level of a mip chain; level 0 is the map itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MipTexel {
    /// Level.
    pub level: usize,
    /// Column.
    pub x: usize,
    /// Row.
    pub y: usize,
}

/// The map and its halvings down to one texel. Sides are halved and rounded down; each texel is the mean over the
/// exact area it covers, so that the mean of the map is preserved for odd sides too.
#[derive(Clone, Debug)]
pub struct Pyramid<R> {
    levels: Vec<ChannelMap<R>>,
}

impl<R: Real> Pyramid<R> {
    /// All levels of a map.
    pub fn new(map: &ChannelMap<R>) -> Self {
        let mut levels = vec![map.clone()];
        while let Some(last) = levels.last().filter(|last| last.width > 1 || last.height > 1) {
            let next = halved(last);
            levels.push(next);
        }
        Self { levels }
    }

    /// From the map itself down to one texel.
    pub fn levels(&self) -> &[ChannelMap<R>] {
        &self.levels
    }
}

impl<P: Precision> StoredField<P> for Pyramid<P> {
    type Region = MipTexel;

    fn mean(&self, MipTexel { level, x, y }: MipTexel, out: &mut [P]) -> Result<(), FilteringError> {
        let map = self.levels.get(level).filter(|map| x < map.width && y < map.height).ok_or_else(|| {
            let reason = format!("is no texel of {} levels", self.levels.len());
            FilteringError::parameter("region", format!("texel ({x}, {y}) of level {level}"), reason)
        })?;
        out.copy_from_slice(map.texel(x, y));
        Ok(())
    }
}

/// Source texels and weights of each texel of a side halved.
fn coverage(from: usize) -> Vec<Vec<(usize, f64)>> {
    let to = (from / 2).max(1);
    let step = from as f64 / to as f64;
    let covered = |i: usize| {
        let (start, end) = (i as f64 * step, (i + 1) as f64 * step);
        let texels = start.floor() as usize..(end.ceil() as usize).min(from);
        let overlap = |t: usize| (end.min((t + 1) as f64) - start.max(t as f64)).max(0.0);
        texels.map(|t| (t, overlap(t) / step)).collect()
    };
    (0..to).map(covered).collect()
}

fn halved<R: Real>(map: &ChannelMap<R>) -> ChannelMap<R> {
    let (columns, rows) = (coverage(map.width), coverage(map.height));
    let channels = map.channels;
    let mut data = vec![R::zero(); columns.len() * rows.len() * channels];
    for (texel, out) in data.chunks_exact_mut(channels).enumerate() {
        for &(y, v) in &rows[texel / columns.len()] {
            for &(x, w) in &columns[texel % columns.len()] {
                for (sum, &value) in out.iter_mut().zip(map.texel(x, y)) {
                    *sum = *sum + R::from_f64(v * w) * value;
                }
            }
        }
    }
    ChannelMap { width: columns.len(), height: rows.len(), channels, data }
}

/// Resolves `samples` samples a texel to their mean. The samples of a texel stand side by side: the multisampled map
/// is `samples` times as wide.
///
/// # Errors
/// [`FilteringError::Parameter`] if the width is no multiple of the samples.
pub fn resolve<R: Real>(map: &ChannelMap<R>, samples: usize) -> Result<ChannelMap<R>, FilteringError> {
    if samples == 0 || !map.width.is_multiple_of(samples) {
        let reason = format!("must divide the width of {} samples", map.width);
        return Err(FilteringError::parameter("samples", samples, reason));
    }
    let share = R::from_f64(1.0 / samples as f64);
    let width = map.width / samples;
    let mut data = vec![R::zero(); width * map.height * map.channels];
    let texels = map.data.chunks_exact(samples * map.channels);
    for (out, texel) in data.chunks_exact_mut(map.channels).zip(texels) {
        for sample in texel.chunks_exact(map.channels) {
            for (sum, &value) in out.iter_mut().zip(sample) {
                *sum = *sum + share * value;
            }
        }
    }
    Ok(ChannelMap { width, height: map.height, channels: map.channels, data })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_has_the_mean_of_the_map() {
        let data: Vec<f64> = (0..7 * 5 * 2).map(|i| f64::from(i * i % 97)).collect();
        let map = ChannelMap::new(7, 5, 2, data).unwrap();
        let pyramid = Pyramid::new(&map);
        let chain = pyramid.levels();
        let sizes: Vec<_> = chain.iter().map(|level| (level.width(), level.height())).collect();
        assert_eq!(sizes, [(7, 5), (3, 2), (1, 1)]);
        for channel in 0..2 {
            let mean = |level: &ChannelMap<f64>| {
                let values = level.data().iter().skip(channel).step_by(2);
                values.sum::<f64>() / (level.width() * level.height()) as f64
            };
            assert!(chain.iter().all(|level| (mean(level) - mean(&map)).abs() < 1e-12));
            let mut top = [0.0; 2];
            pyramid.mean(MipTexel { level: 2, x: 0, y: 0 }, &mut top).unwrap();
            assert!((top[channel] - mean(&map)).abs() < 1e-12);
            assert!(pyramid.mean(MipTexel { level: 1, x: 3, y: 0 }, &mut top).is_err());
        }
    }

    #[test]
    fn samples_are_averaged() {
        let map = ChannelMap::new(4, 1, 2, vec![0.0f32, 8.0, 1.0, 8.0, 2.0, 8.0, 5.0, 8.0]).unwrap();
        assert_eq!(resolve(&map, 4).unwrap().data(), [2.0, 8.0]);
        assert_eq!(resolve(&map, 2).unwrap().data(), [0.5, 8.0, 3.5, 8.0]);
        assert!(resolve(&map, 3).unwrap_err().to_string().contains("samples = 3"));
    }
}
