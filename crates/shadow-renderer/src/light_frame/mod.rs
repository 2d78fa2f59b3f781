//! Orthographic light space: from world positions to texels and depth.

mod fit;

use scenes::vector::{cross, dot, normalize};

use crate::RenderError;

/// Largest supported width and height of a shadow map in texels.
pub const MAX_MAP_SIZE: u32 = 8192;

/// Empty texels kept on every side of a fitted map of at least 45 texels, one more than the radius of a 9x9
/// kernel, so that kernels at the scene's outline see emptiness. Smaller maps keep fewer: see
/// [`LightFrame::fit`].
pub const FIT_MARGIN: u32 = 5;

/// Orthographic projection of a directional light.
///
/// Texel x grows to the right and texel y downwards as seen along the light, depth grows along the light:
/// (right, down, forward) is a right-handed orthonormal frame. Texel (i, j) covers [i, i+1) x [j, j+1), its centre
/// is (i + 0.5, j + 0.5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightFrame {
    /// World direction of growing texel x, unit length.
    pub right: [f64; 3],
    /// World direction of growing texel y, unit length.
    pub down: [f64; 3],
    /// World direction in which the light travels and depth grows, unit length.
    pub forward: [f64; 3],
    /// Texels per world unit in x and in y.
    pub texels_per_unit: [f64; 2],
    /// Texel coordinates of the world's origin.
    pub origin_texel: [f64; 2],
    /// Distance along `forward` that has depth 0.
    pub near: f64,
    /// Distance along `forward` from depth 0 to depth 1, positive.
    pub depth_range: f64,
    /// Map width in texels.
    pub width: u32,
    /// Map height in texels.
    pub height: u32,
}

/// Checks a map size against [`MAX_MAP_SIZE`].
pub(crate) fn check_size(width: u32, height: u32) -> Result<(), RenderError> {
    if width == 0 || height == 0 || width > MAX_MAP_SIZE || height > MAX_MAP_SIZE {
        return Err(RenderError::MapSize { width, height });
    }
    Ok(())
}

impl LightFrame {
    /// The frame's axes for a light travelling along `direction`, as (right, down, forward).
    ///
    /// Upwards on the map is the world's y axis; for lights within about 2.6 degrees of vertical it is the negative
    /// z axis, so that the choice is deterministic and well conditioned.
    ///
    /// # Errors
    /// [`RenderError::LightDirection`] if a component is not finite or all are zero.
    fn axes(direction: [f32; 3]) -> Result<[[f64; 3]; 3], RenderError> {
        let largest = direction.iter().fold(0.0f32, |m, c| m.max(c.abs()));
        if !direction.iter().all(|c| c.is_finite()) || largest == 0.0 {
            return Err(RenderError::LightDirection(direction));
        }
        // Dividing by the largest component first keeps denormal directions exact enough to normalise.
        let forward = normalize(direction.map(|c| f64::from(c) / f64::from(largest)));
        let up = if forward[1].abs() > 0.999 { [0.0, 0.0, -1.0] } else { [0.0, 1.0, 0.0] };
        let right = normalize(cross(forward, up));
        Ok([right, cross(forward, right), forward])
    }

    /// Texel coordinates and depth of a world position; depth is not clamped.
    pub fn project(&self, position: [f64; 3]) -> [f64; 3] {
        [
            dot(position, self.right) * self.texels_per_unit[0] + self.origin_texel[0],
            dot(position, self.down) * self.texels_per_unit[1] + self.origin_texel[1],
            (dot(position, self.forward) - self.near) / self.depth_range,
        ]
    }

    /// The world position at texel coordinates and a depth: the inverse of [`LightFrame::project`].
    pub fn unproject(&self, [x, y, depth]: [f64; 3]) -> [f64; 3] {
        let along = [
            (x - self.origin_texel[0]) / self.texels_per_unit[0],
            (y - self.origin_texel[1]) / self.texels_per_unit[1],
            self.near + depth * self.depth_range,
        ];
        let axes = [self.right, self.down, self.forward];
        [0, 1, 2].map(|k| axes.iter().zip(along).map(|(axis, t)| axis[k] * t).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_come_back() {
        let [right, down, forward] = LightFrame::axes([0.3, -1.0, 0.2]).unwrap();
        let frame = LightFrame {
            right,
            down,
            forward,
            texels_per_unit: [20.0, 35.0],
            origin_texel: [12.0, -3.0],
            near: -4.0,
            depth_range: 9.0,
            width: 64,
            height: 64,
        };
        let position = [1.5, -0.25, 7.0];
        let back = frame.unproject(frame.project(position));
        assert!((0..3).all(|k| (back[k] - position[k]).abs() < 1e-13), "{back:?}");
    }
}
