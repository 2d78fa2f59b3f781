//! Single scattering as an application: view rays ask which share of the light that a medium could scatter is not shadowed.

use super::{LightAxes, LightMap, Medium};
use crate::Application;
use crate::rays::{LastOccluder, Segment, Triangles};
use crate::soft_shadow::{AreaTruth, OccludedFraction};

/// A medium under a directional light, seen from one camera.
#[derive(Clone, Copy)]
pub struct SingleScattering<'a> {
    /// Visibility as the shadow map knows it, in the space of `axes`.
    pub light: LightMap<'a>,
    /// Light space.
    pub axes: LightAxes,
    /// What scatters.
    pub medium: Medium,
    /// Where all view rays begin, world space.
    pub camera: [f64; 3],
}

/// What a pixel looks along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewRay {
    /// Away from the camera, a unit vector in world space.
    pub direction: [f64; 3],
    /// To the surface that is seen; infinite for the sky.
    pub length: f64,
    /// Noise of the pixel in \[0, 1).
    pub noise: f64,
    /// Tells shadow rays of different pixels apart.
    pub stream: u64,
}

/// Optical depth beyond which 5e-5 of the light is left.
const LAST_DEPTH: f64 = 10.0;

impl SingleScattering<'_> {
    /// A ray in light space: origin and direction.
    pub fn in_light_space(&self, ray: &ViewRay) -> ([f64; 3], [f64; 3]) {
        (self.axes.direction(self.camera), self.axes.direction(ray.direction))
    }

    /// The end of a ray, or the distance from which on its visibility no longer changes or hardly any light comes.
    pub fn end(&self, ray: &ViewRay) -> f64 {
        let (origin, direction) = self.in_light_space(ray);
        // Infinite without extinction.
        let visible = LAST_DEPTH / self.medium.extinction();
        ray.length.min(self.light.settled(origin, direction)).min(visible)
    }

    /// Cosine between the ways of the light before and after it is scattered to the camera.
    pub fn scattering_cosine(&self, ray: &ViewRay) -> f64 {
        -self.axes.direction(ray.direction)[2]
    }

    /// The share over a ray of what is lit up to `end`, of which the share is known, and lit or not beyond.
    pub fn joined(&self, ray: &ViewRay, lit: f64, end: f64, is_lit_beyond: bool) -> f64 {
        let within = self.medium.transmitted_length(0.0, end.min(ray.length));
        let beyond = self.medium.transmitted_length(end, ray.length);
        let rest = if is_lit_beyond { 1.0 } else { 0.0 };
        if beyond == f64::INFINITY {
            rest
        } else if within == f64::INFINITY {
            lit
        } else if within + beyond > 0.0 {
            (lit * within + rest * beyond) / (within + beyond)
        } else {
            lit
        }
    }

    /// Whether a ray is lit once its visibility has settled.
    pub fn is_lit_beyond(&self, ray: &ViewRay, end: f64) -> bool {
        let (origin, direction) = self.in_light_space(ray);
        self.light.is_lit([0, 1, 2].map(|k| origin[k] + (end + 1.0) * direction[k]))
    }

    /// The lit share with the geometry itself: shadow rays from points that are as dense as the light that they scatter
    /// reaches the camera. The standard error is that of the share.
    pub fn traced(&self, scene: &Triangles, nets: &AreaTruth, ray: &ViewRay) -> OccludedFraction {
        let end = self.end(ray);
        let towards_light = self.axes.light.map(|c| -c);
        let mut last = LastOccluder::default();
        let shadowed = nets.fraction(ray.stream, |[u, _]| {
            let t = self.medium.distance(u, end);
            let origin = [0, 1, 2].map(|k| self.camera[k] + t * ray.direction[k]);
            let segment = Segment { origin, direction: towards_light, endless: true, from: None };
            scene.occludes_again(&segment, &mut last)
        });
        let is_lit_beyond = self.is_lit_beyond(ray, end);
        let joined = |lit: f64| self.joined(ray, lit, end, is_lit_beyond);
        OccludedFraction {
            fraction: joined(1.0 - shadowed.fraction),
            standard_error: shadowed.standard_error * (joined(1.0) - joined(0.0)),
            rays: shadowed.rays,
        }
    }
}

impl Application for SingleScattering<'_> {
    type Receiver = ViewRay;

    /// The lit share by the shadow map, exactly.
    fn truth(&self, ray: &ViewRay) -> f64 {
        let (origin, direction) = self.in_light_space(ray);
        let lit = self.light.scattered(&self.medium, origin, direction, ray.length);
        let all = self.medium.transmitted_length(0.0, ray.length);
        if lit == f64::INFINITY {
            1.0
        } else if all > 0.0 {
            (lit / all).clamp(0.0, 1.0)
        } else {
            // A ray without length sees the air at the camera.
            f64::from(u8::from(self.light.is_lit(origin)))
        }
    }
}
