//! Flights of stairs between colonnades, with railings, and a winged knot in flight above them.

use std::f64::consts::TAU;

use random_stream::Random;

use super::Parts;
use super::mesh::{Place, Point, SceneMesh, add, frame, normalized, scale};
use crate::Camera;
use crate::vector::cross;

/// Steps of each of the two flights, rise and tread in metres.
const STEPS: usize = 16;
const RISE: f64 = 0.17;
const TREAD: f64 = 0.36;
const HALF_WIDTH: f64 = 3.2;
const COLUMNS_PER_ROW: usize = 9;

pub(super) fn build(seed: u64) -> Parts {
    let mut random = Random::new(seed);
    let mut scene = SceneMesh::default();
    let ground = scene.material("ground", [0.46, 0.44, 0.40], None);
    let stone = scene.material("stone", [0.62, 0.60, 0.55], None);
    let iron = scene.material("iron", [0.12, 0.12, 0.13], None);
    let knot = scene.material("knot", [0.70, 0.32, 0.16], None);
    scene.ground(ground, 15.0, 12);

    // Both flights climb towards a landing in the middle.
    for side in [-1.0, 1.0] {
        let flight = Place::new([0.0; 3], if side < 0.0 { 0.0 } else { TAU / 2.0 });
        for step in 0..STEPS {
            let z = -1.5 - (STEPS - step) as f64 * TREAD;
            let top = (step + 1) as f64 * RISE;
            // Open slabs, not blocks: light passes between them and several surfaces stack up.
            scene.block(stone, &flight, [-HALF_WIDTH, top - 0.09, z - 0.03], [HALF_WIDTH, top, z + TREAD]);
        }
        railing(&mut scene, iron, &flight);
    }
    let landing = STEPS as f64 * RISE;
    let here = Place::new([0.0; 3], 0.0);
    scene.block(stone, &here, [-HALF_WIDTH, landing - 0.25, -1.5], [HALF_WIDTH, landing, 1.5]);
    for x in [-2.6, 0.0, 2.6] {
        for z in [-1.1, 1.1] {
            column(&mut scene, stone, [x, 0.0, z], landing - 0.25, 0.2);
        }
    }
    for x in [-6.2, -4.4, 4.4, 6.2] {
        for i in 0..COLUMNS_PER_ROW {
            let z = (i as f64 - (COLUMNS_PER_ROW - 1) as f64 / 2.0) * 2.2;
            column(&mut scene, stone, [x, 0.0, z], 5.2, random.within(0.27, 0.31));
        }
        // The architrave over each row.
        scene.block(stone, &here, [x - 0.34, 5.2, -9.6], [x + 0.34, 5.65, 9.6]);
    }
    let centre = [0.3, 6.6, -0.4];
    figure(&mut scene, knot, centre);
    wings(&mut scene, knot, centre, &mut random);

    let views = [[0.25, -1.0, 0.15], [0.8, -0.6, 0.35], [0.55, -0.26, 0.8], [0.06, -0.07, 0.99]];
    (scene, views, Camera::new([13.5, 7.5, 15.5], [0.0, 3.2, 0.0], 0.8))
}

/// A column with base, swelling shaft and capital.
fn column(scene: &mut SceneMesh, material: u32, base: Point, height: f64, radius: f64) {
    let mut profile = vec![[0.0, 1.45], [0.12, 1.45], [0.16, 1.2], [0.26, 1.3], [0.32, 1.0]];
    let rings = 14;
    for i in 1..rings {
        let t = i as f64 / rings as f64;
        profile.push([0.32 + t * (height - 0.72), 1.0 - 0.18 * t * t]);
    }
    profile.extend([
        [height - 0.4, 0.82],
        [height - 0.34, 0.95],
        [height - 0.28, 0.85],
        [height - 0.12, 1.35],
    ]);
    profile.push([height, 1.4]);
    let profile: Vec<_> = profile.into_iter().map(|[h, r]| [h, r * radius]).collect();
    scene.lathe(material, base, &profile, 28);
}

/// Balusters on every step and the landing, with a handrail, on both sides of a flight.
fn railing(scene: &mut SceneMesh, material: u32, flight: &Place) {
    let profile = [
        [0.0, 0.05],
        [0.05, 0.05],
        [0.08, 0.025],
        [0.25, 0.022],
        [0.42, 0.045],
        [0.5, 0.05],
        [0.6, 0.03],
        [0.8, 0.02],
        [0.9, 0.035],
        [0.95, 0.035],
    ];
    for x in [-HALF_WIDTH + 0.12, HALF_WIDTH - 0.12] {
        for step in 0..STEPS {
            let z = -1.5 - (STEPS - step) as f64 * TREAD;
            let top = (step + 1) as f64 * RISE;
            for third in [0.06, 0.18, 0.30] {
                scene.lathe(material, flight.at([x, top, z + third]), &profile, 9);
            }
        }
        let start = flight.at([x, RISE + 0.9, -1.5 - STEPS as f64 * TREAD]);
        let end = flight.at([x, (STEPS + 1) as f64 * RISE + 0.9, -1.5]);
        scene.beam(material, start, end, 0.09, 0.06);
    }
}

/// A (2,3) torus knot tube.
fn figure(scene: &mut SceneMesh, material: u32, centre: Point) {
    let point = |t: f64| {
        let ring = 1.15 + 0.5 * (3.0 * t).cos();
        [ring * (2.0 * t).cos(), 0.62 * (3.0 * t).sin(), ring * (2.0 * t).sin()]
    };
    let rings = 420;
    let rings: Vec<_> = (0..rings)
        .map(|i| {
            let t = TAU * i as f64 / rings as f64;
            let tangent = normalized(add(point(t + 1e-4), scale(point(t - 1e-4), -1.0)));
            // The knot winds around the vertical axis: radially outward gives a frame without a seam.
            let [x, _, z] = point(t);
            let radial = [(2.0 * t).cos(), 0.0, (2.0 * t).sin()];
            debug_assert!(x * radial[0] + z * radial[2] > 0.0);
            let v = normalized(cross(tangent, radial));
            let u = cross(v, tangent);
            (add(centre, point(t)), [u, v], 0.2 + 0.035 * (9.0 * t).cos())
        })
        .collect();
    scene.tube(material, &rings, 32, true);
}

/// Two wings of overlapping feathers: flat tapering tubes in three layers.
fn wings(scene: &mut SceneMesh, material: u32, centre: Point, random: &mut Random) {
    for side in [-1.0, 1.0] {
        for layer in 0..3 {
            for i in 0..14 {
                let along = i as f64 / 13.0;
                let root =
                    add(centre, [side * (1.2 + 1.7 * along), 0.25 + 0.9 * along - 0.1 * layer as f64, -0.2]);
                let length = (1.0 + 1.6 * along) * (1.0 - 0.22 * layer as f64);
                let droop = random.within(0.28, 0.4) + 0.15 * layer as f64;
                let direction = normalized([side * (0.25 + 0.8 * along), -droop, 1.0]);
                feather(scene, material, root, scale(direction, length));
            }
        }
    }
}

fn feather(scene: &mut SceneMesh, material: u32, root: Point, reach: Point) {
    let [u, v] = frame(normalized(reach));
    let rings: Vec<_> = (0..=8)
        .map(|i| {
            let t = i as f64 / 8.0;
            let width = 0.02 + 0.16 * (t * (1.0 - t) * 4.0).powf(0.6) * (1.0 - 0.4 * t);
            let bend = [0.0, -0.12 * t * t, 0.0];
            // Flattened: the second axis is a sixth of the first.
            (add(add(root, scale(reach, t)), bend), [u, scale(v, 1.0 / 6.0)], width)
        })
        .collect();
    scene.tube(material, &rings, 10, false);
}
