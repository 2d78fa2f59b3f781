//! Collects meshes into the arrays of a [`Scene`]: drops triangles without area, makes missing normals.

use crate::Vertex;
use crate::error::FileFault;
use crate::scene::MAX_COORDINATE;
use crate::vector::{cross, dot};

/// Most triangles of one scene, counted with repetition where a mesh is instanced; also bounds the vertices.
pub(crate) const MAX_TRIANGLES: u64 = 1 << 24;

/// One indexed mesh in world space.
#[derive(Debug, Default)]
pub(crate) struct Mesh {
    pub positions: Vec<[f32; 3]>,
    /// Empty, or one per position; a zero or non-finite normal is replaced by a computed one.
    pub normals: Vec<[f32; 3]>,
    /// Empty, or one per position.
    pub uvs: Vec<[f32; 2]>,
    /// Empty, or one per position.
    pub colors: Vec<[f32; 4]>,
    /// Whether missing normals are those of the triangles, in place of smooth ones.
    pub flat: bool,
    pub triangles: Vec<[u32; 3]>,
}

#[derive(Debug, Default)]
pub(crate) struct SceneArrays {
    pub vertices: Vec<Vertex>,
    pub triangles: Vec<[u32; 3]>,
    pub triangle_material: Vec<u32>,
    pub degenerate_triangles: usize,
    /// Empty, or one per vertex.
    pub colors: Vec<[f32; 4]>,
    /// Of all positions, those of triangles without area too.
    extent: Option<[[f64; 3]; 2]>,
}

impl SceneArrays {
    /// Least and greatest coordinates.
    pub(crate) fn extent(&self) -> Option<[[f64; 3]; 2]> {
        self.extent
    }

    /// How many triangles [`MAX_TRIANGLES`] leaves room for.
    pub(crate) fn triangles_left(&self) -> u64 {
        MAX_TRIANGLES.saturating_sub(self.triangles.len() as u64 + self.degenerate_triangles as u64)
    }

    /// Fails before anything is allocated for `more` triangles that would exceed [`MAX_TRIANGLES`].
    pub(crate) fn reserve_check(&self, more: u64, at: impl FnOnce() -> String) -> Result<(), FileFault> {
        let count = (self.triangles.len() as u64 + self.degenerate_triangles as u64).saturating_add(more);
        if count > MAX_TRIANGLES {
            return Err(FileFault::TooMany { at: at(), what: "triangles", count, limit: MAX_TRIANGLES });
        }
        Ok(())
    }

    /// Appends a mesh whose indices are in range.
    ///
    /// Where normals are missing they are the sum of the normals of the adjacent triangles, weighted by area,
    /// adjacency being by index: exporters that want creases split vertices there. Those of a flat mesh stay zero.
    pub(crate) fn push(&mut self, mesh: &Mesh, material: u32) {
        let base = self.vertices.len() as u32;
        for position in mesh.positions.iter().map(|position| position.map(f64::from)) {
            let [low, high] = self.extent.get_or_insert([position; 2]);
            (0..3).for_each(|k| (low[k], high[k]) = (low[k].min(position[k]), high[k].max(position[k])));
        }
        let mut computed: Option<Vec<[f64; 3]>> = None;
        let first_triangle = self.triangles.len();
        let needs_normals = (mesh.normals.is_empty() && !mesh.flat)
            || mesh.normals.iter().any(|&normal| unit(normal.map(f64::from)).is_none());
        for &[a, b, c] in &mesh.triangles {
            let area = doubled_area(
                mesh.positions[a as usize],
                mesh.positions[b as usize],
                mesh.positions[c as usize],
            );
            if area == [0.0; 3] {
                self.degenerate_triangles += 1;
                continue;
            }
            self.triangles.push([base + a, base + b, base + c]);
            if needs_normals {
                let sums = computed.get_or_insert_with(|| vec![[0.0; 3]; mesh.positions.len()]);
                for corner in [a, b, c] {
                    let sum = &mut sums[corner as usize];
                    *sum = [sum[0] + area[0], sum[1] + area[1], sum[2] + area[2]];
                }
            }
        }
        let added = self.triangles.len() - first_triangle;
        if added == 0 {
            return;
        }
        self.triangle_material.resize(self.triangles.len(), material);
        if !mesh.colors.is_empty() {
            self.colors.resize(self.vertices.len(), [1.0; 4]);
            self.colors.extend(&mesh.colors);
        }
        self.vertices.extend(mesh.positions.iter().enumerate().map(|(i, &position)| {
            let given = mesh.normals.get(i).and_then(|normal| unit(normal.map(f64::from)));
            let normal = given.or_else(|| computed.as_ref().and_then(|sums| unit(sums[i])));
            Vertex {
                position,
                normal: normal.unwrap_or(if mesh.flat { [0.0; 3] } else { [0.0, 1.0, 0.0] }),
                uv: mesh.uvs.get(i).copied().unwrap_or_default(),
            }
        }));
        if !self.colors.is_empty() {
            self.colors.resize(self.vertices.len(), [1.0; 4]);
        }
    }
}

/// Cross product of two edges: the normal times twice the area. Exact zero means no area; differences of
/// 32-bit floats and their products hardly round in 64 bits.
pub(crate) fn doubled_area(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> [f64; 3] {
    let edge = |p: [f32; 3]| std::array::from_fn(|i| f64::from(p[i]) - f64::from(a[i]));
    cross(edge(b), edge(c))
}

/// The unit vector along `v`, unless it has no usable length.
pub(crate) fn unit(v: [f64; 3]) -> Option<[f32; 3]> {
    let largest = v.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    if !largest.is_finite() || largest == 0.0 || v.iter().any(|c| c.is_nan()) {
        return None;
    }
    // Scaling first keeps the squares away from underflow and overflow.
    let scaled = v.map(|c| c / largest);
    let length = dot(scaled, scaled).sqrt();
    Some(scaled.map(|c| (c / length) as f32))
}

/// Rejects NaN, infinities and magnitudes beyond [`MAX_COORDINATE`].
pub(crate) fn checked_position(
    position: [f64; 3],
    at: impl FnOnce() -> String,
) -> Result<[f32; 3], FileFault> {
    if position.iter().all(|c| c.abs() <= MAX_COORDINATE) {
        Ok(position.map(|c| c as f32))
    } else {
        Err(FileFault::NotFinite { at: at(), value: position })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degenerate_triangles_are_dropped_and_counted() {
        let mut arrays = SceneArrays::default();
        let mesh = Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [2.0, 0.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 1, 3], [0, 0, 2]],
            ..Mesh::default()
        };
        arrays.push(&mesh, 3);
        assert_eq!((arrays.triangles.len(), arrays.degenerate_triangles), (1, 2));
        assert_eq!(arrays.triangle_material, [3]);
        assert_eq!(arrays.vertices[0].normal, [0.0, 1.0, 0.0]);
    }

    #[test]
    fn tiny_and_huge_triangles_have_area() {
        for scale in [1e-38_f32, 1e-20, 1.0, 1e15] {
            let area = doubled_area([0.0; 3], [scale, 0.0, 0.0], [0.0, scale, 0.0]);
            assert!(area[2] > 0.0, "{scale}");
            assert_eq!(unit(area), Some([0.0, 0.0, 1.0]));
        }
    }

    #[test]
    fn unusable_normals_are_replaced_by_area_weighted_ones() {
        let mut arrays = SceneArrays::default();
        let mesh = Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            normals: vec![[f32::NAN, 0.0, 0.0], [0.0; 3], [3.0, 0.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        arrays.push(&mesh, 0);
        let normals: Vec<_> = arrays.vertices.iter().map(|v| v.normal).collect();
        assert_eq!(normals, [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
    }
}
