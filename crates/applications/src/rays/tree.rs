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
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::ray::Ray;
use obvhs::{BvhBuildParams, traverse};
use std::time::Duration;
use thiserror::Error;

use super::boxes::BoxTest;
#[cfg(target_arch = "x86_64")]
use super::boxes::intersect_avx2;
use super::masks::Masks;
use super::query::Segment;
use scenes::Scene;
use scenes::vector::minus;

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
    /// An alpha mask that is none.
    #[error("alpha mask of material `{material}` {what}")]
    Mask {
        /// The material.
        material: String,
        /// What is wrong with it.
        what: String,
    },
    /// NaN or infinity.
    #[error("triangle {triangle} has an alpha mask and texture coordinates that are not finite")]
    TextureCoordinates {
        /// Which triangle.
        triangle: usize,
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

/// Triangles that occlude.
pub struct Triangles {
    tree: CwBvh,
    /// In the order of the tree's leaves, world space.
    corners: Vec<[[f32; 3]; 3]>,
    masks: Masks,
    boxes: BoxTest,
    centre: [f64; 3],
    /// World units to tree units, a power of two.
    scale: f64,
    /// Largest absolute world coordinate.
    largest: f64,
}

impl Triangles {
    /// The triangles of a scene, with its alpha masks.
    ///
    /// # Errors
    /// [`TriangleError`] as [`Triangles::new`], and for masks without the right number of values and their texture
    /// coordinates where they are not finite.
    pub fn of_scene(scene: &Scene) -> Result<Self, TriangleError> {
        let positions: Vec<[f32; 3]> = scene.vertices.iter().map(|vertex| vertex.position).collect();
        let solid = Self::new(&positions, &scene.triangles)?;
        Ok(Self { masks: Masks::new(scene)?, ..solid })
    }

    /// Builds the tree. All triangles are solid. No triangles are a scene too: nothing occludes.
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
    pub(super) fn padded(positions: &[[f32; 3]], triangles: &[[u32; 3]], padding: f32) -> Self {
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
        let (masks, boxes) = (Masks::default(), BoxTest::fastest());
        Self { tree, corners, masks, boxes, centre, scale, largest }
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// Index of the triangle in a leaf.
    #[inline(always)]
    pub(super) fn triangle_of(&self, leaf: usize) -> u32 {
        self.tree.primitive_indices[leaf]
    }

    /// Its corners, world space.
    #[inline(always)]
    pub(super) fn corners_of(&self, leaf: usize) -> &[[f32; 3]; 3] {
        &self.corners[leaf]
    }

    /// The alpha masks, by triangle.
    #[inline(always)]
    pub(super) fn masks(&self) -> &Masks {
        &self.masks
    }

    /// With another test of boxes.
    #[cfg(test)]
    pub(super) fn testing_boxes(self, boxes: BoxTest) -> Self {
        Self { boxes, ..self }
    }

    /// Largest absolute world coordinate.
    #[inline(always)]
    pub(super) fn largest_coordinate(&self) -> f64 {
        self.largest
    }

    /// Calls `stop` for each leaf whose box the segment may meet, until one says so; whether one did.
    #[inline(always)]
    pub(super) fn visit(&self, segment: &Segment, mut stop: impl FnMut(usize) -> bool) -> bool {
        self.visit_nearer(segment, |leaf| if stop(leaf) { Visit::Stop } else { Visit::Continue })
    }

    /// The same with a `visitor` that may end the segment earlier.
    #[inline(always)]
    pub(super) fn visit_nearer(&self, segment: &Segment, visitor: impl FnMut(usize) -> Visit) -> bool {
        let Some(ray) = self.tree_ray(segment) else { return false };
        match self.boxes {
            BoxTest::Portable => self.traverse(ray, CwBvhNode::intersect_ray, visitor),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: only chosen where the machine has the feature.
            BoxTest::Avx2 => unsafe { self.traverse_avx2(ray, visitor) },
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn traverse_avx2(&self, ray: TreeRay, visitor: impl FnMut(usize) -> Visit) -> bool {
        self.traverse(ray, |node, ray, order| intersect_avx2(node, ray, order), visitor)
    }

    #[inline(always)]
    fn traverse(
        &self,
        TreeRay { mut ray, at, skipped }: TreeRay,
        intersect: impl Fn(&CwBvhNode, &Ray, u32) -> u32,
        mut visitor: impl FnMut(usize) -> Visit,
    ) -> bool {
        let mut state = self.tree.new_traversal(ray.direction);
        let mut node;
        let mut found = false;
        'search: {
            traverse!(self.tree, node, state, intersect(node, &ray, state.oct_inv4), {
                match visitor(state.primitive_id as usize) {
                    Visit::Continue => {}
                    Visit::Until(end) => {
                        ray.tmax = ((end * at - skipped) as f32 * END_ROUNDING).min(ray.tmax)
                    }
                    Visit::Stop => {
                        found = true;
                        break 'search;
                    }
                }
            });
        }
        found
    }

    /// The segment in tree coordinates, begun where it enters the scene; `None` where it passes by.
    #[inline(always)]
    fn tree_ray(&self, segment: &Segment) -> Option<TreeRay> {
        let scaled = |v: [f64; 3]| v.map(|c| c * self.scale);
        let mut origin = scaled(minus(segment.origin, self.centre));
        let mut step = scaled(segment.direction);
        let (mut end, mut at, mut skipped) = (PARAMETER, PARAMETER, 0.0);
        if segment.endless {
            let length = step.iter().fold(0.0f64, |m, c| m.max(c.abs()));
            step = step.map(|c| c / length);
            end = f64::INFINITY;
            at *= length;
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
            skipped = entry * PARAMETER;
            end -= skipped;
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
        let ray = Ray {
            origin: vec3a(x, y, z),
            direction: vec3a(sign[0], sign[1], sign[2]),
            inv_direction: vec3a(slope(0), slope(1), slope(2)),
            tmin: 0.0,
            tmax: end as f32 * END_ROUNDING,
        };
        Some(TreeRay { ray, at, skipped })
    }
}

/// What a visitor wants next.
pub(super) enum Visit {
    Continue,
    /// Nothing beyond this fraction of the segment's direction.
    Until(f64),
    Stop,
}

/// A segment in tree coordinates: a fraction t of its direction is at t `at` - `skipped`.
struct TreeRay {
    ray: Ray,
    at: f64,
    skipped: f64,
}

/// World to tree coordinates.
fn local(position: [f64; 3], centre: [f64; 3], scale: f64) -> Vec3A {
    let [x, y, z] = minus(position, centre).map(|c| (c * scale) as f32);
    vec3a(x, y, z)
}
