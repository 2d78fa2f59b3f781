//! Smoke between walls and pipes, all of which cast shadows onto each other (BHS16 Figure 15): 15 translucent, textured planes.

use std::f64::consts::TAU;

use random_stream::Random;

use super::Parts;
use super::mesh::{Place, Point, SceneMesh, add, frame, normalized, scale};
use crate::{AlphaTexture, Camera, Opacity};

/// Planes of the smoke.
const PLANES: usize = 15;
/// Side of the texture of a puff in texels.
const TEXELS: u32 = 64;
/// Puffs of different shape.
const PUFFS: usize = 3;
/// Largest opacity of a plane.
const THICKEST: f64 = 0.55;
/// Where the smoke rises, and the height of its uppermost plane's middle.
const CHIMNEY: Point = [0.3, 0.9, 0.2];
const TOP: f64 = 6.2;

pub(super) fn build(seed: u64) -> Parts {
    let mut random = Random::new(seed);
    let mut scene = SceneMesh::default();
    let ground = scene.material("ground", [0.46, 0.44, 0.40], None);
    let wall = scene.material("wall", [0.60, 0.55, 0.48], None);
    let orange = scene.material("orange pipe", [0.75, 0.36, 0.10], None);
    let blue = scene.material("blue pipe", [0.15, 0.28, 0.62], None);
    let puffs: Vec<u32> = (0..PUFFS)
        .map(|i| {
            let opacity = Opacity::blended(1.0, Some(puff(&mut random).into()));
            scene.translucent(&format!("smoke {i}"), [0.55; 3], opacity)
        })
        .collect();
    scene.ground(ground, 9.0, 12);
    let here = Place::new([0.0; 3], 0.0);
    // Two walls at a right angle, and a low one in front.
    scene.block(wall, &here, [-5.0, 0.0, -4.4], [5.0, 3.6, -4.0]);
    scene.block(wall, &here, [-5.4, 0.0, -4.4], [-5.0, 3.6, 3.0]);
    scene.block(wall, &here, [2.2, 0.0, 3.2], [5.2, 1.1, 3.5]);
    scene.lathe(wall, [CHIMNEY[0], 0.0, CHIMNEY[2]], &[[0.0, 0.55], [0.8, 0.45], [0.9, 0.5]], 24);
    for (i, x) in [-3.6, -2.4, 2.6, 3.8].into_iter().enumerate() {
        let pipe = if i % 2 == 0 { orange } else { blue };
        bent_pipe(&mut scene, pipe, [x, 0.0, -3.3 + 0.4 * i as f64], 2.2 + 0.5 * i as f64);
    }
    // One through the smoke.
    straight_pipe(&mut scene, blue, [-4.9, 2.4, 0.5], [4.4, 2.9, 0.1], 0.14);
    for plane in 0..PLANES {
        let share = (plane as f64 + random.unit()) / PLANES as f64;
        let drift = 0.3 + 1.1 * share;
        let offset = [random.within(-drift, drift), share * (TOP - CHIMNEY[1]), random.within(-drift, drift)];
        let normal =
            normalized([random.within(-0.7, 0.7), random.within(0.2, 1.0), random.within(-0.7, 0.7)]);
        let half = 0.7 + 1.5 * share;
        square(&mut scene, puffs[plane % PUFFS], add(CHIMNEY, offset), normal, half);
    }
    let views = [[0.2, -1.0, 0.15], [0.8, -0.6, 0.35], [0.75, -0.28, 0.55], [-0.25, -0.09, 0.95]];
    (scene, views, Camera::new([7.5, 4.6, 8.6], [-0.2, 2.3, -0.3], 0.75))
}

/// Up, and over to the back wall.
fn bent_pipe(scene: &mut SceneMesh, material: u32, foot: Point, height: f64) {
    const BENDS: usize = 8;
    const RADIUS: f64 = 0.16;
    let bend = 0.6;
    let mut path = vec![(add(foot, [0.0, -0.1, 0.0]), 0.0)];
    for i in 0..=BENDS {
        let angle = 0.25 * TAU * i as f64 / BENDS as f64;
        let offset = [0.0, height - bend + bend * angle.sin(), -bend * (1.0 - angle.cos())];
        path.push((add(foot, offset), angle));
    }
    path.push((add(foot, [0.0, height, -4.2 - foot[2]]), 0.25 * TAU));
    let rings: Vec<_> = path
        .into_iter()
        .map(|(centre, angle)| {
            let up = [0.0, angle.sin(), angle.cos()];
            (centre, [up, [1.0, 0.0, 0.0]], RADIUS)
        })
        .collect();
    scene.tube(material, &rings, 12, false);
}

fn straight_pipe(scene: &mut SceneMesh, material: u32, a: Point, b: Point, radius: f64) {
    let axes = frame(normalized(add(b, scale(a, -1.0))));
    scene.tube(material, &[(a, axes, radius), (b, axes, radius)], 16, false);
}

/// A square with the whole texture on it.
fn square(scene: &mut SceneMesh, material: u32, centre: Point, normal: Point, half: f64) {
    let [u, v] = frame(normal).map(|axis| scale(axis, half));
    let corner = |s: f64, t: f64| add(centre, add(scale(u, s), scale(v, t)));
    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    scene.quad(material, corners, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
}

/// Random blobs that fade towards the border.
fn puff(random: &mut Random) -> AlphaTexture {
    const BLOBS: usize = 24;
    let blobs: Vec<[f64; 4]> = (0..BLOBS)
        .map(|_| {
            let (turn, reach) = (TAU * random.unit(), 0.62 * random.unit().sqrt());
            [reach * turn.cos(), reach * turn.sin(), random.within(0.12, 0.34), random.within(0.3, 1.0)]
        })
        .collect();
    let thickness = |x: f64, y: f64| -> f64 {
        let blob = |&[u, v, size, weight]: &[f64; 4]| {
            let distance = ((x - u).powi(2) + (y - v).powi(2)).sqrt() / size;
            weight * (1.0 - distance).max(0.0)
        };
        let fade = 1.0 - (x * x + y * y).sqrt();
        blobs.iter().map(blob).sum::<f64>() * fade.max(0.0)
    };
    let at = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(TEXELS) - 1.0;
    let texels: Vec<f64> = (0..TEXELS * TEXELS).map(|t| thickness(at(t % TEXELS), at(t / TEXELS))).collect();
    let most = texels.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    // Steps of 1/255, far coarser than what differs between implementations of sine and root.
    let alpha = texels.iter().map(|t| (255.0 * THICKEST * (t / most).sqrt()).round() as u8).collect();
    AlphaTexture { width: TEXELS, height: TEXELS, alpha }
}
