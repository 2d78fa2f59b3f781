//! A covered wagon, which drives around the tower of the village.

use std::f64::consts::TAU;

use super::mesh::{Place, SceneMesh, frame};
use crate::{Camera, LightView, Scene};

/// Distance of its middle from the tower's axis in metres: between its wall and the fences.
const RADIUS: f64 = 6.2;

/// The wagon at its first place. Views and camera are those of the scene that it belongs to.
pub(crate) fn cart() -> Scene {
    let mut scene = SceneMesh::default();
    let timber = scene.material("cart", [0.36, 0.22, 0.12], None);
    let cloth = scene.material("cover", [0.74, 0.70, 0.60], None);
    let place = Place::new([RADIUS, 0.0, 0.0], 0.0);
    scene.block(timber, &place, [-0.8, 0.75, -1.6], [0.8, 0.9, 1.6]);
    for x in [-0.8, 0.74] {
        scene.block(timber, &place, [x, 0.9, -1.6], [x + 0.06, 1.5, 1.6]);
    }
    for z in [-1.0, 1.0] {
        for x in [-0.95, 0.95] {
            wheel(&mut scene, timber, &place, [x, 0.6, z]);
        }
    }
    // The shaft, and hoops with the cover between them.
    scene.beam(timber, place.at([0.0, 0.8, 1.6]), place.at([0.0, 0.6, 3.0]), 0.1, 0.1);
    let slats = 9;
    for slat in 0..slats {
        let angle = |i: usize| TAU * 0.5 * i as f64 / slats as f64;
        let rim = |i: usize| [0.85 * angle(i).cos(), 1.5 + 1.1 * angle(i).sin()];
        let ([x0, y0], [x1, y1]) = (rim(slat), rim(slat + 1));
        let lift = |[x, y]: [f64; 2]| [1.04 * x, 1.5 + 1.04 * (y - 1.5)];
        let ([u0, v0], [u1, v1]) = (lift([x0, y0]), lift([x1, y1]));
        let quad = |a: [f64; 2], b: [f64; 2]| {
            [[a[0], a[1], 1.55], [a[0], a[1], -1.55], [b[0], b[1], -1.55], [b[0], b[1], 1.55]]
                .map(|p| place.at(p))
        };
        scene.hexahedron(cloth, quad([x0, y0], [x1, y1]), quad([u0, v0], [u1, v1]));
    }
    let camera = Camera::new([1.0; 3], [0.0; 3], 1.0);
    scene.into_scene("cart", vec![LightView::directional("high", [0.0, -1.0, 0.0])], camera)
}

/// A rim about the x axis with spokes.
fn wheel(scene: &mut SceneMesh, material: u32, place: &Place, centre: [f64; 3]) {
    let at = |angle: f64, radius: f64| {
        place.at([centre[0], centre[1] + radius * angle.sin(), centre[2] + radius * angle.cos()])
    };
    let count = 20;
    let angle = |i: usize| TAU * i as f64 / count as f64;
    let rings: Vec<_> = (0..count)
        .map(|i| (at(angle(i), 0.52), frame([0.0, angle(i).cos(), -angle(i).sin()]), 0.06))
        .collect();
    scene.tube(material, &rings, 6, true);
    for spoke in 0..4 {
        scene.beam(material, at(angle(5 * spoke), 0.5), at(angle(5 * spoke + 10), 0.5), 0.05, 0.05);
    }
}
