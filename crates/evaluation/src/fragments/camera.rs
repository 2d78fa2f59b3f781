//! What a camera sees, as receivers on a shadow map.

use shadow_filtering::{Position, Receiver};
use shadow_renderer::{Frame, LightFrame, NO_TRIANGLE};

/// The pixels of a frame in the light's space.
pub(crate) struct Seen<'a> {
    pub(crate) frame: &'a Frame,
    pub(crate) light: &'a LightFrame,
}

impl Seen<'_> {
    /// Number of pixels.
    pub(crate) fn len(&self) -> usize {
        self.frame.triangle.len()
    }

    /// The surface of a pixel with its position on the map; `None` where there is none.
    pub(crate) fn receiver(&self, pixel: usize) -> Option<(Receiver, Position)> {
        if self.frame.triangle[pixel] == NO_TRIANGLE {
            return None;
        }
        let light = self.light;
        let [x, y, depth] = light.project(self.frame.position[pixel].map(f64::from));
        let inside = |t: f64, size: u32| (t.max(0.0) as usize).min(size as usize - 1);
        // The tangent plane in light space: its gradient makes the plane's tangents follow depth.
        let along = self.towards(pixel, light.forward) * light.depth_range;
        let slope = |axis: [f64; 3], texels: f64| {
            let slope = -self.towards(pixel, axis) / (texels * along);
            if slope.is_finite() { slope } else { 0.0 }
        };
        let gradient =
            [slope(light.right, light.texels_per_unit[0]), slope(light.down, light.texels_per_unit[1])];
        let receiver = Receiver { x: inside(x, light.width), y: inside(y, light.height), depth, gradient };
        Some((receiver, Position { x, y }))
    }

    /// Whether the side that the camera sees is the one that the light's middle shines on.
    pub(crate) fn faces_light(&self, pixel: usize) -> bool {
        self.towards(pixel, self.light.forward) < 0.0
    }

    /// Component of the pixel's normal along an axis.
    fn towards(&self, pixel: usize, axis: [f64; 3]) -> f64 {
        (0..3).map(|k| axis[k] * f64::from(self.frame.normal[pixel][k])).sum()
    }
}
