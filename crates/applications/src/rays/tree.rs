//! A tree of padded boxes over triangles.
//!
//! The tree works in coordinates that are centred on the scene and scaled by a power of two so that they lie in
//! \[-1, 1\]. Its slab test computes (p - o) / d + q e / d in single precision with four roundings, and origin and
//! direction are rounded too. As a movement of the ray against a box face that is at most
//! 8 x 2^-24 x 2 for an origin within \[-1, 1\]: [`PADDING`].

use glam::{UVec2, Vec3A, vec3a};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::ray::Ray;
use obvhs::{BvhBuildParams, traverse};
use std::time::Duration;
use thiserror::Error;

use super::edge_test::Sheared;
use crate::vector::{cross, difference, dot, norm};

/// By how much boxes grow on each side, in units of half the scene's largest extent.
const PADDING: f32 = 16.0 / 16_777_216.0;

/// The tree skips boxes that end within 1e-4 of the ray's parameter. With a parameter of this size at the end of a
/// segment that is less than the tree's rounding.
const PARAMETER: f64 = 1_048_576.0;

/// Stands in for the reciprocal of a zero component: large, and finite after products with coordinates.
const NO_SLOPE: f32 = 1e30;

/// Rays that begin outside of this cube are begun anew at its border, so that their rounding stays that of the scene.
const AROUND: f64 = 1.001;

/// Four roundings of the parameter's end.
const END_ROUNDING: f32 = 1.0 + 4.0 * f32::EPSILON;

/// A triangle whose plane holds the origin can be met there only, which is the surface on which the origin lies or its
/// neighbour. "Holds" is up to this, relative to the scene's largest coordinate: 64 roundings of double precision, in
/// which origins are computed from vertices.
const ON_PLANE: f64 = 64.0 * f64::EPSILON;

/// Planes are only asked for hits this near, relative to the scene's largest coordinate; farther ones lie within
/// [`ON_PLANE`] for rays that are parallel to the plane up to 1e-8.
const NEAR: f64 = 1e-6;

/// Why triangles make no scene for rays.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum TriangleError {
    /// An index beyond the vertices.
    #[error("triangle {triangle} uses vertex {vertex} of {vertices}")]
    Index {
        /// Which triangle.
        triangle: usize,
        /// Its vertex.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// NaN or infinity.
    #[error("vertex {vertex} at {position:?} is not finite")]
    Position {
        /// Which vertex.
        vertex: usize,
        /// Where.
        position: [f32; 3],
    },
    /// More triangles than 32 bits count.
    #[error("{count} triangles are more than the {limit} that a tree can hold")]
    Count {
        /// How many.
        count: usize,
        /// At most.
        limit: usize,
    },
}

/// From a receiver to a point of the light, or on for ever.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Where it starts, world space.
    pub origin: [f64; 3],
    /// To its end; only its direction counts if it is endless. Not zero.
    pub direction: [f64; 3],
    /// Whether it goes on for ever.
    pub endless: bool,
    /// The triangle on which the receiver lies, which does not shadow itself.
    pub from: Option<u32>,
}

/// Triangles that occlude.
pub struct Triangles {
    tree: CwBvh,
    /// In the order of the tree's leaves, world space.
    corners: Vec<[[f32; 3]; 3]>,
    centre: [f64; 3],
    /// World units to tree units, a power of two.
    scale: f64,
    /// Largest absolute world coordinate.
    largest: f64,
}

impl Triangles {
    /// Builds the tree. No triangles are a scene too: nothing occludes.
    ///
    /// # Errors
    /// [`TriangleError`] for dangling indices, positions that are not finite, and too many triangles.
    pub fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Self, TriangleError> {
        if let Some(vertex) = positions.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
            return Err(TriangleError::Position { vertex, position: positions[vertex] });
        }
        let limit = i32::MAX as usize;
        if triangles.len() > limit {
            return Err(TriangleError::Count { count: triangles.len(), limit });
        }
        let vertices = positions.len();
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices) {
                return Err(TriangleError::Index { triangle, vertex, vertices });
            }
        }
        Ok(Self::padded(positions, triangles, PADDING))
    }

    /// All input is valid.
    fn padded(positions: &[[f32; 3]], triangles: &[[u32; 3]], padding: f32) -> Self {
        let of = |corners: &[u32; 3]| corners.map(|v| positions[v as usize]);
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for position in triangles.iter().flat_map(of) {
            for k in 0..3 {
                low[k] = low[k].min(f64::from(position[k]));
                high[k] = high[k].max(f64::from(position[k]));
            }
        }
        if triangles.is_empty() {
            (low, high) = ([0.0; 3], [0.0; 3]);
        }
        let centre = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
        let extent = (0..3).map(|k| 0.5 * (high[k] - low[k])).fold(0.0, f64::max);
        let scale = if extent > 0.0 { (-extent.log2().ceil()).exp2() } else { 1.0 };
        let boxed = |corners: &[u32; 3]| {
            let points = of(corners).map(|p| local(p.map(f64::from), centre, scale));
            let (low, high) =
                (points[0].min(points[1]).min(points[2]), points[0].max(points[1]).max(points[2]));
            Aabb::new(low - Vec3A::splat(padding), high + Vec3A::splat(padding))
        };
        let boxes: Vec<Aabb> = triangles.iter().map(boxed).collect();
        let tree = if boxes.is_empty() {
            CwBvh::default()
        } else {
            build_cwbvh(&boxes, BvhBuildParams::medium_build(), &mut Duration::default())
        };
        let corners = tree.primitive_indices.iter().map(|&t| of(&triangles[t as usize])).collect();
        let largest = low.iter().chain(&high).fold(0.0f64, |m, c| m.max(c.abs()));
        Self { tree, corners, centre, scale, largest }
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// Whether any triangle lies strictly between both ends.
    ///
    /// A surface does not occlude itself: `from` is left out, and so are triangles in whose plane the origin lies up to
    /// rounding.
    #[inline]
    pub fn occludes(&self, segment: &Segment) -> bool {
        self.any(segment, Sheared::meets)
    }

    /// [`Triangles::occludes`] without the tree: every triangle is asked.
    pub fn occludes_brute_force(&self, segment: &Segment) -> bool {
        let query = Query::new(self, segment);
        (0..self.len()).any(|leaf| query.is_hit(self, leaf, &Sheared::meets))
    }

    #[inline(always)]
    fn any(&self, segment: &Segment, meets: impl Fn(&Sheared, &[[f32; 3]; 3]) -> Option<f64>) -> bool {
        let Some(ray) = self.tree_ray(segment) else { return false };
        let query = Query::new(self, segment);
        let mut state = self.tree.new_traversal(ray.direction);
        let mut node;
        let mut found = false;
        'search: {
            traverse!(self.tree, node, state, node.intersect_ray(&ray, state.oct_inv4), {
                if query.is_hit(self, state.primitive_id as usize, &meets) {
                    found = true;
                    break 'search;
                }
            });
        }
        found
    }

    /// The segment in tree coordinates, begun where it enters the scene; `None` where it passes by.
    #[inline(always)]
    fn tree_ray(&self, segment: &Segment) -> Option<Ray> {
        let scaled = |v: [f64; 3]| v.map(|c| c * self.scale);
        let mut origin = scaled(difference(segment.origin, self.centre));
        let mut step = scaled(segment.direction);
        let mut end = PARAMETER;
        if segment.endless {
            let length = step.iter().fold(0.0f64, |m, c| m.max(c.abs()));
            step = step.map(|c| c / length);
            end = f64::INFINITY;
        }
        if self.is_empty() || origin.iter().chain(&step).any(|c| !c.is_finite()) {
            return None;
        }
        if origin.iter().any(|c| c.abs() > AROUND) {
            let mut entry = 0.0f64;
            for k in (0..3).filter(|&k| origin[k].abs() > AROUND) {
                entry = entry.max((AROUND.copysign(origin[k]) - origin[k]) / step[k]);
            }
            let enters = entry * PARAMETER < end;
            if !enters {
                return None;
            }
            end -= entry * PARAMETER;
            origin = [0, 1, 2].map(|k| origin[k] + entry * step[k]);
            if origin.iter().any(|c| c.abs() > 2.0 * AROUND) {
                return None;
            }
        }
        // Signs are taken where the tree takes them, so that a negative zero is none.
        let sign = step.map(|c| if c < 0.0 { -1.0f32 } else { 1.0 });
        let slope = |k: usize| {
            let inverse = (PARAMETER / step[k]).abs() as f32;
            sign[k] * if inverse < NO_SLOPE { inverse } else { NO_SLOPE }
        };
        let [x, y, z] = origin.map(|c| c as f32);
        Some(Ray {
            origin: vec3a(x, y, z),
            direction: vec3a(sign[0], sign[1], sign[2]),
            inv_direction: vec3a(slope(0), slope(1), slope(2)),
            tmin: 0.0,
            tmax: end as f32 * END_ROUNDING,
        })
    }
}

/// What every triangle is asked.
struct Query {
    sheared: Sheared,
    origin: [f64; 3],
    near: f64,
    end: f64,
    plane: f64,
    from: u32,
}

impl Query {
    #[inline(always)]
    fn new(scene: &Triangles, segment: &Segment) -> Self {
        let Segment { origin, direction, endless, from } = *segment;
        let largest = |v: &[f64; 3], least: f64| v.iter().fold(least, |m, c| m.max(c.abs()));
        let reach = largest(&origin, scene.largest);
        Self {
            sheared: Sheared::new(origin, direction),
            origin,
            near: NEAR * reach / largest(&direction, 0.0),
            end: if endless { f64::INFINITY } else { 1.0 },
            plane: ON_PLANE * reach,
            from: from.unwrap_or(u32::MAX),
        }
    }

    /// Whether the triangle of a leaf counts; comparisons with NaN are false.
    #[inline(always)]
    fn is_hit(
        &self,
        scene: &Triangles,
        leaf: usize,
        meets: &impl Fn(&Sheared, &[[f32; 3]; 3]) -> Option<f64>,
    ) -> bool {
        let corners = &scene.corners[leaf];
        meets(&self.sheared, corners).is_some_and(|at| {
            at > 0.0
                && at < self.end
                && (at > self.near || !self.is_on_plane(corners))
                && scene.tree.primitive_indices[leaf] != self.from
        })
    }

    #[cold]
    fn is_on_plane(&self, corners: &[[f32; 3]; 3]) -> bool {
        let [a, b, c] = corners.map(|corner| difference(corner.map(f64::from), self.origin));
        let normal = cross(difference(b, a), difference(c, a));
        dot(normal, a).abs() <= self.plane * norm(normal)
    }
}

/// World to tree coordinates.
fn local(position: [f64; 3], centre: [f64; 3], scale: f64) -> Vec3A {
    let [x, y, z] = difference(position, centre).map(|c| (c * scale) as f32);
    vec3a(x, y, z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use random_stream::Random;

    /// Vertices and triangles of hills over `n` x `n` squares.
    fn height_field(n: usize) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let mut random = Random::stream(11, n as u64);
        let height =
            |x: f64, z: f64, r: &mut Random| 3.0 * (x * 0.7).sin() * (z * 0.4).cos() + 0.1 * r.unit();
        let at = |i: usize| 20.0 * i as f64 / n as f64 - 3.0;
        let positions = (0..(n + 1) * (n + 1))
            .map(|i| {
                let (x, z) = (at(i % (n + 1)), at(i / (n + 1)));
                [x as f32, height(x, z, &mut random) as f32, z as f32]
            })
            .collect();
        let corner = |x: usize, z: usize| (z * (n + 1) + x) as u32;
        let triangles = (0..n * n)
            .flat_map(|i| {
                let (x, z) = (i % n, i / n);
                let [a, b, c, d] = [corner(x, z), corner(x + 1, z), corner(x, z + 1), corner(x + 1, z + 1)];
                [[a, c, b], [b, c, d]]
            })
            .collect();
        (positions, triangles)
    }

    /// A ray from above the hills through an inner vertex or the middle of an edge; it must hit, whatever the hills.
    fn aimed(n: usize, positions: &[[f32; 3]], random: &mut Random) -> Segment {
        let pick = |r: &mut Random| 1 + (r.unit() * (n - 1) as f64) as usize;
        let (x, z) = (pick(random), pick(random));
        let vertex = |x: usize, z: usize| positions[z * (n + 1) + x].map(f64::from);
        let (first, second) = match (random.unit() * 4.0) as usize {
            0 => (vertex(x, z), vertex(x, z)),
            1 => (vertex(x, z), vertex(x - 1, z)),
            2 => (vertex(x, z), vertex(x, z - 1)),
            _ => (vertex(x, z - 1), vertex(x - 1, z)),
        };
        let target = [0, 1, 2].map(|k| 0.5 * (first[k] + second[k]));
        let spread = |r: &mut Random| 16.0 * r.unit() - 1.0;
        let origin = match (random.unit() * 4.0) as usize {
            0 => [target[0], 8.0, target[2]],
            1 => [spread(random), 8.0, target[2]],
            _ => [spread(random), 5.0 + 5.0 * random.unit(), spread(random)],
        };
        Segment { origin, direction: difference(target, origin), endless: true, from: None }
    }

    fn misses(
        scene: &Triangles,
        rays: &[Segment],
        meets: fn(&Sheared, &[[f32; 3]; 3]) -> Option<f64>,
    ) -> usize {
        rays.iter().filter(|ray| !scene.any(ray, meets)).count()
    }

    /// What one writes first: edges belong to nobody.
    fn strictly_inside(sheared: &Sheared, triangle: &[[f32; 3]; 3]) -> Option<f64> {
        let edges = sheared.edges(triangle).0;
        let inside = edges.iter().all(|&e| e > 0.0) || edges.iter().all(|&e| e < 0.0);
        sheared.meets(triangle).filter(|_| inside)
    }

    #[test]
    fn no_ray_slips_through_vertices_and_edges() {
        let n = 317;
        let (positions, triangles) = height_field(n);
        assert_eq!(triangles.len(), 200_978);
        let mut random = Random::stream(5, 0);
        let rays: Vec<Segment> = (0..60_000).map(|_| aimed(n, &positions, &mut random)).collect();
        let scene = Triangles::new(&positions, &triangles).unwrap();
        assert_eq!(misses(&scene, &rays, Sheared::meets), 0);
        // Both faults let rays through.
        let unpadded = misses(&Triangles::padded(&positions, &triangles, 0.0), &rays, Sheared::meets);
        let strict = misses(&scene, &rays, strictly_inside);
        assert!(unpadded > 0 && strict > 1000, "{unpadded} {strict}");
    }

    /// Segments of all kinds, along axes, ending on vertices, from far outside, from surfaces.
    #[test]
    fn the_tree_answers_as_brute_force() {
        let n = 24;
        let (positions, triangles) = height_field(n);
        let scene = Triangles::new(&positions, &triangles).unwrap();
        let mut random = Random::stream(6, 0);
        let mut hits = 0;
        for i in 0..20_000 {
            let mut ray = aimed(n, &positions, &mut random);
            match i % 8 {
                0 => {}
                1 => ray.endless = false,
                2 => ray.direction = ray.direction.map(|c| c * 1.5),
                3 => ray.direction = [0, 1, 2].map(|_| random.unit() - 0.5),
                4 => ray.direction = [ray.direction[0], 0.0, -0.0],
                5 => ray.origin = [0, 1, 2].map(|k| ray.origin[k] - 40.0 * ray.direction[k]),
                6 => (ray.endless, ray.direction) = (false, ray.direction.map(|c| c * 0.99)),
                _ => {
                    let triangle = (random.unit() * triangles.len() as f64) as usize;
                    let weights = [random.unit(), random.unit(), random.unit()];
                    let total: f64 = weights.iter().sum();
                    let corners = triangles[triangle].map(|v| positions[v as usize].map(f64::from));
                    ray.origin =
                        [0, 1, 2].map(|k| (0..3).map(|c| weights[c] * corners[c][k]).sum::<f64>() / total);
                    ray.direction = [random.unit() - 0.5, random.unit(), random.unit() - 0.5];
                    ray.from = Some(triangle as u32);
                }
            }
            let expected = scene.occludes_brute_force(&ray);
            assert_eq!(scene.occludes(&ray), expected, "{i} {ray:?}");
            hits += usize::from(expected);
        }
        assert!((5_000..15_000).contains(&hits), "{hits}");
    }

    /// A receiver in the plane of a quad sees past the quad's other half.
    #[test]
    fn surfaces_do_not_shadow_themselves() {
        let positions = [[0.1, 0.3, 0.7], [1.1, 0.7, 0.9], [0.2, 1.3, 1.7], [1.2, 1.7, 1.9]];
        let scene = Triangles::new(&positions, &[[0, 1, 2], [2, 1, 3]]).unwrap();
        let corner = |k: usize| positions[k].map(f64::from);
        let mut random = Random::stream(2, 0);
        let mut shadowed = 0;
        for i in 0..2000 {
            // On the diagonal, or near it.
            let (s, t) = (random.unit(), if i % 2 == 0 { 0.0 } else { 1e-12 * random.unit() });
            let weights = [t, (1.0 - t) * s, (1.0 - t) * (1.0 - s)];
            let origin = [0, 1, 2].map(|k| (0..3).map(|c| weights[c] * corner(c)[k]).sum());
            let direction = [0, 1, 2].map(|_| random.unit() - 0.5);
            let ray = Segment { origin, direction, endless: true, from: Some(0) };
            shadowed += usize::from(scene.occludes(&ray));
        }
        assert_eq!(shadowed, 0);
        let down = Segment { origin: [0.6, 1.0, 0.0], direction: [0.0, 0.0, 1.0], endless: true, from: None };
        assert!(scene.occludes(&down) && !scene.occludes(&Segment { endless: false, ..down }));
    }

    #[test]
    fn bad_scenes_are_named_and_empty_ones_occlude_nothing() {
        let error = |p: &[[f32; 3]], t: &[[u32; 3]]| Triangles::new(p, t).err().map(|e| e.to_string());
        assert_eq!(error(&[[0.0; 3]], &[[0, 0, 1]]), Some("triangle 0 uses vertex 1 of 1".to_owned()));
        assert!(error(&[[0.0, f32::NAN, 0.0]], &[]).is_some_and(|e| e.contains("NaN")));
        let ray = Segment { origin: [0.0; 3], direction: [1.0; 3], endless: true, from: None };
        assert!(!Triangles::new(&[], &[]).unwrap().occludes(&ray));
        let point = Triangles::new(&[[1.0; 3]; 3], &[[0, 1, 2]]).unwrap();
        assert!(!point.occludes(&ray) && !point.occludes(&Segment { direction: [0.0; 3], ..ray }));
    }
}
