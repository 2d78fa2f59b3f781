//! What triangles are asked: whether anything lies between two points, and what lies near one.

use super::edge_test::Sheared;
use super::tree::{Triangles, Visit};
use scenes::vector::{cross, dot, minus, norm};

/// A triangle whose plane holds the origin can be met there only, which is the surface on which the origin lies or its
/// neighbour. "Holds" is up to this, relative to the scene's largest coordinate: 64 roundings of double precision, in
/// which origins are computed from vertices.
const ON_PLANE: f64 = 64.0 * f64::EPSILON;

/// Planes are only asked for hits this near, relative to the scene's largest coordinate; farther ones lie within
/// [`ON_PLANE`] for rays that are parallel to the plane up to 1e-8.
const NEAR: f64 = 1e-6;

/// What lies this near to the light's plane, relative to the scene's largest coordinate, lies in it and does not occlude: 16
/// roundings of single precision, in which a ceiling around a lamp is written down.
const IN_LIGHT: f64 = 1e-6;

/// Planes are only asked for hits in this last part of a segment: a triangle in the light's plane is met elsewhere by rays
/// alone that run within a thousandth of it.
const LAST_PART: f64 = 1e-3;

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

/// A point on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Which triangle.
    pub triangle: u32,
    /// Where, world space.
    pub position: [f64; 3],
}

/// The triangle that occluded a segment, of one tree.
#[derive(Clone, Copy, Debug, Default)]
pub struct LastOccluder(Option<usize>);

impl Triangles {
    /// Whether any triangle lies strictly between both ends.
    ///
    /// A surface does not occlude itself: `from` is left out, and so are triangles in whose plane the origin lies up to
    /// rounding, the back of a sheet among them. Nor does what lies in the plane of a local light, a ceiling around it.
    /// Triangles occlude from both sides, where their alpha mask has a surface.
    #[inline]
    pub fn occludes(&self, segment: &Segment) -> bool {
        self.any(segment, Sheared::meets)
    }

    /// [`Triangles::occludes`], asking first what occluded the last segment: neighbours in a light are often hidden behind
    /// one triangle.
    #[inline]
    pub fn occludes_again(&self, segment: &Segment, last: &mut LastOccluder) -> bool {
        let query = Query::new(self, segment);
        if last.0.is_some_and(|leaf| query.is_hit(self, leaf, &Sheared::meets)) {
            return true;
        }
        self.visit(segment, |leaf| {
            let hit = query.is_hit(self, leaf, &Sheared::meets);
            if hit {
                last.0 = Some(leaf);
            }
            hit
        })
    }

    /// [`Triangles::occludes`] without the tree: every triangle is asked.
    pub fn occludes_brute_force(&self, segment: &Segment) -> bool {
        let query = Query::new(self, segment);
        (0..self.len()).any(|leaf| query.is_hit(self, leaf, &Sheared::meets))
    }

    /// The first surface on the way from `origin` along `direction`: the fraction of the direction in \[0, 1\], or beyond for
    /// `endless` ones, and the triangle. Of equally near ones the first triangle, whatever the tree's order.
    pub fn first(&self, origin: [f64; 3], direction: [f64; 3], endless: bool) -> Option<(f64, u32)> {
        let segment = Segment { origin, direction, endless, from: None };
        let sheared = Sheared::new(origin, direction);
        let end = if endless { f64::INFINITY } else { 1.0 };
        let mut nearest: Option<(f64, u32)> = None;
        self.visit_nearer(&segment, |leaf| {
            let met = sheared.meets(self.corners_of(leaf)).filter(|at| (0.0..=end).contains(at));
            let Some(at) = met.filter(|_| self.is_solid_at(leaf, &sheared)) else { return Visit::Continue };
            let candidate = (at, self.triangle_of(leaf));
            if nearest.is_none_or(|best| candidate < best) {
                nearest = Some(candidate);
            }
            Visit::Until(at)
        });
        nearest
    }

    /// The surface that lies nearest to a point along `direction`, a unit vector, not farther than `reach` on either
    /// side. Receivers that come from a shadow map know their depth to its precision only; this tells the triangle, and
    /// where on it they are.
    pub fn surface_near(&self, point: [f64; 3], direction: [f64; 3], reach: f64) -> Option<Surface> {
        let origin = [0, 1, 2].map(|k| point[k] - reach * direction[k]);
        let through = direction.map(|c| 2.0 * reach * c);
        let segment = Segment { origin, direction: through, endless: false, from: None };
        let sheared = Sheared::new(origin, through);
        let mut nearest: Option<(f64, u32)> = None;
        self.visit(&segment, |leaf| {
            let met = sheared.meets(self.corners_of(leaf)).filter(|at| (0.0..=1.0).contains(at));
            if let Some(at) = met.filter(|_| self.is_solid_at(leaf, &sheared)) {
                let candidate = (at, self.triangle_of(leaf));
                // Of equally near ones the first triangle, whatever the tree's order.
                let rank = |(at, triangle): (f64, u32)| ((at - 0.5).abs(), triangle);
                if nearest.is_none_or(|best| rank(candidate) < rank(best)) {
                    nearest = Some(candidate);
                }
            }
            false
        });
        nearest.map(|(at, triangle)| Surface {
            triangle,
            position: [0, 1, 2].map(|k| origin[k] + at * through[k]),
        })
    }

    /// Whether a triangle that a ray meets has a surface there.
    #[inline(always)]
    fn is_solid_at(&self, leaf: usize, ray: &Sheared) -> bool {
        let triangle = self.triangle_of(leaf);
        !self.masks().apply_to(triangle) || self.masks().pass(triangle, ray.edges(self.corners_of(leaf)).0)
    }

    #[inline(always)]
    pub(super) fn any(
        &self,
        segment: &Segment,
        meets: impl Fn(&Sheared, &[[f32; 3]; 3]) -> Option<f64>,
    ) -> bool {
        let query = Query::new(self, segment);
        self.visit(segment, |leaf| query.is_hit(self, leaf, &meets))
    }
}

/// What every triangle is asked.
struct Query {
    sheared: Sheared,
    origin: [f64; 3],
    direction: [f64; 3],
    near: f64,
    /// From where on planes of triangles are asked whether they hold the end.
    last: f64,
    end: f64,
    reach: f64,
    from: u32,
}

impl Query {
    #[inline(always)]
    fn new(scene: &Triangles, segment: &Segment) -> Self {
        let Segment { origin, direction, endless, from } = *segment;
        let largest = |v: &[f64; 3], least: f64| v.iter().fold(least, |m, c| m.max(c.abs()));
        let reach = largest(&origin, scene.largest_coordinate());
        Self {
            sheared: Sheared::new(origin, direction),
            origin,
            direction,
            near: NEAR * reach / largest(&direction, 0.0),
            last: if endless { f64::INFINITY } else { 1.0 - LAST_PART },
            end: if endless { f64::INFINITY } else { 1.0 },
            reach,
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
        let corners = scene.corners_of(leaf);
        meets(&self.sheared, corners).is_some_and(|at| {
            at > 0.0
                && at < self.end
                && (at > self.near || !self.is_on_plane(corners, self.origin, ON_PLANE))
                && (at < self.last || !self.is_on_plane(corners, self.target(), IN_LIGHT))
                && scene.triangle_of(leaf) != self.from
                && scene.is_solid_at(leaf, &self.sheared)
        })
    }

    fn target(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| self.origin[k] + self.direction[k])
    }

    #[cold]
    fn is_on_plane(&self, corners: &[[f32; 3]; 3], point: [f64; 3], within: f64) -> bool {
        let [a, b, c] = corners.map(|corner| minus(corner.map(f64::from), point));
        let normal = cross(minus(b, a), minus(c, a));
        dot(normal, a).abs() <= within * self.reach * norm(normal)
    }
}
