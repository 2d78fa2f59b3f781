//! A hall for shafts of light: windows in the walls, a roof of slats, a colonnade towards the open side.

use std::f64::consts::TAU;

use random_stream::Random;

use super::Parts;
use super::mesh::{Place, SceneMesh};
use crate::Camera;

/// Half the length along x and half the width along z, and the height of walls in metres.
const HALF_LENGTH: f64 = 12.0;
const HALF_WIDTH: f64 = 6.0;
const HEIGHT: f64 = 7.0;
/// Thickness of walls.
const WALL: f64 = 0.4;

/// Windows of the long wall, and columns of each row.
const WINDOWS: usize = 6;
const COLUMNS: usize = 11;

/// An opening of a wall: middle and half width along it, lower and upper end.
type Opening = [f64; 4];

pub(super) fn build(seed: u64) -> Parts {
    let mut random = Random::new(seed);
    let mut scene = SceneMesh::default();
    let ground = scene.material("ground", [0.40, 0.38, 0.35], None);
    let stone = scene.material("stone", [0.60, 0.57, 0.52], None);
    let timber = scene.material("timber", [0.32, 0.22, 0.14], None);
    scene.ground(ground, 22.0, 16);

    let pitch = 2.0 * HALF_LENGTH / WINDOWS as f64;
    let windows: Vec<Opening> = (0..WINDOWS)
        .map(|i| [(i as f64 + 0.5) * pitch - HALF_LENGTH, random.within(0.5, 0.9), 1.4, 5.6])
        .collect();
    // The long wall with windows lies at +z, the colonnade at -z; a door and a window above it at either end.
    wall(&mut scene, stone, &Place::new([0.0, 0.0, HALF_WIDTH], 0.0), HALF_LENGTH + WALL, &windows);
    for (x, turn) in [(HALF_LENGTH, TAU / 4.0), (-HALF_LENGTH, -TAU / 4.0)] {
        let openings = [[-2.6, 0.7, 2.6, 5.4], [0.2, 0.9, 0.0, 2.4], [2.9, 0.7, 2.6, 5.4]];
        wall(&mut scene, stone, &Place::new([x, 0.0, 0.0], turn), HALF_WIDTH, &openings);
    }
    let here = Place::new([0.0; 3], 0.0);
    for (window, &[middle, half, low, high]) in windows.iter().enumerate() {
        let bars = 3 + window % 3;
        for bar in 1..bars {
            let y = low + (high - low) * bar as f64 / bars as f64;
            let z = HALF_WIDTH + 0.5 * WALL;
            scene.beam(timber, [middle - half, y, z], [middle + half, y, z], 0.06, 0.06);
        }
    }
    for z in [-HALF_WIDTH, -HALF_WIDTH - 3.0] {
        for i in 0..COLUMNS {
            let x = (i as f64 - (COLUMNS - 1) as f64 / 2.0) * 2.2;
            column(&mut scene, stone, [x, 0.0, z], random.within(0.24, 0.30));
        }
        scene.block(
            stone,
            &here,
            [-HALF_LENGTH, HEIGHT - 0.8, z - 0.35],
            [HALF_LENGTH, HEIGHT - 0.2, z + 0.35],
        );
    }
    roof(&mut scene, timber, &mut random);
    for row in 0..7 {
        for side in [-1.0, 1.0] {
            bench(
                &mut scene,
                timber,
                &Place::new([row as f64 * 2.6 - 6.0, 0.0, side * 2.6], random.within(-0.1, 0.1)),
            );
        }
    }

    let views = [[0.2, -1.0, -0.15], [0.35, -0.62, -0.7], [0.3, -0.36, -0.88], [-0.985, -0.08, -0.15]];
    (scene, views, Camera::new([-11.0, 2.2, -3.2], [4.0, 2.9, 2.2], 1.0))
}

/// A wall along its place's x, its inner side at z = 0 and its outer one at z = [`WALL`], around its openings, which ascend.
fn wall(scene: &mut SceneMesh, material: u32, place: &Place, half_length: f64, openings: &[Opening]) {
    let mut block = |from: [f64; 2], to: [f64; 2]| {
        scene.block(material, place, [from[0], from[1], 0.0], [to[0], to[1], WALL]);
    };
    let mut left = -half_length;
    for &[middle, half, low, high] in openings {
        block([left, 0.0], [middle - half, HEIGHT]);
        if low > 0.0 {
            block([middle - half, 0.0], [middle + half, low]);
        }
        block([middle - half, high], [middle + half, HEIGHT]);
        left = middle + half;
    }
    block([left, 0.0], [half_length, HEIGHT]);
}

/// Purlins along the hall, slats across it, of which some are missing.
fn roof(scene: &mut SceneMesh, material: u32, random: &mut Random) {
    let outer = HALF_WIDTH + 3.4;
    for z in [-outer, -HALF_WIDTH, -2.0, 2.0, HALF_WIDTH] {
        let ends = [-HALF_LENGTH - 0.4, HALF_LENGTH + 0.4].map(|x| [x, HEIGHT + 0.1, z]);
        scene.beam(material, ends[0], ends[1], 0.16, 0.2);
    }
    let slats = 56;
    for i in 0..slats {
        let x = (i as f64 + 0.5) / slats as f64 * 2.0 * HALF_LENGTH - HALF_LENGTH;
        let width = random.within(0.2, 0.3);
        if random.unit() < 0.12 {
            continue;
        }
        scene.beam(material, [x, HEIGHT + 0.25, -outer], [x, HEIGHT + 0.25, HALF_WIDTH + WALL], width, 0.06);
    }
}

/// A column with base, shaft and capital up to the architrave.
fn column(scene: &mut SceneMesh, material: u32, base: [f64; 3], radius: f64) {
    let height = HEIGHT - 0.8;
    let mut profile = vec![[0.0, 1.5], [0.15, 1.5], [0.2, 1.25], [0.3, 1.3], [0.36, 1.0]];
    let rings = 22;
    for i in 1..rings {
        let t = i as f64 / rings as f64;
        profile.push([0.36 + t * (height - 0.8), 1.0 - 0.15 * t * t]);
    }
    profile.extend([[height - 0.44, 0.85], [height - 0.36, 1.0], [height - 0.14, 1.4], [height, 1.45]]);
    let profile: Vec<_> = profile.into_iter().map(|[h, r]| [h, r * radius]).collect();
    scene.lathe(material, base, &profile, 40);
}

/// A seat and a back of slats on two sides.
fn bench(scene: &mut SceneMesh, material: u32, place: &Place) {
    for z in [-1.1, 1.02] {
        scene.block(material, place, [-0.25, 0.0, z], [0.25, 0.42, z + 0.08]);
    }
    scene.block(material, place, [-0.27, 0.42, -1.12], [0.27, 0.47, 1.12]);
    for slat in 0..4 {
        let y = 0.55 + 0.12 * f64::from(slat);
        scene.block(material, place, [-0.27, y, -1.12], [-0.24, y + 0.07, 1.12]);
    }
}
