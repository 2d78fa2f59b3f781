//! What a camera sees, as receivers on a shadow map.

use scenes::vector::dot;
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

    /// The surface of a pixel with its position on the map; `None` where there is none, and off the map of a local light.
    pub(crate) fn receiver(&self, pixel: usize) -> Option<(Receiver, Position)> {
        if self.frame.triangle[pixel] == NO_TRIANGLE {
            return None;
        }
        let light = self.light;
        let position = self.position(pixel);
        let [x, y, depth] = light.project(position);
        let on_map = |t: f64, size: u32| (0.0..=f64::from(size)).contains(&t);
        if light.eye.is_some() && !(on_map(x, light.width) && on_map(y, light.height) && depth >= 0.0) {
            return None;
        }
        let inside = |t: f64, size: u32| (t.max(0.0) as usize).min(size as usize - 1);
        // The tangent plane in light space: its gradient makes the plane's tangents follow depth.
        let gradient = light.gradient(position, self.normal(pixel));
        let gradient = gradient.map(|slope| if slope.is_finite() { slope } else { 0.0 });
        let receiver = Receiver { x: inside(x, light.width), y: inside(y, light.height), depth, gradient };
        Some((receiver, Position { x, y }))
    }

    /// Whether the side that the camera sees is the one that the light's middle shines on.
    pub(crate) fn faces_light(&self, pixel: usize) -> bool {
        dot(self.normal(pixel), self.light.arriving(self.position(pixel))) < 0.0
    }

    fn position(&self, pixel: usize) -> [f64; 3] {
        self.frame.position[pixel].map(f64::from)
    }

    fn normal(&self, pixel: usize) -> [f64; 3] {
        self.frame.normal[pixel].map(f64::from)
    }
}
