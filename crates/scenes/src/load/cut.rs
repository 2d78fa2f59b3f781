//! Cutting triangles where the alpha test of a material would otherwise need more than one mask: where vertices' alpha moves
//! the threshold, and where a texture that is clamped ends.
//!
//! Masks repeat and have one threshold. So what lies beside a clamped texture gets the coordinates of its last texel, and
//! what has another threshold a material of its own. Triangles that share an edge are cut at the same points of it.

use std::collections::HashMap;

use crate::Wrap;
use crate::arrays::Mesh;
use crate::scene::AlphaTexture;

/// Most different thresholds of one mesh; with more levels of alpha in a texture than that, vertices' alpha is rounded to
/// one of as many steps.
const MAX_BANDS: usize = 16;

/// Position, normal, texture coordinates and colour of a corner.
type Corner = [f64; 12];

/// Where in a [`Corner`] texture coordinates begin, and where alpha lies.
const UV: usize = 6;
const ALPHA: usize = 11;

/// How triangles of a material are to be cut.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cutting {
    /// Size of a clamped texture along u and v.
    clamped: [Option<u32>; 2],
    /// Vertices' alpha from which one more level of the texture's alpha passes, ascending.
    thresholds: Vec<f64>,
}

/// What [`Cutting::apply`] makes too many of.
#[derive(Debug)]
pub(crate) struct TooManyPieces(pub u64);

impl Cutting {
    /// For the test of a texture's alpha times `factor` times vertices' alpha against `cutoff`.
    pub(crate) fn new(texels: Option<&AlphaTexture>, wrap: [Wrap; 2], factor: f64, cutoff: f64) -> Self {
        let mut present = [false; 256];
        match texels {
            Some(texels) => texels.alpha.iter().for_each(|&alpha| present[usize::from(alpha)] = true),
            None => present[255] = true,
        }
        let levels = (1..256).rev().filter(|&level| present[level]);
        let thresholds = levels.map(|level| cutoff * 255.0 / (level as f64 * factor));
        let thresholds = thresholds.filter(|t| t.is_finite() && *t > 0.0).collect();
        let size = |k: usize| texels.map(|texels| [texels.width, texels.height][k]);
        let clamped = [0, 1].map(|k| size(k).filter(|_| wrap[k] == Wrap::Clamp));
        Self { clamped, thresholds }
    }

    /// The parts of a mesh, each with the vertices' alpha that its mask is to be made for.
    pub(crate) fn apply(&self, mesh: Mesh, limit: u64) -> Result<Vec<(Mesh, f64)>, TooManyPieces> {
        let alphas = || mesh.colors.iter().map(|color| f64::from(color[3]));
        let least = alphas().fold(1.0_f64, f64::min);
        let most = alphas().fold(if mesh.colors.is_empty() { 1.0 } else { 0.0_f64 }, f64::max);
        let outside = [0, 1]
            .map(|k| self.clamped[k].is_some() && mesh.uvs.iter().any(|uv| !(0.0..=1.0).contains(&uv[k])));
        let mut edges: Vec<f64> =
            self.thresholds.iter().copied().filter(|&t| least < t && t < most).collect();
        if edges.len() >= MAX_BANDS {
            let step = edges.len().div_ceil(MAX_BANDS - 1);
            edges = edges.into_iter().step_by(step).collect();
        }
        if edges.is_empty() && outside == [false; 2] {
            return Ok(vec![(mesh, 0.5 * (least + most))]);
        }
        let ends: Vec<f64> = [least].into_iter().chain(edges.iter().copied()).chain([most]).collect();
        let mut parts: Vec<Part> = ends.windows(2).map(|_| Part::like(&mesh)).collect();
        let mut pieces = 0_u64;
        for triangle in &mesh.triangles {
            let mut cells = vec![(triangle.map(|i| corner(&mesh, i)).to_vec(), Some(*triangle), [1_u8; 2])];
            for k in (0..2).filter(|&k| outside[k]) {
                cells = cells.into_iter().flat_map(|cell| at_borders(cell, k, self.clamped[k])).collect();
            }
            for (polygon, original, cell) in cells {
                let mut rest = (polygon, original);
                for (part, &edge) in parts.iter_mut().zip(edges.iter().chain([&f64::INFINITY])) {
                    let (below, above) = split(rest, ALPHA, edge);
                    pieces += below.0.len().saturating_sub(2) as u64;
                    part.add(&mesh, below, cell);
                    rest = above;
                }
                if pieces > limit {
                    return Err(TooManyPieces(pieces));
                }
            }
        }
        let middle = |pair: &[f64]| 0.5 * (pair[0] + pair[1]);
        let parts = parts.into_iter().zip(ends.windows(2));
        Ok(parts.filter(|(p, _)| !p.mesh.triangles.is_empty()).map(|(p, e)| (p.mesh, middle(e))).collect())
    }
}

/// A convex polygon, and the triangle that it still is where nothing was cut off.
type Polygon = (Vec<Corner>, Option<[u32; 3]>);

/// A part of a mesh under construction.
struct Part {
    mesh: Mesh,
    numbers: HashMap<(u32, [u8; 2]), u32>,
}

impl Part {
    fn like(mesh: &Mesh) -> Self {
        Self { mesh: Mesh { flat: mesh.flat, ..Mesh::default() }, numbers: HashMap::new() }
    }

    fn push(&mut self, source: &Mesh, corner: &Corner) -> u32 {
        let c = corner.map(|c| c as f32);
        self.mesh.positions.push([c[0], c[1], c[2]]);
        if !source.normals.is_empty() {
            self.mesh.normals.push([c[3], c[4], c[5]]);
        }
        if !source.uvs.is_empty() {
            self.mesh.uvs.push([c[6], c[7]]);
        }
        if !source.colors.is_empty() {
            self.mesh.colors.push([c[8], c[9], c[10], c[11]]);
        }
        self.mesh.positions.len() as u32 - 1
    }

    fn add(&mut self, source: &Mesh, (polygon, original): Polygon, cell: [u8; 2]) {
        let mut numbers = Vec::with_capacity(polygon.len());
        for (i, corner) in polygon.iter().enumerate() {
            // Whole triangles share their corners, on which smooth normals depend.
            numbers.push(match original {
                None => self.push(source, corner),
                Some(triangle) => match self.numbers.get(&(triangle[i], cell)) {
                    Some(&known) => known,
                    None => {
                        let number = self.push(source, corner);
                        self.numbers.insert((triangle[i], cell), number);
                        number
                    }
                },
            });
        }
        for i in 2..numbers.len() {
            self.mesh.triangles.push([numbers[0], numbers[i - 1], numbers[i]]);
        }
    }
}

fn corner(mesh: &Mesh, i: u32) -> Corner {
    let i = i as usize;
    let [position, normal] = [Some(&mesh.positions[i]), mesh.normals.get(i)]
        .map(|v| v.copied().unwrap_or_default().map(f64::from));
    let uv = mesh.uvs.get(i).copied().unwrap_or_default().map(f64::from);
    let color = mesh.colors.get(i).copied().unwrap_or([1.0; 4]).map(f64::from);
    let mut corner = [0.0; 12];
    for (slot, value) in corner.iter_mut().zip(position.into_iter().chain(normal).chain(uv).chain(color)) {
        *slot = value;
    }
    corner
}

/// A polygon, the triangle that it is the whole of, and where it lies along u and v.
type Bordered = (Vec<Corner>, Option<[u32; 3]>, [u8; 2]);

/// The parts below 0, within, and beyond 1 along u or v; outside, the coordinate is that of the outermost texel's middle.
fn at_borders((polygon, original, cell): Bordered, k: usize, size: Option<u32>) -> Vec<Bordered> {
    let texel = 0.5 / f64::from(size.unwrap_or(1).max(1));
    let (below, rest) = split((polygon, original), UV + k, 0.0);
    let (within, beyond) = split(rest, UV + k, 1.0);
    let parts = [(below, 0, Some(texel)), (within, 1, None), (beyond, 2, Some(1.0 - texel))];
    let parts = parts.into_iter().filter(|((polygon, _), _, _)| polygon.len() > 2);
    parts
        .map(|((mut polygon, original), place, fixed)| {
            if let Some(fixed) = fixed {
                polygon.iter_mut().for_each(|corner| corner[UV + k] = fixed);
            }
            let mut cell = cell;
            cell[k] = place;
            (polygon, original, cell)
        })
        .collect()
}

/// What of a polygon has a coordinate below `at`, and the rest.
fn split((polygon, original): Polygon, coordinate: usize, at: f64) -> (Polygon, Polygon) {
    let nothing = || (Vec::new(), None);
    if polygon.iter().all(|corner| corner[coordinate] < at) {
        return ((polygon, original), nothing());
    }
    if polygon.iter().all(|corner| corner[coordinate] >= at) {
        return (nothing(), (polygon, original));
    }
    let (mut below, mut above) = (Vec::new(), Vec::new());
    for (i, p) in polygon.iter().enumerate() {
        let q = &polygon[(i + 1) % polygon.len()];
        let is_below = p[coordinate] < at;
        if is_below {
            below.push(*p)
        } else {
            above.push(*p)
        }
        if is_below != (q[coordinate] < at) {
            // From the lower to the higher end, so that both triangles at an edge find the same point.
            let (low, high) = if is_below { (p, q) } else { (q, p) };
            let t = (at - low[coordinate]) / (high[coordinate] - low[coordinate]);
            let mut met: Corner = std::array::from_fn(|k| low[k] + t * (high[k] - low[k]));
            met[coordinate] = at;
            below.push(met);
            above.push(met);
        }
    }
    ((below, None), (above, None))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(mesh: &Mesh) -> f64 {
        let doubled = mesh.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize].map(f64::from));
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        });
        0.5 * doubled.sum::<f64>()
    }

    fn square(alphas: [f32; 4], far: f32) -> Mesh {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        Mesh {
            positions: corners.map(|[x, y]| [x, y, 0.0]).into(),
            uvs: corners.map(|[x, y]| [far * (x - 0.5) + 0.5, far * (y - 0.5) + 0.5]).into(),
            colors: alphas.map(|alpha| [1.0, 1.0, 1.0, alpha]).into(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        }
    }

    #[test]
    fn a_ramp_of_alpha_is_cut_where_the_test_changes() {
        let cutting = Cutting::new(None, [Wrap::Repeat; 2], 0.8, 0.2);
        let parts = cutting.apply(square([0.0, 1.0, 1.0, 0.0], 1.0), 100).unwrap();
        // 0.8 a >= 0.2 from a = 0.25 on.
        let found: Vec<(f64, f64)> = parts.iter().map(|(mesh, alpha)| (area(mesh), *alpha)).collect();
        assert_eq!(found.len(), 2);
        assert!((found[0].0 - 0.25).abs() < 1e-7 && (found[1].0 - 0.75).abs() < 1e-7, "{found:?}");
        assert_eq!([found[0].1, found[1].1], [0.125, 0.625]);
    }

    #[test]
    fn even_alpha_and_what_lies_within_the_texture_is_left_alone() {
        let cutting = Cutting::new(None, [Wrap::Clamp; 2], 1.0, 0.5);
        let parts = cutting.apply(square([0.3; 4], 1.0), 100).unwrap();
        assert_eq!((parts.len(), parts[0].0.positions.len()), (1, 4));
        assert!((parts[0].1 - 0.3).abs() < 1e-7);
    }

    #[test]
    fn beside_a_clamped_texture_its_last_texels_go_on() {
        let texels = AlphaTexture { width: 4, height: 2, alpha: vec![255; 8] };
        let cutting = Cutting::new(Some(&texels), [Wrap::Clamp; 2], 1.0, 0.5);
        let parts = cutting.apply(square([1.0; 4], 3.0), 100).unwrap();
        assert_eq!(parts.len(), 1);
        let mesh = &parts[0].0;
        assert!((area(mesh) - 1.0).abs() < 1e-7);
        for triangle in &mesh.triangles {
            for axis in 0..2 {
                let [uv, p] = [0, 1].map(|what| {
                    triangle.map(|i| {
                        if what == 0 { mesh.uvs[i as usize][axis] } else { mesh.positions[i as usize][axis] }
                    })
                });
                let middle = p.iter().sum::<f32>() / 3.0;
                let texel = 0.5 / [4.0, 2.0][axis];
                if middle < 1.0 / 3.0 {
                    assert_eq!(uv, [texel; 3]);
                } else if middle > 2.0 / 3.0 {
                    assert_eq!(uv, [1.0 - texel; 3]);
                } else {
                    assert!(uv.iter().all(|c| (-1e-6..=1.0 + 1e-6).contains(c)));
                }
            }
        }
    }

    #[test]
    fn pieces_are_bounded() {
        let cutting = Cutting::new(None, [Wrap::Repeat; 2], 1.0, 0.5);
        assert!(cutting.apply(square([0.0, 1.0, 1.0, 0.0], 1.0), 3).is_err());
    }
}
