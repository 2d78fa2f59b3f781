//! A light with extent in the frame of its map.

use applications::PlacedLight;
use applications::soft_shadow::Penumbra;
use scenes::vector::dot;
use scenes::{AreaLight, Outline};
use shadow_renderer::LightFrame;

/// The light where shadow rays find it.
pub(crate) fn placed(light: &AreaLight, frame: &LightFrame) -> PlacedLight {
    PlacedLight::new(light, [frame.right, frame.down, frame.forward])
}

/// How the light's size, the map and depths hang together: full widths in texels for given depths of receiver and blocker.
///
/// A rectangle whose half axes are not perpendicular counts as the one around it along the map's axes, and so does an
/// ellipse whose axes are none of the map's.
pub(crate) fn penumbra(light: &AreaLight, frame: &LightFrame) -> Penumbra<f64> {
    let half_size = match *light {
        AreaLight::Sun { degrees, .. } => degrees.map(|size| (0.5 * size.to_radians()).tan()),
        AreaLight::Local { outline, half_axes, .. } => [frame.right, frame.down].map(|axis| {
            let [u, v] = half_axes.map(|half| dot(half, axis).abs());
            match outline {
                Outline::Rectangle => u + v,
                Outline::Disc => u.hypot(v),
            }
        }),
    };
    let near = frame.eye.map(|_| frame.near);
    Penumbra { half_size, near, depth_range: frame.depth_range, texels_per_unit: frame.texels_per_unit }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenes::load_scene;

    /// A receiver and a blocker under the lamp of a scene: the corners of the light, seen through the blocker, fall on the
    /// corners of the filter.
    #[test]
    fn filters_hold_the_light_as_seen_through_a_blocker() {
        let scene = load_scene("stairs").unwrap();
        for name in ["lamp", "wide"] {
            let view = scene.views.iter().find(|view| view.name == name).unwrap();
            let frame = LightFrame::of_view(&scene, view, 512, 256).unwrap();
            let (penumbra, placed) = (penumbra(&view.light, &frame), placed(&view.light, &frame));
            let receiver = [301.2, 97.5, 0.8];
            let position = frame.unproject(receiver);
            // Far ends of both half axes.
            for (k, end) in [(0, [1.0, 0.5]), (1, [0.5, 1.0])] {
                let towards = placed.towards(position, end);
                for blocker in [0.3, 0.6] {
                    let distance = (receiver[2] - blocker) * frame.depth_range;
                    let share = distance / -dot(towards, frame.forward);
                    let met = frame.project([0, 1, 2].map(|i| position[i] + share * towards[i]));
                    assert!((met[2] - blocker).abs() < 1e-12, "{name}: {met:?}");
                    let half = 0.5 * penumbra.filter(receiver[2], blocker)[k];
                    assert!(
                        ((met[k] - receiver[k]).abs() - half).abs() < 1e-9 * half,
                        "{name}: {met:?} {half}"
                    );
                    assert!((met[1 - k] - receiver[1 - k]).abs() < 1e-9, "{name}: {met:?}");
                }
            }
        }
    }
}
