//! Solids from which the procedural scenes are put together.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::arrays::{Mesh, SceneArrays};
use crate::fit::scene_of;
use crate::load::alpha::{OPAQUE_FROM, alpha_mask};
use crate::{AlphaMask, Camera, LightView, Material, Opacity, Scene};

pub(super) type Point = [f64; 3];

pub(super) fn add(a: Point, b: Point) -> Point {
    std::array::from_fn(|i| a[i] + b[i])
}

pub(super) fn scale(a: Point, factor: f64) -> Point {
    a.map(|c| c * factor)
}

pub(super) fn normalized(a: Point) -> Point {
    scale(a, 1.0 / crate::vector::dot(a, a).sqrt())
}

/// Two unit vectors perpendicular to the unit vector `axis` and to each other; right-handed in this order.
pub(super) fn frame(axis: Point) -> [Point; 2] {
    let helper = if axis[1].abs() < 0.9 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
    let u = normalized(crate::vector::cross(helper, axis));
    [u, crate::vector::cross(axis, u)]
}

/// A placed, turned set of axes: `turn` radians about the vertical, then moved to `origin`.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub origin: Point,
    sin: f64,
    cos: f64,
}

impl Place {
    pub(super) fn new(origin: Point, turn: f64) -> Self {
        let (sin, cos) = turn.sin_cos();
        Self { origin, sin, cos }
    }

    pub(super) fn at(&self, p: Point) -> Point {
        add(self.origin, [self.cos * p[0] + self.sin * p[2], p[1], self.cos * p[2] - self.sin * p[0]])
    }
}

/// Geometry and materials under construction.
#[derive(Default)]
pub(super) struct SceneMesh {
    arrays: SceneArrays,
    materials: Vec<Material>,
}

/// Rounds to the grid of 2⁻¹⁶ on which procedural coordinates lie.
pub(crate) fn on_grid(p: Point) -> [f32; 3] {
    p.map(|c| ((c * 65536.0).round() / 65536.0) as f32)
}

impl SceneMesh {
    pub(super) fn material(&mut self, name: &str, albedo: [f32; 3], mask: Option<AlphaMask>) -> u32 {
        self.materials.push(Material { mask: mask.map(Arc::new), ..Material::plain(name, albedo) });
        self.materials.len() as u32 - 1
    }

    /// A material that lets light through; where shadows are not translucent it is tested as those of files are.
    pub(super) fn translucent(&mut self, name: &str, albedo: [f32; 3], opacity: Opacity) -> u32 {
        let mask = match opacity.transmission {
            [0.0, 0.0, 0.0] => alpha_mask(opacity.texture.as_deref(), f64::from(opacity.factor), OPAQUE_FROM),
            _ => None,
        };
        let number = self.material(name, albedo, mask);
        self.materials[number as usize].opacity = Some(opacity);
        number
    }

    /// Number of triangles so far.
    pub(super) fn triangles(&self) -> usize {
        self.arrays.triangles.len()
    }

    pub(super) fn into_scene(self, name: &str, views: Vec<LightView>, camera: Camera) -> Scene {
        scene_of(self.arrays, name.into(), self.materials, views, camera)
    }

    /// A flat quad with its own vertices, counter-clockwise.
    pub(super) fn quad(&mut self, material: u32, corners: [Point; 4], uvs: [[f32; 2]; 4]) {
        let mesh = Mesh {
            positions: corners.map(on_grid).into(),
            uvs: uvs.into(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        self.arrays.push(&mesh, material);
    }

    /// A hexahedron from its bottom and top quads, both counter-clockwise seen from above.
    pub(super) fn hexahedron(&mut self, material: u32, bottom: [Point; 4], top: [Point; 4]) {
        let mut side = |corners| self.quad(material, corners, [[0.0; 2]; 4]);
        side([bottom[3], bottom[2], bottom[1], bottom[0]]);
        side(top);
        for i in 0..4 {
            let j = (i + 1) % 4;
            side([bottom[i], bottom[j], top[j], top[i]]);
        }
    }

    /// The box between two corners, in a place.
    pub(super) fn block(&mut self, material: u32, place: &Place, low: Point, high: Point) {
        let ring = |y: f64| {
            [[low[0], y, high[2]], [high[0], y, high[2]], [high[0], y, low[2]], [low[0], y, low[2]]]
                .map(|p| place.at(p))
        };
        self.hexahedron(material, ring(low[1]), ring(high[1]));
    }

    /// A box along the segment from `a` to `b`, `width` across and `height` up the perpendicular that is
    /// nearest to vertical.
    pub(super) fn beam(&mut self, material: u32, a: Point, b: Point, width: f64, height: f64) {
        let axis = normalized(add(b, scale(a, -1.0)));
        let [across, up] = frame(axis);
        let end = |centre: Point| {
            [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]
                .map(|[s, t]| add(centre, add(scale(across, s * width), scale(up, t * height))))
        };
        self.hexahedron(material, end(a), end(b));
    }

    /// A closed tube through `rings` of (centre, unit axis, radius), `sides` around; smooth normals. If
    /// `closed` the last ring is joined to the first, else both ends are capped by fans.
    pub(super) fn tube(
        &mut self,
        material: u32,
        rings: &[(Point, [Point; 2], f64)],
        sides: usize,
        closed: bool,
    ) {
        let mut mesh = Mesh::default();
        for &(centre, [u, v], radius) in rings {
            for side in 0..sides {
                let (sin, cos) = (TAU * side as f64 / sides as f64).sin_cos();
                let offset = add(scale(u, radius * cos), scale(v, radius * sin));
                mesh.positions.push(on_grid(add(centre, offset)));
            }
        }
        let index = |ring: usize, side: usize| (ring % rings.len() * sides + side % sides) as u32;
        let joints = if closed { rings.len() } else { rings.len() - 1 };
        for ring in 0..joints {
            for side in 0..sides {
                let [a, b] = [index(ring, side), index(ring, side + 1)];
                let [d, c] = [index(ring + 1, side), index(ring + 1, side + 1)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        if !closed {
            for (ring, outward) in [(0, false), (rings.len() - 1, true)] {
                let centre = mesh.positions.len() as u32;
                mesh.positions.push(on_grid(rings[ring].0));
                for side in 0..sides {
                    let [a, b] = [index(ring, side), index(ring, side + 1)];
                    mesh.triangles.push(if outward { [centre, a, b] } else { [centre, b, a] });
                }
            }
        }
        self.arrays.push(&mesh, material);
    }

    /// A vertical solid of revolution over (height, radius) pairs in ascending order.
    pub(super) fn lathe(&mut self, material: u32, base: Point, profile: &[[f64; 2]], sides: usize) {
        // Axis upward: u x v must point along +y.
        let axes = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
        let rings: Vec<_> =
            profile.iter().map(|&[height, radius]| (add(base, [0.0, height, 0.0]), axes, radius)).collect();
        self.tube(material, &rings, sides, false);
    }

    /// A horizontal ground around the origin, of tiles so that no triangle is much larger than a house.
    pub(super) fn ground(&mut self, material: u32, half_extent: f64, tiles: usize) {
        let step = 2.0 * half_extent / tiles as f64;
        for row in 0..tiles {
            for column in 0..tiles {
                let (x, z) = (column as f64 * step - half_extent, row as f64 * step - half_extent);
                let corners =
                    [[x, 0.0, z], [x, 0.0, z + step], [x + step, 0.0, z + step], [x + step, 0.0, z]];
                self.quad(material, corners, [[0.0; 2]; 4]);
            }
        }
    }
}
