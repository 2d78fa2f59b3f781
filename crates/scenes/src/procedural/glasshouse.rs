//! A glass house: panes between bars, some of stained glass, and shelves of glass plates inside, up to 64 surfaces one behind
//! another.

use random_stream::Random;

use super::Parts;
use super::mesh::{Place, Point, SceneMesh};
use crate::{Camera, Opacity};

/// Half the length along x, half the width along z, height of the walls and of the ridge in metres.
const HALF_LENGTH: f64 = 4.0;
const HALF_WIDTH: f64 = 2.4;
const EAVES: f64 = 2.4;
const RIDGE: f64 = 3.8;
/// Panes along a long side.
const BAYS: usize = 8;
/// Width of bars.
const BAR: f64 = 0.09;
/// Glass plates of the highest pile; each has two sides.
const PLATES: usize = 28;

/// What a pane transmits: clear, green as thick glass is, and three of stained glass.
const GLASS: [[f32; 3]; 5] =
    [[0.90, 0.92, 0.91], [0.72, 0.86, 0.78], [0.80, 0.15, 0.10], [0.15, 0.55, 0.20], [0.12, 0.20, 0.75]];

pub(super) fn build(seed: u64) -> Parts {
    let mut random = Random::new(seed);
    let mut scene = SceneMesh::default();
    let ground = scene.material("ground", [0.42, 0.40, 0.34], None);
    let bars = scene.material("bars", [0.75, 0.75, 0.72], None);
    let pots = scene.material("pots", [0.58, 0.30, 0.18], None);
    let glass: Vec<u32> = GLASS
        .iter()
        .enumerate()
        .map(|(i, &transmission)| {
            let opacity = Opacity { transmission, ..Opacity::blended(1.0, None) };
            scene.translucent(&format!("glass {i}"), transmission, opacity)
        })
        .collect();
    scene.ground(ground, 9.0, 12);
    let here = Place::new([0.0; 3], 0.0);
    scene.block(
        pots,
        &here,
        [-HALF_LENGTH - 0.1, 0.0, -HALF_WIDTH - 0.1],
        [HALF_LENGTH + 0.1, 0.25, -HALF_WIDTH + 0.1],
    );
    let step = 2.0 * HALF_LENGTH / BAYS as f64;
    let x = |i: usize| i as f64 * step - HALF_LENGTH;
    let eaves = |i: usize, side: f64| [x(i), EAVES, side * HALF_WIDTH];
    let ridge = |i: usize| [x(i), RIDGE, 0.0];
    for i in 0..=BAYS {
        for side in [-1.0, 1.0] {
            let foot = [x(i), 0.0, side * HALF_WIDTH];
            scene.beam(bars, foot, eaves(i, side), BAR, BAR);
            scene.beam(bars, eaves(i, side), ridge(i), BAR, BAR);
            if i < BAYS {
                scene.beam(bars, eaves(i, side), eaves(i + 1, side), BAR, BAR);
                let kind = random.below(GLASS.len() + 3).saturating_sub(3);
                pane(
                    &mut scene,
                    glass[kind],
                    [foot, [x(i + 1), 0.0, foot[2]], eaves(i + 1, side), eaves(i, side)],
                );
                pane(&mut scene, glass[kind], [eaves(i, side), eaves(i + 1, side), ridge(i + 1), ridge(i)]);
            }
        }
        if i < BAYS {
            scene.beam(bars, ridge(i), ridge(i + 1), BAR, BAR);
        }
    }
    for (end, across) in [(-HALF_LENGTH, -1.0), (HALF_LENGTH, 1.0)] {
        let corner = |z: f64, y: f64| [end, y, z];
        let half = HALF_WIDTH * across;
        pane(
            &mut scene,
            glass[0],
            [corner(half, 0.0), corner(-half, 0.0), corner(-half, EAVES), corner(half, EAVES)],
        );
    }
    // Pots, and piles of plates of growing height.
    for i in 0..5 {
        let base = [1.3 * i as f64 - 3.2, 0.0, -1.2];
        let radius = random.within(0.22, 0.34);
        scene.lathe(
            pots,
            base,
            &[[0.0, 0.7 * radius], [1.6 * radius, radius], [1.7 * radius, 0.9 * radius]],
            20,
        );
        let plates = PLATES >> (4 - i);
        for plate in 0..plates {
            let place = Place::new([base[0], 0.0, 1.1], random.within(-0.3, 0.3));
            let y = 0.05 + 0.06 * plate as f64;
            scene.block(glass[0], &place, [-0.45, y, -0.4], [0.45, y + 0.02, 0.4]);
        }
    }
    let views = [[0.05, -1.0, 0.1], [0.75, -0.62, 0.35], [0.6, -0.27, 0.7], [-0.3, -0.09, 0.94]];
    (scene, views, Camera::new([6.5, 4.4, 7.5], [0.0, 1.3, 0.2], 0.75))
}

/// One sheet without thickness.
fn pane(scene: &mut SceneMesh, material: u32, corners: [Point; 4]) {
    scene.quad(material, corners, [[0.0; 2]; 4]);
}
