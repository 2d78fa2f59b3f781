//! Light space: from world positions to texels and depth, orthographic for directional lights, perspective for local ones.

mod casters;
mod fit;
mod local;

use scenes::vector::{cross, dot, minus, normalize};
use scenes::{AreaLight, LightView, Scene};

use crate::RenderError;
pub use local::LocalLightError;

/// Largest supported width and height of a shadow map in texels.
pub const MAX_MAP_SIZE: u32 = 8192;

/// Empty texels kept on every side of a fitted map of at least 45 texels, one more than the radius of a 9x9
/// kernel, so that kernels at the scene's outline see emptiness. Smaller maps keep fewer: see
/// [`LightFrame::fit`].
pub const FIT_MARGIN: u32 = 5;

/// Orthographic projection of a directional light, or perspective projection from the centre of a local one.
///
/// Texel x grows to the right and texel y downwards as seen along the light, depth grows along the light:
/// (right, down, forward) is a right-handed orthonormal frame. Texel (i, j) covers [i, i+1) x [j, j+1), its centre
/// is (i + 0.5, j + 0.5).
///
/// Depth is linear in the distance along `forward` under both (TC09 section 4). With q the position, taken from `eye`
/// where there is one, Z = q . forward and the near plane's distance n:
///
/// texel = (q . right, q . down) s texels_per_unit + origin_texel, with s = 1, or s = n / Z in perspective;
/// depth = (Z - n) / depth_range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightFrame {
    /// World direction of growing texel x, unit length.
    pub right: [f64; 3],
    /// World direction of growing texel y, unit length.
    pub down: [f64; 3],
    /// World direction in which the light travels and depth grows, unit length.
    pub forward: [f64; 3],
    /// The centre of a local light, from which its map is seen; `None` for a directional light.
    pub eye: Option<[f64; 3]>,
    /// Texels per world unit in x and in y; of a local light on the plane of depth 0.
    pub texels_per_unit: [f64; 2],
    /// Texel coordinates of the world's origin, or of the axis through the local light's centre.
    pub origin_texel: [f64; 2],
    /// Distance along `forward`, from the world's origin or the local light's centre, that has depth 0. Positive for a local
    /// light: nothing nearer is on its map.
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

    /// Fits the triangles of `scene` into the map of a view. That of the sun is [`LightFrame::fit`].
    ///
    /// A local light sees what lies in front of it, along U x V and as far as 63 degrees to all four sides of the map; the
    /// rest is cut off. The map's rows run along U, and its columns along V where U and V are perpendicular. x and y are
    /// fitted on their own and with the same margin, depth goes from 0 at the first to 1 at the last surface.
    ///
    /// # Errors
    /// Those of [`LightFrame::fit`], and [`RenderError::Light`] for a local light inside the scene or behind it.
    pub fn of_view(scene: &Scene, view: &LightView, width: u32, height: u32) -> Result<Self, RenderError> {
        match view.light {
            AreaLight::Sun { .. } => Self::fit(scene, view.direction, width, height),
            AreaLight::Local { outline, centre, half_axes } => {
                Self::fit_local(scene, (outline, centre, half_axes), [width, height])
            }
        }
    }

    /// Texel coordinates and depth of a world position; depth is not clamped. In perspective texels are meant for
    /// positions in front of the light; in the plane of its centre they are not finite.
    pub fn project(&self, position: [f64; 3]) -> [f64; 3] {
        self.on_map(self.light_space(position))
    }

    /// A position along the frame's axes, from the world's origin or the eye.
    pub(crate) fn light_space(&self, position: [f64; 3]) -> [f64; 3] {
        let from_eye = self.eye.map_or(position, |eye| minus(position, eye));
        [self.right, self.down, self.forward].map(|axis| dot(from_eye, axis))
    }

    /// Texel coordinates and depth in place of light space.
    pub(crate) fn on_map(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [x, y] = if self.eye.is_some() { [x, y].map(|c| c * (self.near / z)) } else { [x, y] };
        [
            x * self.texels_per_unit[0] + self.origin_texel[0],
            y * self.texels_per_unit[1] + self.origin_texel[1],
            (z - self.near) / self.depth_range,
        ]
    }

    /// The world position at texel coordinates and depth: undoes [`LightFrame::project`] for positions in front.
    pub fn unproject(&self, [x, y, depth]: [f64; 3]) -> [f64; 3] {
        let z = self.near + depth * self.depth_range;
        let scale = if self.eye.is_some() { z / self.near } else { 1.0 };
        let along = |k: usize, texel: f64| (texel - self.origin_texel[k]) / self.texels_per_unit[k] * scale;
        let (x, y) = (along(0, x), along(1, y));
        let origin = self.eye.unwrap_or_default();
        [0, 1, 2].map(|k| origin[k] + x * self.right[k] + y * self.down[k] + z * self.forward[k])
    }

    /// By how much the depth of a plane through a place in light space may change from a texel's centre to its border; infinite
    /// for a plane along the light.
    pub(crate) fn texel_slope(&self, seen: [f64; 3], normal: [f64; 3]) -> f64 {
        let n = [self.right, self.down, self.forward].map(|axis| dot(normal, axis));
        let ray = if self.eye.is_some() { normalize(seen) } else { [0.0, 0.0, 1.0] };
        let cosine = dot(n, ray).abs().min(1.0);
        let widening = if self.eye.is_some() { seen[2] / self.near } else { 1.0 };
        let half_texel = 0.5 * widening * self.texels_per_unit.iter().map(|texels| 1.0 / texels).sum::<f64>();
        let tangent = (1.0 - cosine * cosine).sqrt() / cosine;
        if tangent.is_finite() { half_texel * tangent / self.depth_range } else { f64::INFINITY }
    }

    /// The unit direction in which the light's middle shines at a world position; not finite at the light itself.
    pub fn arriving(&self, position: [f64; 3]) -> [f64; 3] {
        self.eye.map_or(self.forward, |eye| normalize(minus(position, eye)))
    }

    /// d depth / d texel x, d texel y of the plane through a world position with a given normal; not finite for planes that
    /// the light sees edge-on.
    pub fn gradient(&self, position: [f64; 3], normal: [f64; 3]) -> [f64; 2] {
        let across = [self.right, self.down].map(|axis| dot(normal, axis));
        // 1 / Z is linear over the map; its slope times -Z^2 is that of Z.
        let per_slope = match self.eye {
            None => dot(normal, self.forward),
            Some(eye) => {
                let from_eye = minus(position, eye);
                dot(normal, from_eye) * self.near / dot(from_eye, self.forward).powi(2)
            }
        };
        [0, 1].map(|k| -across[k] / (per_slope * self.texels_per_unit[k] * self.depth_range))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames() -> [LightFrame; 2] {
        let [right, down, forward] = LightFrame::axes([0.3, -1.0, 0.2]).unwrap();
        let directional = LightFrame {
            right,
            down,
            forward,
            eye: None,
            texels_per_unit: [20.0, 35.0],
            origin_texel: [12.0, -3.0],
            near: 1.5,
            depth_range: 9.0,
            width: 64,
            height: 64,
        };
        [directional, LightFrame { eye: Some([2.0, 8.0, -1.0]), ..directional }]
    }

    #[test]
    fn positions_come_back() {
        let position = [1.5, -0.25, 7.0];
        for frame in frames() {
            let back = frame.unproject(frame.project(position));
            assert!((0..3).all(|k| (back[k] - position[k]).abs() < 1e-13), "{back:?}");
        }
    }

    #[test]
    fn gradients_are_differences_along_the_plane() {
        let (position, normal) = ([1.5, -0.25, 2.0], [0.2, 0.9, -0.3]);
        for frame in frames() {
            let at = frame.project(position);
            let gradient = frame.gradient(position, normal);
            for k in 0..2 {
                // Where the ray of a neighbouring texel meets the plane.
                let mut texel = at;
                texel[k] += 1e-4;
                let near = frame.unproject(texel);
                let along = match frame.eye {
                    Some(eye) => minus(near, eye),
                    None => frame.forward,
                };
                let t = dot(normal, minus(position, near)) / dot(normal, along);
                let met = [0, 1, 2].map(|i| near[i] + t * along[i]);
                let slope = (frame.project(met)[2] - at[2]) / 1e-4;
                assert!((slope / gradient[k] - 1.0).abs() < 1e-4, "{slope} {gradient:?}");
            }
        }
        let [sun, lamp] = frames();
        assert_eq!(sun.arriving(position), sun.forward);
        assert_eq!(lamp.arriving([2.0, 5.0, -1.0]), [0.0, -1.0, 0.0]);
    }

    #[test]
    fn a_scene_far_away_has_the_stack_that_it_has_at_the_origin() {
        let tower = |[x, y, z]: [f64; 3]| {
            let corners = [
                [-20.0, 0.0, 20.0],
                [20.0, 0.0, 20.0],
                [20.0, 0.0, -20.0],
                [-20.0, 0.0, -20.0],
                [-0.05, 0.0, 0.05],
                [0.05, 0.0, 0.05],
                [0.0, 0.0, -0.05],
                [0.013, 6.0, 0.0],
            ];
            let vertices: String =
                corners.iter().map(|c| format!("v {} {} {}\n", c[0] + x, c[1] + y, c[2] + z)).collect();
            let text = format!("{vertices}f 1 2 3 4\nf 5 6 8\nf 6 7 8\nf 7 5 8\n");
            let scene = scenes::load_obj_bytes("tower.obj", text.as_bytes()).unwrap();
            crate::render_view(&scene, &scene.views[0], 256, 256, crate::Backend::Cpu).unwrap()
        };
        let (near, _) = tower([0.0; 3]);
        for place in [[447_312.37, 211.4, 5_411_873.62], [-1e9, 0.0, 1e9]] {
            let (far, _) = tower(place);
            assert_eq!(near.offsets, far.offsets, "{place:?}");
            let farthest =
                |a: &[f32], b: &[f32]| a.iter().zip(b).fold(0.0_f32, |m, (a, b)| m.max((a - b).abs()));
            assert!(farthest(&near.depths, &far.depths) < 1e-6, "{place:?}");
            assert!(
                farthest(near.gradients.as_flattened(), far.gradients.as_flattened()) < 1e-5,
                "{place:?}"
            );
        }
    }
}
