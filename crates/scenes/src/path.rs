//! Cameras that move: frames in a row along a path.

use serde::{Deserialize, Serialize};

use crate::Camera;
use crate::vector::minus;

/// How a camera moves.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Movement {
    /// Not at all.
    Still,
    /// It turns about its own vertical.
    Pan,
    /// It goes around what it looks at.
    Orbit,
    /// It stands still, and halfway through it is elsewhere on its orbit.
    Cut,
}

/// A camera's way through so many frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraPath {
    /// How it moves.
    pub movement: Movement,
    /// Degrees from frame to frame; of a cut, those of its jump.
    pub degrees: f64,
    /// By how much narrower the field of view is than the scene's: its tangent is divided by this.
    pub zoom: f64,
    /// Number of frames.
    pub frames: usize,
}

impl CameraPath {
    /// The camera of a frame, counted from 0, for a scene whose own camera is `start`.
    pub fn camera(&self, start: &Camera, frame: usize) -> Camera {
        let steps = match self.movement {
            Movement::Still => 0.0,
            Movement::Pan | Movement::Orbit => frame as f64,
            Movement::Cut => f64::from(u8::from(2 * frame >= self.frames)),
        };
        let tangent = (0.5 * f64::from(start.vertical_fov)).tan() / self.zoom;
        let camera = Camera { vertical_fov: (2.0 * tangent.atan()) as f32, ..*start };
        if steps == 0.0 {
            return camera;
        }
        let (sin, cos) = (steps * self.degrees).to_radians().sin_cos();
        let turned = |centre: [f32; 3], point: [f32; 3]| {
            let [x, y, z] = minus(point.map(f64::from), centre.map(f64::from));
            let around = [cos * x + sin * z, y, cos * z - sin * x];
            [0, 1, 2].map(|k| (f64::from(centre[k]) + around[k]) as f32)
        };
        match self.movement {
            Movement::Pan => Camera { target: turned(start.eye, start.target), ..camera },
            Movement::Still | Movement::Orbit | Movement::Cut => {
                Camera { eye: turned(start.target, start.eye), ..camera }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::norm;

    const START: Camera = Camera::new([3.0, 2.0, 0.0], [0.0, 1.0, 0.0], 1.0);

    fn path(movement: Movement) -> CameraPath {
        CameraPath { movement, degrees: 90.0, zoom: 1.0, frames: 10 }
    }

    #[test]
    fn each_movement_keeps_what_it_should() {
        let still = path(Movement::Still);
        assert_eq!(
            (0..10).map(|frame| still.camera(&START, frame).eye).max_by(|a, b| a[0].total_cmp(&b[0])),
            Some(START.eye)
        );
        let orbit = path(Movement::Orbit).camera(&START, 1);
        assert!((orbit.eye[0], orbit.target) == (orbit.eye[0].clamp(-1e-6, 1e-6), START.target), "{orbit:?}");
        assert!((f64::from(orbit.eye[2]) + 3.0).abs() < 1e-6 && orbit.eye[1] == 2.0, "{orbit:?}");
        let pan = path(Movement::Pan).camera(&START, 3);
        assert_eq!(pan.eye, START.eye);
        let length = |camera: &Camera| norm(minus(camera.target.map(f64::from), camera.eye.map(f64::from)));
        assert!((length(&pan) - length(&START)).abs() < 1e-6 && pan.target != START.target);
        let cut = path(Movement::Cut);
        assert_eq!(cut.camera(&START, 4).eye, START.eye);
        assert_eq!(cut.camera(&START, 5).eye, cut.camera(&START, 9).eye);
        assert_eq!(cut.camera(&START, 5).eye, orbit.eye);
    }

    #[test]
    fn zoom_divides_the_tangent() {
        let zoomed = CameraPath { zoom: 2.0, ..path(Movement::Still) }.camera(&START, 0);
        let tangent = |camera: &Camera| (0.5 * f64::from(camera.vertical_fov)).tan();
        assert!((tangent(&START) / tangent(&zoomed) - 2.0).abs() < 1e-6);
    }
}
