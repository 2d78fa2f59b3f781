//! Ray against triangle, after Woop, Benthin and Wald (Watertight Ray/Triangle Intersection, 2013).
//!
//! The ray's largest direction component becomes the third axis; a shear along it turns the ray into that axis. What
//! is left is whether the origin lies in a triangle of the plane, the signs of three 2x2 determinants ad - bc.
//! Rounding is monotone: ad > bc implies fl(ad) >= fl(bc), and the difference of two machine numbers has the right
//! sign. So the computed determinant of the rounded vertices is zero or has the right sign, and as zero counts as
//! inside, every triangle that holds the origin is found. Vertices are sheared one by one, hence alike in all triangles
//! that share them: the sheared mesh has no cracks, and no ray slips through.

use scenes::vector::minus;

/// A ray prepared for many triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheared {
    origin: [f64; 3],
    axes: [usize; 3],
    shear: [f64; 2],
    /// One over the largest component.
    scale: f64,
}

impl Sheared {
    /// `direction` is not zero.
    pub(super) fn new(origin: [f64; 3], direction: [f64; 3]) -> Self {
        let size = direction.map(f64::abs);
        let z = if size[0] > size[1] && size[0] > size[2] {
            0
        } else if size[1] > size[2] {
            1
        } else {
            2
        };
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let shear = [direction[x] / direction[z], direction[y] / direction[z]];
        Self { origin, axes: [x, y, z], shear, scale: 1.0 / direction[z] }
    }

    /// The three determinants, all of one sign or zero where the ray meets the triangle, and the vertices' distances
    /// along the third axis.
    #[inline(always)]
    pub(super) fn edges(&self, triangle: &[[f32; 3]; 3]) -> ([f64; 3], [f64; 3]) {
        let [x, y, z] = self.axes;
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = triangle.map(|vertex| {
            let from_origin = minus(vertex.map(f64::from), self.origin);
            let depth = from_origin[z];
            [from_origin[x] - self.shear[0] * depth, from_origin[y] - self.shear[1] * depth, depth]
        });
        ([cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax], [az, bz, cz])
    }

    /// The fraction of the ray's direction at which it meets the triangle, from behind the origin to beyond the end;
    /// `None` where it passes by or runs within the plane.
    #[inline(always)]
    pub(super) fn meets(&self, triangle: &[[f32; 3]; 3]) -> Option<f64> {
        let ([u, v, w], [az, bz, cz]) = self.edges(triangle);
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 {
            return None;
        }
        Some((u * az + v * bz + w * cz) / determinant * self.scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_fractions_of_the_direction() {
        let triangle = [[-1.0, -1.0, 3.0], [2.0, -1.0, 3.0], [-1.0, 2.0, 3.0]];
        let meets = |origin, direction| Sheared::new(origin, direction).meets(&triangle);
        assert_eq!(meets([0.0, 0.0, 1.0], [0.0, 0.0, 4.0]), Some(0.5));
        assert_eq!(meets([0.0, 0.0, 1.0], [0.0, 0.0, -4.0]), Some(-0.5));
        assert_eq!(meets([1.5, 0.0, 1.0], [0.0, 0.0, 1.0]), None);
        assert_eq!(meets([1.5, 0.0, 1.0], [-0.5, 0.0, 1.0]), Some(2.0));
        // Corners and edges belong to the triangle; its own plane does not.
        assert_eq!(meets([-1.0, 2.0, 1.0], [0.0, 0.0, 1.0]), Some(2.0));
        assert_eq!(meets([0.5, 0.5, 1.0], [0.0, 0.0, 1.0]), Some(2.0));
        assert_eq!(meets([-5.0, 0.0, 3.0], [1.0, 0.0, 0.0]), None);
    }
}
