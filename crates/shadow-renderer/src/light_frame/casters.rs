//! A light frame around what casts shadows: one huge plane below a small model would leave the model a few texels.

use std::collections::{HashMap, HashSet};

use scenes::vector::{cross, dot, minus, norm, normalize};
use scenes::{Scene, Vertex};

use super::LightFrame;
use crate::RenderError;
use crate::clip::{HalfSpace, clip};

/// Most planes, the largest first, that are looked at: each takes a pass over all vertices.
const PLANES: usize = 64;

/// Distance behind a plane, as a share of the scene's extent, at which a vertex still counts as lying in it: 16 times the
/// rounding of positions in single precision.
const IN_PLANE: f64 = 1e-6;

/// Steps for each component of a normal by which planes are told apart before they are measured.
const NORMAL_STEPS: f64 = 4096.0;

/// Texels beyond the map's border that receivers still cover.
const BORDER: f64 = 2.0;

/// Position, normal, texture coordinates and colour of a corner in light space.
type Corner = [f64; 12];

impl LightFrame {
    /// As [`LightFrame::fit`], around the triangles that can cast shadows; the scene comes back with what merely receives them
    /// cut at the map's border. A triangle casts none where the whole scene lies on the lit side of its plane.
    ///
    /// # Errors
    /// Those of [`LightFrame::fit`].
    pub fn fit_casters(
        scene: &Scene,
        direction: [f32; 3],
        width: u32,
        height: u32,
    ) -> Result<(Scene, Self), RenderError> {
        let whole = Self::fit(scene, direction, width, height)?;
        let receives = receivers(scene, whole.forward);
        if receives.iter().all(|&receives| receives) {
            return Ok((scene.clone(), whole));
        }
        let casters = |of: &Scene| Scene {
            triangles: kept(&of.triangles, &receives),
            triangle_material: kept(&of.triangle_material, &receives),
            ..of.clone()
        };
        let mut cut = casters(scene);
        let around = Self::fit(&cut, direction, width, height)?;
        let mut depths = cut
            .triangles
            .iter()
            .flatten()
            .map(|&i| dot(cut.vertices[i as usize].position.map(f64::from), around.forward))
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)]);
        let shown = shown(&around);
        for (triangle, _) in receives.iter().enumerate().filter(|(_, receives)| **receives) {
            let corners = scene.triangles[triangle].map(|i| corner(scene, &around, i as usize));
            let polygon = clip(corners.to_vec(), &shown);
            let first = cut.vertices.len() as u32;
            for corner in &polygon {
                depths = [depths[0].min(corner[2]), depths[1].max(corner[2])];
                add(&mut cut, &around, corner);
            }
            for i in 2..polygon.len() as u32 {
                cut.triangles.push([first, first + i - 1, first + i]);
                cut.triangle_material.push(scene.triangle_material[triangle]);
            }
        }
        let range = depths[1] - depths[0];
        let frame = Self { near: depths[0], depth_range: if range > 0.0 { range } else { 1.0 }, ..around };
        Ok((cut, frame))
    }
}

fn kept<T: Copy>(list: &[T], receives: &[bool]) -> Vec<T> {
    list.iter().zip(receives).filter(|(_, receives)| !**receives).map(|(&kept, _)| kept).collect()
}

/// The map with a border, in light space.
fn shown(frame: &LightFrame) -> [HalfSpace; 4] {
    let side = |k: usize, sign: f64, at: f64| {
        let mut normal = [0.0; 3];
        normal[k] = sign * frame.texels_per_unit[k];
        (normal, sign * (at - frame.origin_texel[k]))
    };
    let [width, height] = [frame.width, frame.height].map(f64::from);
    [
        side(0, 1.0, -BORDER),
        side(0, -1.0, width + BORDER),
        side(1, 1.0, -BORDER),
        side(1, -1.0, height + BORDER),
    ]
}

fn corner(scene: &Scene, frame: &LightFrame, index: usize) -> Corner {
    let vertex = &scene.vertices[index];
    let position = frame.light_space(vertex.position.map(f64::from));
    let color = scene.colors.get(index).copied().unwrap_or([1.0; 4]);
    let mut corner = [0.0; 12];
    let values = position.into_iter().chain(vertex.normal.map(f64::from));
    let values = values.chain(vertex.uv.map(f64::from)).chain(color.map(f64::from));
    corner.iter_mut().zip(values).for_each(|(slot, value)| *slot = value);
    corner
}

fn add(scene: &mut Scene, frame: &LightFrame, c: &Corner) {
    let position =
        [0, 1, 2].map(|k| (c[0] * frame.right[k] + c[1] * frame.down[k] + c[2] * frame.forward[k]) as f32);
    let [normal, uv] = [&c[3..6], &c[6..8]];
    scene.vertices.push(Vertex {
        position,
        normal: [0, 1, 2].map(|k| normal[k] as f32),
        uv: [0, 1].map(|k| uv[k] as f32),
    });
    if !scene.colors.is_empty() {
        scene.colors.push([8, 9, 10, 11].map(|k| c[k] as f32));
    }
}

/// Which triangles cast no shadow because the whole scene lies on the lit side of their plane.
fn receivers(scene: &Scene, forward: [f64; 3]) -> Vec<bool> {
    let position = |i: u32| scene.vertices[i as usize].position.map(f64::from);
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in scene.triangles.iter().flatten().map(|&i| position(i)) {
        (0..3).for_each(|k| (low[k], high[k]) = (low[k].min(p[k]), high[k].max(p[k])));
    }
    let extent = norm(minus(high, low));
    // Normals face the light, whichever side of the triangle does.
    let plane = |triangle: &[u32; 3]| -> Option<([f64; 3], f64, f64)> {
        let [a, b, c] = triangle.map(position);
        let doubled = cross(minus(b, a), minus(c, a));
        let area = norm(doubled);
        let normal = normalize(doubled);
        let towards = -dot(normal, forward);
        let usable = normal.iter().all(|c| c.is_finite()) && towards != 0.0;
        let normal = normal.map(|c| c * towards.signum());
        usable.then(|| (normal, dot(normal, a), area))
    };
    let step = extent / NORMAL_STEPS;
    let key = |normal: [f64; 3], offset: f64| {
        let normal = normal.map(|c| (c * NORMAL_STEPS).round() as i64);
        (normal, (offset / step).round() as i64)
    };
    let mut areas: HashMap<_, f64> = HashMap::new();
    for (normal, offset, area) in scene.triangles.iter().filter_map(plane) {
        *areas.entry(key(normal, offset)).or_default() += area;
    }
    let mut largest: Vec<_> = areas.into_iter().collect();
    largest.sort_by(|a, b| f64::total_cmp(&b.1, &a.1).then(a.0.cmp(&b.0)));
    largest.truncate(PLANES);
    let candidates: HashSet<_> = largest.into_iter().map(|(key, _)| key).collect();
    // Triangles of one plane round alike, so that the first one speaks for all that are near to it.
    let mut known: HashMap<_, bool> = HashMap::new();
    let mut lies_below = |triangle: &[u32; 3]| {
        let Some((normal, offset, _)) = plane(triangle) else { return false };
        let key = key(normal, offset);
        if !candidates.contains(&key) {
            return false;
        }
        *known.entry(key).or_insert_with(|| {
            let behind = |&i: &u32| dot(normal, position(i)) - offset < -IN_PLANE * extent;
            !scene.triangles.iter().flatten().any(behind)
        })
    };
    scene.triangles.iter().map(&mut lies_below).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Backend, render_in_frame};
    use scenes::Material;

    /// A unit pyramid over a plane of some size, both in order.
    fn ocean(half: f32) -> Scene {
        let corners = [
            [-half, 0.0, half],
            [half, 0.0, half],
            [half, 0.0, -half],
            [-half, 0.0, -half],
            [-0.5, 0.01, 0.5],
            [0.5, 0.01, 0.5],
            [0.0, 0.01, -0.5],
            [0.0, 1.0, 0.0],
        ];
        let vertex = |position| Vertex { position, normal: [0.0, 1.0, 0.0], uv: [0.0; 2] };
        Scene {
            vertices: corners.map(vertex).into(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 7], [5, 6, 7], [6, 4, 7]],
            triangle_material: vec![0; 5],
            materials: vec![Material::plain("grey", [0.5; 3])],
            ..Scene::default()
        }
    }

    #[test]
    fn a_small_model_over_an_ocean_fills_the_map() {
        let direction = [0.4, -1.0, 0.2];
        let shadowing = |scene: &Scene, frame: &LightFrame| {
            let (stack, _) = render_in_frame(scene, frame, Backend::Cpu).unwrap();
            stack.offsets.windows(2).filter(|pair| pair[1] - pair[0] > 1).count()
        };
        for half in [10.0, 1e5] {
            let scene = ocean(half);
            let all = LightFrame::fit(&scene, direction, 128, 128).unwrap();
            let (cut, frame) = LightFrame::fit_casters(&scene, direction, 128, 128).unwrap();
            let (few, many) = (shadowing(&scene, &all), shadowing(&cut, &frame));
            assert!(few < 200 && many > 3000, "{half}: {few} {many}");
            // The plane is cut at the border and covers the whole map.
            let (stack, _) = render_in_frame(&cut, &frame, Backend::Cpu).unwrap();
            assert_eq!(stack.layer_statistics().covered_texels, 128 * 128);
            assert!(stack.depths.iter().all(|depth| (0.0..=1.0).contains(depth)));
        }
    }

    #[test]
    fn what_has_something_behind_it_casts() {
        let scene = ocean(4.0);
        assert_eq!(receivers(&scene, [0.0, -1.0, 0.0]), [true, true, false, false, false]);
        // From below the plane hides the pyramid.
        assert_eq!(receivers(&scene, [0.0, 1.0, 0.0])[..2], [false, false]);
        let mut only_ground = scene.clone();
        only_ground.triangles.truncate(2);
        only_ground.triangle_material.truncate(2);
        let (cut, frame) = LightFrame::fit_casters(&only_ground, [0.1, -1.0, 0.0], 64, 64).unwrap();
        assert_eq!(cut.triangles.len(), 2);
        assert_eq!(frame, LightFrame::fit(&only_ground, [0.1, -1.0, 0.0], 64, 64).unwrap());
    }
}
