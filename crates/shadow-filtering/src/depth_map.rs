//! Maps of depths and of filterable channels.

use crate::error::FilteringError;
use moment_problem::arithmetic::Real;

/// An ordinary shadow map: one depth a texel in \[0, 1\], row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthMap {
    width: usize,
    height: usize,
    depths: Vec<f32>,
    clamped: usize,
}

impl DepthMap {
    /// Takes depths row by row; empty texels are given as 1 by the caller. Depths outside \[0, 1\], infinities
    /// included, are clamped and counted, because a warp would turn them into infinity.
    ///
    /// # Errors
    /// [`FilteringError::Length`], and [`FilteringError::NotFinite`] for NaN, which has no place in the order.
    pub fn new(width: usize, height: usize, mut depths: Vec<f32>) -> Result<Self, FilteringError> {
        check_length(width, height, 1, depths.len())?;
        let mut clamped = 0;
        for (texel, depth) in depths.iter_mut().enumerate() {
            if depth.is_nan() {
                let (x, y) = (texel % width, texel / width);
                return Err(FilteringError::NotFinite { x, y, channel: 0, value: f64::from(*depth) });
            }
            if !(0.0..=1.0).contains(depth) {
                *depth = depth.clamp(0.0, 1.0);
                clamped += 1;
            }
        }
        Ok(Self { width, height, depths, clamped })
    }

    /// Width in texels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in texels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Depths, row-major.
    pub fn depths(&self) -> &[f32] {
        &self.depths
    }

    /// How many depths lay outside \[0, 1\].
    pub fn clamped(&self) -> usize {
        self.clamped
    }

    /// Depth of a texel; beyond the border that of the nearest texel, the same rule as every filter's.
    #[inline]
    pub fn at(&self, x: isize, y: isize) -> f32 {
        let column = x.clamp(0, self.width as isize - 1) as usize;
        let row = y.clamp(0, self.height as isize - 1) as usize;
        self.depths[row * self.width + column]
    }
}

/// A shadow map of any number of channels, interleaved: channel c of texel (x, y) is value
/// `(y * width + x) * channels + c`. All values are finite.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelMap<R> {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) channels: usize,
    pub(crate) data: Vec<R>,
}

impl<R: Real> ChannelMap<R> {
    /// Takes the values.
    ///
    /// # Errors
    /// [`FilteringError::Length`], and [`FilteringError::NotFinite`] for the first NaN or infinity.
    pub fn new(width: usize, height: usize, channels: usize, data: Vec<R>) -> Result<Self, FilteringError> {
        check_length(width, height, channels, data.len())?;
        if let Some(i) = data.iter().position(|value| !value.to_f64().is_finite()) {
            let texel = i / channels;
            return Err(FilteringError::NotFinite {
                x: texel % width,
                y: texel / width,
                channel: i % channels,
                value: data[i].to_f64(),
            });
        }
        Ok(Self { width, height, channels, data })
    }

    /// Width in texels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in texels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Values a texel.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// All values.
    pub fn data(&self) -> &[R] {
        &self.data
    }

    /// The channels of a texel.
    ///
    /// # Panics
    /// If the texel lies outside of the map.
    #[inline]
    pub fn texel(&self, x: usize, y: usize) -> &[R] {
        assert!(x < self.width && y < self.height, "texel ({x}, {y}) of {}x{}", self.width, self.height);
        let start = (y * self.width + x) * self.channels;
        &self.data[start..start + self.channels]
    }
}

fn check_length(width: usize, height: usize, channels: usize, got: usize) -> Result<(), FilteringError> {
    let expected = width.checked_mul(height).and_then(|texels| texels.checked_mul(channels));
    if got == 0 || expected != Some(got) {
        return Err(FilteringError::Length { width, height, channels, got });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_outside_are_clamped_and_counted_and_nan_is_an_error() {
        let map = DepthMap::new(3, 1, vec![-0.5, f32::INFINITY, 0.25]).unwrap();
        assert_eq!((map.depths(), map.clamped()), (&[0.0, 1.0, 0.25][..], 2));
        assert_eq!((map.at(-7, 3), map.at(9, 0)), (0.0, 0.25));
        let error = DepthMap::new(2, 2, vec![0.0, 0.1, f32::NAN, 0.2]).unwrap_err().to_string();
        assert!(error.contains("(0, 1)") && error.contains("NaN"), "{error}");
        assert!(DepthMap::new(2, 2, vec![0.0; 3]).unwrap_err().to_string().contains("2x2"));
        assert!(DepthMap::new(0, 2, vec![]).is_err());
    }

    #[test]
    fn channels_must_be_finite() {
        let error = ChannelMap::new(2, 1, 2, vec![0.0, 1.0, 2.0, f64::NAN]).unwrap_err().to_string();
        assert!(error.contains("(1, 0), channel 1 holds NaN"), "{error}");
        assert!(ChannelMap::new(2, 1, 2, vec![0.0, 1.0, f32::INFINITY, 0.0]).is_err());
        assert!(ChannelMap::<f64>::new(2, 1, 0, vec![]).is_err());
    }
}
