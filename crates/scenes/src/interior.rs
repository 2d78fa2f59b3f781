//! A camera inside of rooms: from outside, a closed room shows its outer walls.

use rayon::prelude::*;

use crate::Camera;
use crate::arrays::{SceneArrays, doubled_area, unit};
use crate::fit::Bounds;
use crate::vector::{cross, dot, minus};

/// Places on the floors that are looked at.
const PLACES: usize = 48;
/// Share of them that must be enclosed for the scene to be a room.
const ENCLOSED: f64 = 0.3;
/// Directions to all sides, of which so many must meet a wall.
const SIDES: usize = 12;
const WALLS: usize = 9;
/// Smallest cosine between a floor's normal and the vertical.
const UPRIGHT: f64 = 0.9;
/// Height of the eye as a share of the height of the room.
const EYE: f64 = 0.55;
/// Vertical field of view in radians: rooms are seen with wide angles.
const WIDE: f32 = 1.2;
/// Rays meet all triangles: a scene of more is looked at from outside.
const MOST_TRIANGLES: usize = 1 << 18;
/// Triangles looked at by one task.
const CHUNK: usize = 1 << 12;
/// How far a view goes down, as a share of its length.
const DOWN: f64 = 0.12;
/// Distance of the eye from what is behind it, as a share of the view's length.
const BACK: f64 = 0.02;

/// A place in a room with the distances of what is around.
struct Place {
    eye: [f64; 3],
    around: [f64; SIDES],
}

/// A camera in the room that the triangles enclose, looking along its length; `None` where they enclose none, which means:
/// from most places on floors one sees a ceiling above and walls to all sides, and all of them from their front.
pub(crate) fn camera_inside(arrays: &SceneArrays, bounds: &Bounds) -> Option<Camera> {
    // Most scenes have no ceiling, which takes little time to see.
    if arrays.triangles.len() > MOST_TRIANGLES || !may_have_ceilings(arrays, bounds) {
        return None;
    }
    let corners = |t: &[u32; 3]| t.map(|i| arrays.vertices[i as usize].position.map(f64::from));
    let roofed = under_ceilings(arrays, places(arrays, bounds));
    let enough = |count: usize| count as f64 >= ENCLOSED * PLACES as f64;
    if !enough(roofed.len()) {
        return None;
    }
    let places: Vec<Place> = roofed
        .into_par_iter()
        .filter_map(|(floor, height)| {
            let eye = [floor[0], floor[1] + EYE * height, floor[2]];
            // What level rays can meet.
            let level: Vec<[[f64; 3]; 3]> = arrays
                .triangles
                .iter()
                .map(corners)
                .filter(|[a, b, c]| a[1].min(b[1]).min(c[1]) <= eye[1] && eye[1] <= a[1].max(b[1]).max(c[1]))
                .collect();
            let mut around = [0.0; SIDES];
            let mut walls = 0;
            for (side, distance) in around.iter_mut().enumerate() {
                if let Some(hit) = nearest(level.iter().copied(), eye, direction(side)) {
                    walls += usize::from(hit.front);
                    *distance = if hit.front { hit.distance } else { 0.0 };
                }
            }
            (walls >= WALLS).then_some(Place { eye, around })
        })
        .collect();
    if !enough(places.len()) {
        return None;
    }
    let mut best: Option<(f64, [f64; 3], usize)> = None;
    for place in &places {
        for side in 0..SIDES {
            // Its neighbours too, so that the view does not go through a gap.
            let beside = [(side + SIDES - 1) % SIDES, side, (side + 1) % SIDES];
            let length = beside.iter().fold(f64::INFINITY, |least, &s| least.min(place.around[s]));
            if best.is_none_or(|(most, _, _)| length > most) {
                best = Some((length, place.eye, side));
            }
        }
    }
    let (length, eye, side) = best.filter(|(length, _, _)| *length > 0.0)?;
    let ahead = direction(side);
    let eye = [0, 1, 2].map(|k| eye[k] + BACK * length * ahead[k]);
    let target = [0, 1, 2].map(|k| eye[k] + length * (ahead[k] - if k == 1 { DOWN } else { 0.0 }));
    let [eye, target] = [eye, target].map(|point| point.map(|c| c as f32));
    (eye != target).then(|| Camera::new(eye, target, WIDE))
}

/// Whether enough faces down in the upper half to be a ceiling over what faces up in the lower one.
fn may_have_ceilings(arrays: &SceneArrays, bounds: &Bounds) -> bool {
    let [low, high] = bounds.as_array();
    let middle = 0.5 * (low[1] + high[1]);
    let of = |triangles: &[[u32; 3]]| {
        triangles.iter().fold([0.0, 0.0], |[floor, ceiling]: [f64; 2], triangle| {
            let [a, b, c] = triangle.map(|i| arrays.vertices[i as usize].position.map(f64::from));
            let up = (b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2]);
            let [least, most] = [a[1].min(b[1]).min(c[1]), a[1].max(b[1]).max(c[1])];
            match up > 0.0 {
                true if most <= middle => [floor + up, ceiling],
                false if least >= middle => [floor, ceiling - up],
                true | false => [floor, ceiling],
            }
        })
    };
    // Summed in order, so that threads make no difference.
    let chunks: Vec<[f64; 2]> = arrays.triangles.par_chunks(CHUNK).map(of).collect();
    let [floor, ceiling] = chunks.into_iter().fold([0.0, 0.0], |sum, of| [sum[0] + of[0], sum[1] + of[1]]);
    floor > 0.0 && ceiling >= ENCLOSED * floor
}

/// The places above which the first surface is one that faces down, with its height above them.
fn under_ceilings(arrays: &SceneArrays, mut places: Vec<[f64; 3]>) -> Vec<([f64; 3], f64)> {
    places.sort_by(|p, q| f64::total_cmp(&p[0], &q[0]));
    let mut hits: Vec<Option<Hit>> = places.iter().map(|_| None).collect();
    for triangle in &arrays.triangles {
        let corners = triangle.map(|i| arrays.vertices[i as usize].position.map(f64::from));
        let [a, b, c] = corners.map(|corner| corner[0]);
        // Few places lie above or below a triangle.
        let first = places.partition_point(|place| place[0] < a.min(b).min(c));
        let end = places.partition_point(|place| place[0] <= a.max(b).max(c));
        for (place, hit) in places[first..end].iter().zip(&mut hits[first..end]) {
            closer(hit, corners, *place, [0.0, 1.0, 0.0]);
        }
    }
    let found = places.into_iter().zip(hits);
    found.filter_map(|(place, hit)| hit.filter(|hit| hit.front).map(|hit| (place, hit.distance))).collect()
}

fn direction(side: usize) -> [f64; 3] {
    let angle = std::f64::consts::TAU * (side as f64 + 0.5) / SIDES as f64;
    [angle.cos(), 0.0, angle.sin()]
}

/// Points a little above floors, spread evenly over the area that faces up in the lower half of the scene.
fn places(arrays: &SceneArrays, bounds: &Bounds) -> Vec<[f64; 3]> {
    let [low, high] = bounds.as_array();
    let middle = 0.5 * (low[1] + high[1]);
    let lift = 1e-3 * (high[1] - low[1]);
    let mut floors: Vec<(f64, [[f64; 3]; 3])> = Vec::new();
    let mut total = 0.0;
    for triangle in &arrays.triangles {
        let p = triangle.map(|i| arrays.vertices[i as usize].position);
        let area = doubled_area(p[0], p[1], p[2]);
        let upright = unit(area).is_some_and(|normal| f64::from(normal[1]) >= UPRIGHT);
        if upright && p.iter().all(|corner| f64::from(corner[1]) <= middle) {
            total += area[1];
            floors.push((total, p.map(|corner| corner.map(f64::from))));
        }
    }
    if total <= 0.0 {
        return Vec::new();
    }
    let place = |i: usize| {
        let wanted = total * (i as f64 + 0.5) / PLACES as f64;
        let found = floors.partition_point(|&(sum, _)| sum < wanted).min(floors.len() - 1);
        let before = if found == 0 { 0.0 } else { floors[found - 1].0 };
        let (sum, [a, b, c]) = floors[found];
        // Within the triangle along the line from a to the side across from it.
        let share = ((wanted - before) / (sum - before)).clamp(0.05, 0.95);
        [0, 1, 2].map(|k| {
            let across = b[k] + share * (c[k] - b[k]);
            a[k] + (2.0 / 3.0) * (across - a[k]) + if k == 1 { lift } else { 0.0 }
        })
    };
    (0..PLACES).map(place).collect()
}

struct Hit {
    distance: f64,
    front: bool,
}

/// The nearest triangle along a ray.
fn nearest(triangles: impl Iterator<Item = [[f64; 3]; 3]>, from: [f64; 3], along: [f64; 3]) -> Option<Hit> {
    let mut nearest = None;
    triangles.for_each(|corners| closer(&mut nearest, corners, from, along));
    nearest
}

/// Replaces a hit by that of a triangle which a ray meets before (Möller and Trumbore, Fast, Minimum Storage Ray/Triangle
/// Intersection, 1997).
fn closer(nearest: &mut Option<Hit>, [a, b, c]: [[f64; 3]; 3], from: [f64; 3], along: [f64; 3]) {
    let (e1, e2) = (minus(b, a), minus(c, a));
    let p = cross(along, e2);
    let determinant = dot(e1, p);
    if determinant == 0.0 {
        return;
    }
    let s = minus(from, a);
    let u = dot(s, p) / determinant;
    if !(0.0..=1.0).contains(&u) {
        return;
    }
    let q = cross(s, e1);
    let v = dot(along, q) / determinant;
    let distance = dot(e2, q) / determinant;
    let met = v >= 0.0 && u + v <= 1.0 && distance > 0.0;
    if met && nearest.as_ref().is_none_or(|nearest| distance < nearest.distance) {
        *nearest = Some(Hit { distance, front: determinant > 0.0 });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arrays::Mesh;

    /// A box whose faces look inwards or outwards.
    fn room(inwards: bool) -> SceneArrays {
        let corner = |i: usize| [[-4.0, 4.0][i & 1], [0.0, 3.0][i >> 1 & 1], [-2.0, 2.0][i >> 2 & 1]];
        // Outwards.
        let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let mut arrays = SceneArrays::default();
        for mut face in faces {
            if inwards {
                face.reverse();
            }
            let positions = face.map(|i| corner(i).map(|c: f32| c)).into();
            arrays.push(&Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() }, 0);
        }
        arrays
    }

    #[test]
    fn a_room_is_seen_from_inside_along_its_length_and_a_block_from_outside() {
        let arrays = room(true);
        let bounds = Bounds::of(&arrays).unwrap();
        let camera = camera_inside(&arrays, &bounds).unwrap();
        assert!(
            camera.eye[0].abs() < 4.0 && camera.eye[2].abs() < 2.0 && (0.5..2.5).contains(&camera.eye[1])
        );
        let along = [0, 2].map(|k| (camera.target[k] - camera.eye[k]).abs());
        assert!(along[0] > 3.0 * along[1] && along[0] > 3.5, "{camera:?}");
        let block = room(false);
        assert!(camera_inside(&block, &bounds).is_none());
    }

    #[test]
    fn without_a_ceiling_or_walls_there_is_no_room() {
        let mut open = room(true);
        // The ceiling is the fourth face.
        open.triangles.drain(6..8);
        assert!(camera_inside(&open, &Bounds::of(&open).unwrap()).is_none());
        let mut hall = room(true);
        hall.triangles.drain(0..4);
        assert!(camera_inside(&hall, &Bounds::of(&hall).unwrap()).is_none());
    }
}
