//! Where cameras stand: as the scene has it, or with regard to the light, so that every case of rectification occurs.

use crate::error::EvaluationError;
use scenes::vector::{dot, norm, normalize};
use scenes::{Camera, LightView, Scene};
use serde::{Deserialize, Serialize};

/// A place that every scene has.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Standpoint {
    /// The scene's own camera.
    Own,
    /// Beyond the middle of the scene, looking into the light: the epipole lies in the middle of the picture.
    Towards,
    /// On the side of the light, looking along it: so does the other epipole.
    Away,
    /// As the scene's own, but under the lowest point of the scene.
    Below,
}

/// A camera.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct StandpointSetting {
    /// Name in records.
    pub name: String,
    /// A place that every scene has; else `eye` and `target` say where.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<Standpoint>,
    /// The one scene that it is for; all without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<String>,
    /// Eye in world space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eye: Option<[f32; 3]>,
    /// Point looked at.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<[f32; 3]>,
    /// Vertical field of view in radians; that of the scene's own camera without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vertical_fov: Option<f32>,
}

/// Middle and radius of the bounds of a scene's vertices, and the height of its lowest.
pub(super) struct Extent {
    pub(super) centre: [f64; 3],
    pub(super) radius: f64,
    lowest: f64,
}

impl Extent {
    pub(super) fn of(scene: &Scene) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for vertex in &scene.vertices {
            for k in 0..3 {
                let value = f64::from(vertex.position[k]);
                (low[k], high[k]) = (low[k].min(value), high[k].max(value));
            }
        }
        let size = [0, 1, 2].map(|k| high[k] - low[k]);
        Self { centre: [0, 1, 2].map(|k| 0.5 * (low[k] + high[k])), radius: 0.5 * norm(size), lowest: low[1] }
    }
}

/// Distance of the cameras on the light's axis from the middle, in radii of the scene: towards the light and along it.
const BEYOND: [f64; 2] = [0.12, 0.9];

/// Depth under the scene in radii.
const UNDER: f64 = 0.03;

impl StandpointSetting {
    /// Rejects cameras that see nothing; `key` is its own.
    pub(super) fn check(&self, key: &str) -> Result<(), EvaluationError> {
        let fail = |part: &str, reason: String| {
            let name = &self.name;
            Err(EvaluationError::key(format!("{key}{part}"), format!("standpoint `{name}`: {reason}")))
        };
        match (self.place, self.eye, self.target) {
            (Some(_), None, None) => {}
            (None, Some(eye), Some(target)) => {
                let numbers = eye.iter().chain(&target);
                if !numbers.clone().all(|c| c.is_finite()) {
                    return fail(".eye", format!("eye = {eye:?} or target = {target:?} is not finite"));
                }
                if eye == target {
                    return fail(
                        ".target",
                        format!("target = {target:?} is the eye: its frustum has no depth"),
                    );
                }
                if self.scene.is_none() {
                    return fail("", "eye and target are places in a scene, which is not named".to_owned());
                }
            }
            (Some(_), _, _) => {
                return fail(".place", "place and eye or target exclude each other".to_owned());
            }
            (None, _, _) => return fail("", "neither place nor eye and target are given".to_owned()),
        }
        match self.vertical_fov {
            Some(fov) if !(fov > 0.0 && fov < std::f32::consts::PI) => {
                fail(".vertical_fov", format!("vertical_fov = {fov} does not lie between 0 and pi"))
            }
            Some(_) | None => Ok(()),
        }
    }

    /// Whether it is for a scene.
    pub(super) fn is_in(&self, scene: &str) -> bool {
        self.scene.as_deref().is_none_or(|name| name == scene)
    }

    /// The camera in a scene under a light that travels along a unit vector.
    pub(super) fn camera(&self, scene: &Scene, extent: &Extent, light: [f64; 3]) -> Camera {
        let own = scene.camera;
        let vertical_fov = self.vertical_fov.unwrap_or(own.vertical_fov);
        let on_axis = |offset: f64, side: f64| {
            let at = |distance: f64| {
                [0, 1, 2].map(|k| (extent.centre[k] + distance * extent.radius * light[k]) as f32)
            };
            Camera::new(at(offset), at(offset + side), vertical_fov)
        };
        match (self.place, self.eye, self.target) {
            (None, Some(eye), Some(target)) => Camera::new(eye, target, vertical_fov),
            (Some(Standpoint::Towards), ..) => {
                let mut camera = on_axis(0.0, -1.0);
                // Near the ground, moved across so that more than the middle of the scene lies between eye and light.
                let across = normalize([light[0], 0.0, light[2]]);
                let aside = if dot(across, across).is_finite() { across } else { [1.0, 0.0, 0.0] };
                let height = extent.lowest + 0.08 * extent.radius;
                let eye = [0, 1, 2].map(|k| {
                    if k == 1 { height } else { extent.centre[k] + BEYOND[0] * extent.radius * aside[k] }
                });
                camera.eye = eye.map(|c| c as f32);
                camera.target = [0, 1, 2].map(|k| (eye[k] - extent.radius * light[k]) as f32);
                camera
            }
            (Some(Standpoint::Away), ..) => on_axis(-BEYOND[1], 1.0),
            (Some(Standpoint::Below), ..) => {
                let y = (extent.lowest - UNDER * extent.radius) as f32;
                Camera { eye: [own.eye[0], y, own.eye[2]], vertical_fov, ..own }
            }
            (Some(Standpoint::Own) | None, ..) => Camera { vertical_fov, ..own },
        }
    }
}

/// The way in which a light view's sun shines, a unit vector; `None` for lights with an extent or a place.
pub(super) fn travel(view: &LightView) -> Option<[f64; 3]> {
    (!view.light.has_extent()).then(|| normalize(view.direction.map(f64::from)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenes::load_scene;

    #[test]
    fn cameras_stand_where_their_names_say() {
        let scene = load_scene("stairs").unwrap();
        let extent = Extent::of(&scene);
        let light = travel(&scene.views[1]).unwrap();
        let of = |place| {
            let setting = StandpointSetting {
                name: "a".into(),
                place: Some(place),
                scene: None,
                eye: None,
                target: None,
                vertical_fov: None,
            };
            setting.check("standpoint[0]").unwrap();
            setting.camera(&scene, &extent, light)
        };
        let along = |camera: Camera| {
            let d: [f64; 3] = std::array::from_fn(|k| f64::from(camera.target[k]) - f64::from(camera.eye[k]));
            dot(normalize(d), light)
        };
        assert!(along(of(Standpoint::Towards)) < -0.999 && along(of(Standpoint::Away)) > 0.999);
        assert_eq!(of(Standpoint::Own), scene.camera);
        assert!(f64::from(of(Standpoint::Below).eye[1]) < extent.lowest);
    }
}
