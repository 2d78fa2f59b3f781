//! Polygons cut by planes (Sutherland and Hodgman, Reentrant Polygon Clipping, 1974).

use scenes::vector::dot;

/// What is kept: where the scalar product of the first three components with the normal is at least the number.
pub(crate) type HalfSpace = ([f64; 3], f64);

/// The part of a convex polygon inside of all half spaces; all components are interpolated. Empty, or at least three
/// corners, some of which may coincide.
///
/// An edge is cut at the same point whichever polygon it belongs to, so that neighbours stay neighbours.
pub(crate) fn clip<const N: usize>(mut polygon: Vec<[f64; N]>, half_spaces: &[HalfSpace]) -> Vec<[f64; N]> {
    for (normal, least) in half_spaces {
        let distance = |c: &[f64; N]| dot([c[0], c[1], c[2]], *normal) - least;
        let distances: Vec<f64> = polygon.iter().map(distance).collect();
        if distances.iter().all(|&d| d >= 0.0) {
            continue;
        }
        let mut clipped = Vec::with_capacity(polygon.len() + 1);
        for i in 0..polygon.len() {
            let j = (i + 1) % polygon.len();
            let (a, b) = (distances[i], distances[j]);
            if a >= 0.0 {
                clipped.push(polygon[i]);
            }
            if (a >= 0.0) != (b >= 0.0) {
                // From the inside out, whichever way the edge runs: neighbours find the same point.
                let (from, to, t) = if a >= 0.0 { (i, j, a / (a - b)) } else { (j, i, b / (b - a)) };
                let (from, to) = (&polygon[from], &polygon[to]);
                clipped.push(std::array::from_fn(|k| from[k] + t * (to[k] - from[k])));
            }
        }
        polygon = clipped;
    }
    if polygon.len() < 3 { Vec::new() } else { polygon }
}
