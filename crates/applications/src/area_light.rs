//! Area lights in the world, as shadow rays find them.

use scenes::vector::{cross, dot, norm};
use scenes::{AreaLight, Outline};

use crate::samples::concentric_disc;

/// A light in the world. Directions to a light at infinity are taken from its tangent plane at distance 1, on which
/// areas are measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedLight {
    /// Disc or rectangle.
    pub outline: Outline,
    /// World position of the middle, or the unit direction towards it.
    pub middle: [f64; 3],
    /// Half axes about the middle.
    pub half_axes: [[f64; 3]; 2],
    /// Whether the light is a set of directions.
    pub at_infinity: bool,
}

impl PlacedLight {
    /// The light where shadow rays find it. `frame` holds the view's right, down and forward axes, orthonormal, with
    /// forward the way the light travels; a local light does without.
    pub fn new(light: &AreaLight, frame: [[f64; 3]; 3]) -> Self {
        match *light {
            AreaLight::Sun { outline, degrees } => {
                let [right, down, forward] = frame;
                let [a, b] = degrees.map(|size| (0.5 * size.to_radians()).tan());
                Self {
                    outline,
                    middle: forward.map(|c| -c),
                    half_axes: [right.map(|c| a * c), down.map(|c| b * c)],
                    at_infinity: true,
                }
            }
            AreaLight::Local { outline, centre, half_axes } => {
                Self { outline, middle: centre, half_axes, at_infinity: false }
            }
        }
    }

    /// The vector from `receiver` to the point of the light that a point of \[0, 1)^2 stands for: it ends on the
    /// light, or goes on for ever. Equal areas of the square are equal areas of the light.
    pub fn towards(&self, receiver: [f64; 3], [x, y]: [f64; 2]) -> [f64; 3] {
        let square = [2.0 * x - 1.0, 2.0 * y - 1.0];
        let [u, v] = match self.outline {
            Outline::Rectangle => square,
            Outline::Disc => concentric_disc(square),
        };
        let [a, b] = self.half_axes;
        let origin = if self.at_infinity { [0.0; 3] } else { receiver };
        [0, 1, 2].map(|k| self.middle[k] + u * a[k] + v * b[k] - origin[k])
    }

    /// Distance of a local light's plane from a point, positive in front of U x V.
    pub fn height(&self, point: [f64; 3]) -> f64 {
        let [u, v] = self.half_axes;
        let normal = cross(u, v);
        dot([0, 1, 2].map(|k| point[k] - self.middle[k]), normal) / norm(normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_end_on_the_light() {
        let axes = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]];
        let sun = AreaLight::sun(Outline::Rectangle, [90.0, 0.0]).unwrap();
        let corner = PlacedLight::new(&sun, axes).towards([5.0, 6.0, 7.0], [1.0, 0.5]);
        assert!(norm([corner[0] - 1.0, corner[1] - 1.0, corner[2]]) < 1e-15, "{corner:?}");
        let lamp = AreaLight::local(Outline::Rectangle, [0.0, 3.0, 0.0], [[1.0, 0.0, 0.0], [0.0, 0.0, 2.0]]);
        let lamp = PlacedLight::new(&lamp.unwrap(), axes);
        assert_eq!(lamp.towards([1.0, 1.0, 1.0], [0.0, 1.0]), [-2.0, 2.0, 1.0]);
        assert_eq!(lamp.height([7.0, 1.0, -3.0]), 2.0);
    }
}
