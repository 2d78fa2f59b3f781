//! Filtered planes of a map, and the shadow that they say of a surface (SSSM15 section 6).

use shadow_filtering::{FilteringError, Precision, Technique};
use std::ops::Range;

use super::filter::between_planes;
use super::plane::FilteredPlane;

/// Planes, and one of the representations that they hold.
pub struct PlaneSet<'a, R> {
    /// Distances from the light, ascending, one a plane.
    pub distances: &'a [R],
    /// The planes.
    pub planes: &'a [FilteredPlane<R>],
    /// The representation, as it was stored.
    pub technique: &'a Technique,
    /// Its values among those of a texel.
    pub channels: Range<usize>,
    /// Whether shadows of two planes are interpolated, in place of values.
    pub blend_shadows: bool,
}

/// A surface as a map of the light's middle sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneFragment<R> {
    /// In texels.
    pub position: [R; 2],
    /// Distance from the light's plane.
    pub distance: R,
    /// Depth in \[0, 1\] that is compared.
    pub compared: R,
}

impl<R: Precision> PlaneSet<'_, R> {
    /// The share of the light that is hidden; `None` where no sample reaches the surface.
    ///
    /// # Errors
    /// As [`Technique::shade`].
    pub fn shadow(&self, fragment: &PlaneFragment<R>) -> Result<Option<R>, FilteringError> {
        let Some((lower, share)) = between_planes(self.distances, fragment.distance) else { return Ok(None) };
        let upper = (lower + 1).min(self.planes.len() - 1);
        let read = |plane: usize| {
            let plane = &self.planes[plane];
            let mut values = vec![R::zero(); plane.channels];
            plane.at(fragment.position, &mut values)?;
            Some(values[self.channels.clone()].to_vec())
        };
        let shade = |values: &[R]| {
            let mut b = vec![R::zero(); values.len()];
            self.technique.restore(values, &mut b);
            self.technique.shade(&b, fragment.compared)
        };
        let (near, far) = (read(lower), if share > R::zero() { read(upper) } else { None });
        Ok(match (near, far) {
            (Some(near), Some(far)) if self.blend_shadows => {
                let (near, far) = (shade(&near)?, shade(&far)?);
                Some(near + share * (far - near))
            }
            (Some(near), Some(far)) => {
                let pairs = near.iter().zip(&far);
                let blended: Vec<R> = pairs.map(|(&a, &b)| a + share * (b - a)).collect();
                Some(shade(&blended)?)
            }
            (Some(one), None) | (None, Some(one)) => Some(shade(&one)?),
            (None, None) => None,
        })
    }
}
