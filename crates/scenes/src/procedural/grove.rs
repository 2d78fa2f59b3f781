//! Branching trees with alpha-tested leaf cards.

use std::f64::consts::TAU;
use std::ops::Range;

use random_stream::Random;

use super::Parts;
use super::mesh::{Point, SceneMesh, add, frame, normalized, scale};
use crate::vector::cross;
use crate::{AlphaMask, Camera};

/// Trees stand in a jittered grid of this many rows and columns.
const GRID: usize = 4;
const SPACING: f64 = 3.1;
/// Side of the leaf texture in texels.
const LEAF_TEXELS: u32 = 64;

pub(super) fn build(seed: u64) -> Parts {
    planted(seed).0
}

/// The triangles of a tree by its number, row by row.
pub(crate) fn tree(seed: u64, number: usize) -> Range<usize> {
    let (_, ends) = planted(seed);
    ends[number]..ends[number + 1]
}

/// The scene, and where in the list of triangles each tree begins and the last one ends.
fn planted(seed: u64) -> (Parts, Vec<usize>) {
    let mut random = Random::new(seed);
    let mut scene = SceneMesh::default();
    let ground = scene.material("ground", [0.27, 0.24, 0.17], None);
    let bark = scene.material("bark", [0.30, 0.22, 0.15], None);
    let leaf = scene.material("leaf", [0.22, 0.36, 0.12], Some(leaf_mask()));
    scene.ground(ground, 9.0, 12);
    let mut ends = vec![scene.triangles()];
    for row in 0..GRID {
        for column in 0..GRID {
            let at = |i: usize| (i as f64 - (GRID - 1) as f64 / 2.0) * SPACING;
            let jitter = [random.within(-0.7, 0.7), random.within(-0.7, 0.7)];
            // Roots reach below the ground.
            let base = [at(column) + jitter[0], -0.1, at(row) + jitter[1]];
            let trunk = Branch {
                start: base,
                direction: normalized([random.within(-0.1, 0.1), 1.0, random.within(-0.1, 0.1)]),
                length: random.within(2.2, 3.0),
                radius: random.within(0.17, 0.23),
                level: 0,
            };
            trunk.grow(&mut scene, bark, leaf, &mut random);
            ends.push(scene.triangles());
        }
    }
    let views = [[0.2, -1.0, 0.3], [0.8, -0.6, 0.35], [0.7, -0.27, -0.6], [-0.35, -0.09, 0.93]];
    let camera = Camera::new([11.5, 6.0, 12.5], [0.0, 2.6, 0.0], 0.75);
    ((scene, views, camera), ends)
}

struct Branch {
    start: Point,
    direction: Point,
    length: f64,
    radius: f64,
    level: usize,
}

/// Children of a branch by its level; the last level carries leaves instead.
const CHILDREN: [usize; 4] = [7, 6, 4, 0];
const SIDES: [usize; 4] = [10, 6, 4, 3];
const RINGS: [usize; 4] = [8, 6, 4, 3];
const LEAVES: usize = 7;

impl Branch {
    fn grow(&self, scene: &mut SceneMesh, bark: u32, leaf: u32, random: &mut Random) {
        // The path bends a little at each ring: outward at random, and up again.
        let rings = RINGS[self.level];
        let [u, v] = frame(self.direction);
        let mut path = vec![(self.start, self.direction)];
        for _ in 1..rings {
            let (position, direction) = path[path.len() - 1];
            let bend = add(scale(u, random.within(-0.16, 0.16)), scale(v, random.within(-0.16, 0.16)));
            let direction = normalized(add(add(direction, bend), [0.0, 0.06, 0.0]));
            path.push((add(position, scale(direction, self.length / (rings - 1) as f64)), direction));
        }
        let tube: Vec<_> = path
            .iter()
            .enumerate()
            .map(|(i, &(position, direction))| {
                let taper = 1.0 - 0.62 * i as f64 / (rings - 1) as f64;
                // Turning the first frame along keeps the sides from twisting.
                let v = normalized(cross(direction, u));
                (position, [cross(v, direction), v], self.radius * taper)
            })
            .collect();
        scene.tube(bark, &tube, SIDES[self.level], false);
        for child in 0..CHILDREN[self.level] {
            let t = 0.42 + 0.58 * (child as f64 + random.unit()) / CHILDREN[self.level] as f64;
            let (start, along) = on_path(&path, t);
            let turn = TAU * (0.618 * child as f64 + 0.2 * random.unit());
            let lean = random.within(0.75, 1.15);
            let radial = add(scale(u, turn.cos()), scale(v, turn.sin()));
            Branch {
                start,
                direction: normalized(add(scale(along, lean.cos()), scale(radial, lean.sin()))),
                length: self.length * random.within(0.5, 0.68),
                radius: self.radius * (1.0 - 0.62 * t) * 0.62,
                level: self.level + 1,
            }
            .grow(scene, bark, leaf, random);
        }
        if CHILDREN[self.level] == 0 {
            for i in 0..LEAVES {
                let (position, along) = on_path(&path, (i as f64 + 0.9) / LEAVES as f64);
                card(scene, leaf, position, along, random);
            }
        }
    }
}

fn on_path(path: &[(Point, Point)], t: f64) -> (Point, Point) {
    let scaled = t.min(0.999) * (path.len() - 1) as f64;
    let i = scaled as usize;
    let (a, b) = (path[i], path[i + 1]);
    let f = scaled - i as f64;
    (add(scale(a.0, 1.0 - f), scale(b.0, f)), b.1)
}

/// A leaf card that starts at a twig and hangs a little.
fn card(scene: &mut SceneMesh, material: u32, root: Point, along: Point, random: &mut Random) {
    let outward = [random.within(-1.0, 1.0), random.within(-0.7, 0.3), random.within(-1.0, 1.0)];
    let tip = normalized(add(scale(along, 0.6), outward));
    let across = frame(tip)[0];
    let (length, half_width) = (random.within(0.42, 0.62), random.within(0.16, 0.24));
    let corner = |side: f64, t: f64| add(root, add(scale(across, side * half_width), scale(tip, t * length)));
    let corners = [corner(-1.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    scene.quad(material, corners, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
}

/// A sprig of leaflets on a stalk; integer arithmetic on a fine grid, so the same everywhere.
fn leaf_mask() -> AlphaMask {
    let n = i64::from(LEAF_TEXELS);
    let alpha = (0..n * n)
        .map(|texel| {
            let (x, y) = (2 * (texel % n) + 1 - n, 2 * (texel / n) + 1);
            let stalk = x.abs() <= 2 && y < 2 * n - 8;
            // Five pairs of leaflets and one at the tip: ellipses, in half texels.
            let leaflet = |cx: i64, cy: i64, a: i64, b: i64| {
                let (dx, dy) = (x.abs() - cx, y - cy);
                dx * dx * b * b + dy * dy * a * a <= a * a * b * b
            };
            let inside = stalk
                || (0..5).any(|i| leaflet(26 - 2 * i, 16 + 20 * i, 23 - 2 * i, 8))
                || leaflet(0, 2 * n - 14, 9, 12);
            if inside { 255 } else { 0 }
        })
        .collect();
    AlphaMask { width: LEAF_TEXELS, height: LEAF_TEXELS, alpha, cutoff: 128 }
}
