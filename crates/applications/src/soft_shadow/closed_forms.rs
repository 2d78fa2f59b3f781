//! The truth against closed forms: convex occluders, projected from the receiver onto the light, and their common area with it.

use super::{AreaTruth, TruthSettings};
use crate::PlacedLight;
use crate::rays::Triangles;
use scenes::{AreaLight, Outline};

type Point = [f64; 2];

/// Half axes of the light, which hangs at this height over the receiver's plane and faces it.
const HALF: [f64; 2] = [0.7, 0.4];
const HEIGHT: f64 = 4.0;

const SETTINGS: TruthSettings = TruthSettings { standard_error: 1e-3, most_rays: 1 << 16, seed: 3 };

/// Rays agree with a closed form up to so many standard errors, which 16 nets know to a fifth.
const DEVIATIONS: f64 = 5.0;

/// In units of the half axes, the projection of an occluder from a receiver at height 0 onto the light.
fn projected(occluder: &[[f64; 3]], receiver: Point) -> Vec<Point> {
    let of = |p: &[f64; 3]| {
        let at = |k: usize, component: usize| {
            (receiver[k] + (p[component] - receiver[k]) * HEIGHT / p[1]) / HALF[k]
        };
        [at(0, 0), at(1, 2)]
    };
    let polygon: Vec<Point> = occluder.iter().map(of).collect();
    // Counter-clockwise from here on.
    if area(&polygon) < 0.0 { polygon.into_iter().rev().collect() } else { polygon }
}

fn area(polygon: &[Point]) -> f64 {
    let next = |i: usize| polygon[(i + 1) % polygon.len()];
    (0..polygon.len()).map(|i| 0.5 * (polygon[i][0] * next(i)[1] - polygon[i][1] * next(i)[0])).sum()
}

/// The part of a polygon inside of a convex one, both counter-clockwise.
fn common(mut polygon: Vec<Point>, convex: &[Point]) -> Vec<Point> {
    for i in 0..convex.len() {
        let (p, q) = (convex[i], convex[(i + 1) % convex.len()]);
        let side = |c: &Point| (q[0] - p[0]) * (c[1] - p[1]) - (q[1] - p[1]) * (c[0] - p[0]);
        let mut kept = Vec::new();
        for j in 0..polygon.len() {
            let (a, b) = (polygon[j], polygon[(j + 1) % polygon.len()]);
            let (s, t) = (side(&a), side(&b));
            if s >= 0.0 {
                kept.push(a);
            }
            if (s >= 0.0) != (t >= 0.0) {
                kept.push([0, 1].map(|k| a[k] + s / (s - t) * (b[k] - a[k])));
            }
        }
        polygon = kept;
    }
    polygon
}

/// Area of a polygon inside of the unit disc, by Green's theorem: triangles to the centre within, sectors outside.
fn area_in_disc(polygon: &[Point]) -> f64 {
    let cross = |a: Point, b: Point| a[0] * b[1] - a[1] * b[0];
    let sector = |a: Point, b: Point| 0.5 * cross(a, b).atan2(a[0] * b[0] + a[1] * b[1]);
    let edge = |a: Point, b: Point| {
        let step = [b[0] - a[0], b[1] - a[1]];
        let along = |t: f64| [a[0] + t * step[0], a[1] + t * step[1]];
        // |a + t step|^2 = 1.
        let (length, half) = (step[0] * step[0] + step[1] * step[1], a[0] * step[0] + a[1] * step[1]);
        let root = half * half - length * (a[0] * a[0] + a[1] * a[1] - 1.0);
        if root <= 0.0 {
            return sector(a, b);
        }
        let [enter, leave] = [-1.0, 1.0].map(|sign: f64| (-half + sign * root.sqrt()) / length);
        if leave <= 0.0 || enter >= 1.0 {
            return sector(a, b);
        }
        let (from, to) = (along(enter.max(0.0)), along(leave.min(1.0)));
        sector(a, from) + 0.5 * cross(from, to) + sector(to, b)
    };
    (0..polygon.len()).map(|i| edge(polygon[i], polygon[(i + 1) % polygon.len()])).sum()
}

/// Fraction of the light that a polygon in its plane covers.
fn covered(outline: Outline, polygon: Vec<Point>) -> f64 {
    match outline {
        Outline::Rectangle => {
            let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            area(&common(polygon, &square)) / 4.0
        }
        Outline::Disc => area_in_disc(&polygon) / std::f64::consts::PI,
    }
}

fn scene(occluders: &[&[[f64; 3]]]) -> Triangles {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for polygon in occluders {
        let first = positions.len() as u32;
        positions.extend(polygon.iter().map(|p| p.map(|c| c as f32)));
        triangles.extend((2..polygon.len() as u32).map(|i| [first, first + i - 1, first + i]));
    }
    Triangles::new(&positions, &triangles).unwrap()
}

/// Rays against a closed form at receivers across the penumbra.
fn agree(occluders: &[&[[f64; 3]]], expected: impl Fn(Outline, Point) -> f64) {
    let truth = AreaTruth::new(SETTINGS).unwrap();
    let scene = scene(occluders);
    let axes = [[HALF[0], 0.0, 0.0], [0.0, 0.0, HALF[1]]];
    let (mut partial, mut shapes) = (0, 0.0f64);
    for i in 0..60 {
        let receiver = [-1.5 + 0.05 * f64::from(i), 0.3 - 0.01 * f64::from(i)];
        let [square, disc] = [Outline::Rectangle, Outline::Disc].map(|outline| {
            let light = AreaLight::local(outline, [0.0, HEIGHT, 0.0], axes).unwrap();
            let light = PlacedLight::new(&light, [[0.0; 3]; 3]);
            let from = [receiver[0], 0.0, receiver[1]];
            let found = truth.occluded_fraction(&scene, &light, from, None, i as u64);
            let expected = expected(outline, receiver);
            assert!(found.standard_error <= SETTINGS.standard_error, "{found:?}");
            let error = (found.fraction - expected).abs();
            assert!(
                error <= DEVIATIONS * found.standard_error,
                "{outline:?} {receiver:?}: {found:?} {expected}"
            );
            partial += usize::from((0.01..0.99).contains(&expected));
            expected
        });
        shapes = shapes.max((square - disc).abs());
    }
    // One shape in place of the other would be seen.
    assert!(partial > 20 && shapes > 20.0 * SETTINGS.standard_error, "{partial} {shapes}");
}

const RECTANGLE: [[f64; 3]; 4] = [[-0.5, 2.0, -0.3], [0.25, 2.0, -0.3], [0.25, 2.0, 0.25], [-0.5, 2.0, 0.25]];
/// Corners of single precision, so that rays see the same polygon; convex and in one plane: y = 1.5 + x / 2.
const TILTED: [[f64; 3]; 5] =
    [[-0.5, 1.25, 0.0], [-0.25, 1.375, -0.25], [0.5, 1.75, -0.25], [0.75, 1.875, 0.125], [0.0, 1.5, 0.375]];

#[test]
fn a_rectangle_over_a_parallel_plane() {
    // As in single precision.
    let rectangle = RECTANGLE.map(|p| p.map(|c| f64::from(c as f32)));
    agree(&[&rectangle], |outline, receiver| covered(outline, projected(&rectangle, receiver)));
    // By hand, the rectangular light: the product of what is covered along both axes.
    let receiver = [0.1, -0.05];
    let along = |k: usize, low: f64, high: f64| {
        let edge = |t: f64| (receiver[k] + (t - receiver[k]) * HEIGHT / 2.0).clamp(-HALF[k], HALF[k]);
        (edge(high) - edge(low)) / (2.0 * HALF[k])
    };
    let product = along(0, -0.5, 0.25) * along(1, -0.3, 0.25);
    let found = covered(Outline::Rectangle, projected(&RECTANGLE, receiver));
    assert!((found - product).abs() < 1e-14 && (0.1..0.9).contains(&product), "{found} {product}");
}

#[test]
fn a_tilted_polygon() {
    agree(&[&TILTED], |outline, receiver| covered(outline, projected(&TILTED, receiver)));
}

/// Two occluders at different heights, which hide more or less of each other as the receiver moves.
#[test]
fn overlapping_occluders() {
    let rectangle = RECTANGLE.map(|p| p.map(|c| f64::from(c as f32)));
    let mut overlap = 0.0f64;
    agree(&[&rectangle, &TILTED], |outline, receiver| {
        let [a, b] = [&rectangle[..], &TILTED[..]].map(|occluder| projected(occluder, receiver));
        let both = covered(outline, common(a.clone(), &b));
        covered(outline, a) + covered(outline, b) - both
    });
    for i in 0..60 {
        let receiver = [-1.5 + 0.05 * f64::from(i), 0.3 - 0.01 * f64::from(i)];
        let (a, b) = (projected(&rectangle, receiver), projected(&TILTED, receiver));
        overlap = overlap.max(covered(Outline::Disc, common(a, &b)));
    }
    assert!(overlap > 0.1, "{overlap}");
}
