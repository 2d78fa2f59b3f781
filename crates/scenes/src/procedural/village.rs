//! Houses with rooms that light can enter, shingled roofs, fences and a hollow tower.

use std::f64::consts::TAU;

use random_stream::Random;

use super::Parts;
use super::mesh::{Place, Point, SceneMesh};
use crate::Camera;

/// Thickness of outer walls, metres.
const WALL: f64 = 0.25;

struct Palette {
    plaster: u32,
    timber: u32,
    shingle: u32,
    stone: u32,
}

pub(super) fn build(seed: u64) -> Parts {
    let mut random = Random::new(seed);
    let mut scene = SceneMesh::default();
    let ground = scene.material("ground", [0.30, 0.36, 0.22], None);
    let palette = Palette {
        plaster: scene.material("plaster", [0.72, 0.68, 0.60], None),
        timber: scene.material("timber", [0.28, 0.19, 0.12], None),
        shingle: scene.material("shingle", [0.42, 0.20, 0.14], None),
        stone: scene.material("stone", [0.45, 0.44, 0.43], None),
    };
    scene.ground(ground, 48.0, 24);
    // Five by five plots; the tower takes the middle one.
    for row in 0..5 {
        for column in 0..5 {
            let plot = [column as f64 * 16.0 - 32.0, 0.0, row as f64 * 16.0 - 32.0];
            if row == 2 && column == 2 {
                tower(&mut scene, &palette, plot);
                continue;
            }
            let origin = [plot[0] + random.within(-1.2, 1.2), 0.0, plot[2] + random.within(-1.2, 1.2)];
            let turn = random.below(4) as f64 * TAU / 4.0 + random.within(-0.25, 0.25);
            house(&mut scene, &palette, &Place::new(origin, turn), &mut random);
            fence(&mut scene, palette.timber, &Place::new(plot, 0.0));
        }
    }
    let views = [[0.3, -1.0, 0.2], [0.8, -0.6, 0.35], [0.86, -0.25, 0.44], [0.97, -0.085, 0.23]];
    (scene, views, Camera::new([46.0, 26.0, 54.0], [0.0, 3.0, 2.0], 0.75))
}

fn house(scene: &mut SceneMesh, palette: &Palette, place: &Place, random: &mut Random) {
    let storeys = 1 + random.below(2);
    let (half_x, half_z) = (random.within(3.0, 4.0), random.within(2.3, 3.0));
    let storey = 2.7;
    for level in 0..storeys {
        let y = level as f64 * storey;
        for (turn, half_length, half_depth, door) in [
            (0.0, half_x, half_z, level == 0),
            (TAU / 2.0, half_x, half_z, false),
            (TAU / 4.0, half_z - WALL, half_x, false),
            (-TAU / 4.0, half_z - WALL, half_x, false),
        ] {
            let wall = turned(place, turn, y);
            wall_with_openings(scene, palette, &wall, half_length, half_depth, storey, door);
        }
        // A floor slab above each storey, and an inner wall with a doorway.
        scene.block(
            palette.timber,
            place,
            [-half_x, y + storey - 0.16, -half_z],
            [half_x, y + storey, half_z],
        );
        for (from, to) in [(-half_z + WALL, -0.5), (0.5, half_z - WALL)] {
            scene.block(palette.plaster, place, [-0.1, y, from], [0.1, y + storey - 0.16, to]);
        }
    }
    let eaves = storeys as f64 * storey;
    roof(scene, palette, place, half_x, half_z, eaves);
    let x = half_x * 0.5;
    for (low, high) in [([x, -0.6], [x + 0.7, -0.5]), ([x, 0.0], [x + 0.7, 0.1])] {
        let top = eaves + half_z + 1.3;
        scene.block(palette.stone, place, [low[0], eaves, low[1]], [high[0], top, high[1]]);
    }
    for x in [x, x + 0.6] {
        scene.block(palette.stone, place, [x, eaves, -0.5], [x + 0.1, eaves + half_z + 1.3, 0.0]);
    }
}

/// The place of a wall that faces `turn` radians away from the house's own +z.
fn turned(place: &Place, turn: f64, y: f64) -> impl Fn(Point) -> Point + use<> {
    let (place, local) = (*place, Place::new([0.0, y, 0.0], turn));
    move |p| place.at(local.at(p))
}

/// A wall from boxes around its openings: windows with frames and crossbars, shutters, and a door.
fn wall_with_openings(
    scene: &mut SceneMesh,
    palette: &Palette,
    at: &impl Fn(Point) -> Point,
    half_length: f64,
    half_depth: f64,
    height: f64,
    door: bool,
) {
    let mut block = |material: u32, low: Point, high: Point| {
        let ring = |y: f64| {
            [[low[0], y, high[2]], [high[0], y, high[2]], [high[0], y, low[2]], [low[0], y, low[2]]].map(at)
        };
        scene.hexahedron(material, ring(low[1]), ring(high[1]));
    };
    let (inner, outer) = (half_depth - WALL, half_depth);
    let top = height - 0.16;
    let openings: &[f64] = if half_length > 2.6 { &[-0.58, 0.0, 0.58] } else { &[-0.4, 0.4] };
    let mut left = -half_length;
    for (i, &opening) in openings.iter().enumerate() {
        let centre = opening * half_length;
        let is_door = door && i == openings.len() / 2;
        let (half, low, high) = if is_door { (0.5, 0.0, 2.1) } else { (0.42, 0.85, 2.0) };
        block(palette.plaster, [left, 0.0, inner], [centre - half, top, outer]);
        if low > 0.0 {
            block(palette.plaster, [centre - half, 0.0, inner], [centre + half, low, outer]);
        }
        block(palette.plaster, [centre - half, high, inner], [centre + half, top, outer]);
        left = centre + half;
        if is_door {
            // The door stands open.
            block(palette.timber, [centre + half, 0.02, outer], [centre + half + 0.06, high, outer + 0.95]);
            continue;
        }
        let middle = 0.5 * (inner + outer);
        for (x0, x1, y0, y1) in [
            (centre - half, centre + half, low, low + 0.06),
            (centre - half, centre + half, high - 0.06, high),
            (centre - half, centre - half + 0.06, low + 0.06, high - 0.06),
            (centre + half - 0.06, centre + half, low + 0.06, high - 0.06),
            (centre - 0.025, centre + 0.025, low + 0.06, high - 0.06),
            (centre - half + 0.06, centre - 0.025, 1.4, 1.45),
            (centre + 0.025, centre + half - 0.06, 1.4, 1.45),
        ] {
            block(palette.timber, [x0, y0, middle - 0.04], [x1, y1, middle + 0.04]);
        }
        for side in [-1.0, 1.0] {
            // Louvred shutters, open beside the window.
            let hinge = centre + side * (half + 0.2);
            for slat in 0..9 {
                let y = low + 0.05 + slat as f64 * 0.12;
                block(palette.timber, [hinge - 0.2, y, outer + 0.02], [hinge + 0.2, y + 0.05, outer + 0.07]);
            }
        }
    }
    block(palette.plaster, [left, 0.0, inner], [half_length, top, outer]);
}

/// Two pitched slabs with overhang under rows of shingles; open gables.
fn roof(scene: &mut SceneMesh, palette: &Palette, place: &Place, half_x: f64, half_z: f64, eaves: f64) {
    let (overhang, rise) = (0.55, half_z * 0.85);
    let reach = half_x + overhang;
    let rows = 11;
    for side in [-1.0, 1.0] {
        // A point `along` the ridge, `down` the slope (0 ridge, 1 wall top) and `lift` above it.
        let on_slope = |along: f64, down: f64, lift: f64| {
            place.at([side * along, eaves + rise * (1.0 - down) + lift, side * half_z * down])
        };
        let last = 1.0 + overhang / half_z;
        let quad = |from: f64, to: f64, lift: [f64; 2], x: [f64; 2]| {
            [(x[0], to, lift[1]), (x[1], to, lift[1]), (x[1], from, lift[0]), (x[0], from, lift[0])]
                .map(|(along, down, lift)| on_slope(along, down, lift))
        };
        let (bottom, top) =
            (quad(0.0, last, [0.0; 2], [-reach, reach]), quad(0.0, last, [0.08; 2], [-reach, reach]));
        scene.hexahedron(palette.timber, bottom, top);
        for row in 0..rows {
            let [from, to] = [row, row + 1].map(|r| last * r as f64 / rows as f64);
            let columns = 14;
            for column in 0..columns {
                let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
                let edge = |c: f64| (2.0 * (c + shift) / (columns as f64 + 0.5) - 1.0) * reach;
                let x = [edge(column as f64 + 0.04), edge(column as f64 + 0.96)];
                let (low, high) = ([0.1, 0.13], [0.13, 0.17]);
                let bottom = quad(from, to + 0.03, low, x);
                scene.hexahedron(palette.shingle, bottom, quad(from, to + 0.03, high, x));
            }
        }
    }
}

/// Pickets and two rails around a plot, with a gap for the gate.
fn fence(scene: &mut SceneMesh, material: u32, plot: &Place) {
    let half = 7.2;
    for turn in 0..4 {
        let side = Place::new(plot.origin, f64::from(turn) * TAU / 4.0);
        for y in [0.3, 0.85] {
            let gate = if turn == 0 { 0.7 } else { 0.0 };
            scene.block(material, &side, [-half, y, half], [-gate, y + 0.08, half + 0.05]);
            scene.block(material, &side, [gate, y, half], [half, y + 0.08, half + 0.05]);
        }
        for picket in 0..40 {
            let x = (f64::from(picket) + 0.5) * 0.36 - half;
            if turn != 0 || x.abs() > 0.7 {
                scene.block(material, &side, [x - 0.05, 0.0, half + 0.05], [x + 0.05, 1.15, half + 0.09]);
            }
        }
    }
}

/// A hollow round tower from blocks with gaps, with floors, battlements and slit windows.
fn tower(scene: &mut SceneMesh, palette: &Palette, origin: Point) {
    let (sectors, courses, course) = (28, 26, 0.62);
    let (inner, outer) = (3.1, 3.9);
    let place = Place::new(origin, 0.0);
    let ring = |sector: f64, radius: f64, y: f64| {
        let (sin, cos) = (TAU * sector / sectors as f64).sin_cos();
        place.at([radius * cos, y, -radius * sin])
    };
    for level in 0..courses {
        let y = level as f64 * course;
        for sector in 0..sectors {
            let slit = sector % 7 == 3 && level % 6 > 1 && level % 6 < 5;
            let door = sector < 2 && level < 4;
            let merlon = level < courses - 2 || sector % 2 == 0;
            if slit || door || !merlon {
                continue;
            }
            let (a, b) = (sector as f64, sector as f64 + 1.0);
            let quad = |y: f64| [ring(a, inner, y), ring(a, outer, y), ring(b, outer, y), ring(b, inner, y)];
            scene.hexahedron(palette.stone, quad(y), quad(y + course));
        }
    }
    for floor in 1..4 {
        let y = f64::from(floor) * 4.2;
        for plank in -5..=5 {
            let x = f64::from(plank) * 0.55;
            let half = (inner * inner - (x.abs() + 0.24).powi(2)).max(0.04).sqrt();
            scene.block(palette.timber, &place, [x - 0.24, y, -half], [x + 0.24, y + 0.12, half]);
        }
    }
}
