//! Local lights: triangles cut to what the map can show, depths and mask coordinates as quotients of planes.
//!
//! Coverage follows from corners on the texel grid, as under directional lights. A triangle that reaches behind the near
//! plane, or so far off the map that edge functions would not be exact, is cut first and becomes a fan; both triangles at an
//! edge find the same point on it, so that the fill rule leaves no gap.

use rayon::prelude::*;
use scenes::Scene;

use crate::clip::{HalfSpace, clip};
use crate::stack::assemble::Band;
use crate::stack::fixed_point::{DEPTH_BITS, MaskPlanes, Masks, Plane};
use crate::stack::prepare::{
    GUARD_TEXELS, NO_MASK, PreparedTriangle, PreparedTriangles, Projected, Surface, Tally, mask_coordinates,
    plane_corners, plane_through, set_up,
};
use crate::{LightFrame, RenderError};

/// Triangles set up by one task.
const CHUNK: usize = 1 << 12;

/// A corner in light space, with mask coordinates.
type Corner = [f64; 5];

/// What becomes of some triangles.
#[derive(Default)]
struct Pieces {
    triangles: Vec<PreparedTriangle>,
    surfaces: Vec<Surface>,
    weights: Vec<Plane>,
    mask_planes: Vec<MaskPlanes>,
    tally: Tally,
}

/// [`PreparedTriangles::of_checked`] for a frame with an eye.
pub(super) fn prepare(
    scene: &Scene,
    frame: &LightFrame,
    masks: Masks,
) -> Result<PreparedTriangles, RenderError> {
    let shown = shown(frame);
    let chunks: Vec<Result<Pieces, RenderError>> = (0..scene.triangles.len())
        .into_par_iter()
        .step_by(CHUNK)
        .map(|first| {
            let mut pieces = Pieces::default();
            for triangle in first..scene.triangles.len().min(first + CHUNK) {
                pieces.add(scene, frame, &masks, &shown, triangle)?;
            }
            Ok(pieces)
        })
        .collect();
    let mut all = Pieces::default();
    for pieces in chunks {
        let mut pieces = pieces?;
        let first_mask = all.mask_planes.len() as u32;
        for triangle in pieces.triangles.iter_mut().filter(|triangle| triangle.mask != NO_MASK) {
            triangle.mask += first_mask;
        }
        all.triangles.append(&mut pieces.triangles);
        all.surfaces.append(&mut pieces.surfaces);
        all.weights.append(&mut pieces.weights);
        all.mask_planes.append(&mut pieces.mask_planes);
        all.tally = all.tally.join(pieces.tally);
    }
    let Pieces { triangles, surfaces, weights, mask_planes, tally } = all;
    let (width, height) = (frame.width, frame.height);
    Ok(PreparedTriangles { triangles, surfaces, mask_planes, masks, weights, width, height, tally })
}

/// In front of the near plane, and not farther off the map than edge functions reach.
fn shown(frame: &LightFrame) -> [HalfSpace; 5] {
    // A little less than the guard band, so that rounding does not push corners out of it again.
    let limit = f64::from(GUARD_TEXELS - 1);
    let texels_per_slope = frame.texels_per_unit.map(|texels| texels * frame.near);
    // texels_per_slope x / z + origin lies within [-limit, limit].
    let side = |k: usize, sign: f64| {
        let mut normal = [0.0; 3];
        normal[k] = sign * texels_per_slope[k];
        normal[2] = limit + sign * frame.origin_texel[k];
        (normal, 0.0)
    };
    [([0.0, 0.0, 1.0], frame.near), side(0, 1.0), side(0, -1.0), side(1, 1.0), side(1, -1.0)]
}

impl Pieces {
    fn add(
        &mut self,
        scene: &Scene,
        frame: &LightFrame,
        masks: &Masks,
        shown: &[HalfSpace; 5],
        triangle: usize,
    ) -> Result<(), RenderError> {
        let mask = masks.of_material[scene.triangle_material[triangle] as usize];
        let uv = if mask == NO_MASK { [[0.0; 2]; 3] } else { mask_coordinates(scene, triangle)? };
        let corners: [Corner; 3] = [0, 1, 2].map(|i| {
            let vertex = &scene.vertices[scene.triangles[triangle][i] as usize];
            let [x, y, z] = frame.light_space(vertex.position.map(f64::from));
            [x, y, z, uv[i][0], uv[i][1]]
        });
        let project = |c: &Corner| Projected::new(frame.on_map([c[0], c[1], c[2]]));
        let whole = corners.iter().all(|c| c[2] >= frame.near && !project(c).is_outside());
        let polygon = if whole { corners.to_vec() } else { clip(corners.to_vec(), shown) };
        if polygon.is_empty() {
            self.tally.uncovering += 1;
        }
        for i in 2..polygon.len() {
            let corners = [polygon[0], polygon[i - 1], polygon[i]];
            self.add_piece(&corners, &corners.map(|c| project(&c)), mask, [frame.width, frame.height]);
        }
        Ok(())
    }

    fn add_piece(&mut self, corners: &[Corner; 3], vertices: &[Projected; 3], mask: u32, size: [u32; 2]) {
        let Some((mut triangle, surface)) = set_up(vertices, mask, size, &mut self.tally) else { return };
        let on_map = plane_corners(vertices);
        let reference = [f64::from(triangle.bounds[0]) + 0.5, f64::from(triangle.bounds[1]) + 0.5];
        // Reciprocal distances, the nearest 1.
        let nearest = corners[0][2].min(corners[1][2]).min(corners[2][2]);
        let weights = corners.map(|c| nearest / c[2]);
        let plane = |values: [f64; 3]| {
            let weighted = [0, 1, 2].map(|i| values[i] * weights[i]);
            let (value, step) = plane_through(on_map, weighted, reference);
            Plane::of_quotient(value, step)
        };
        triangle.depth = plane(vertices.map(|v| v.exact[2]));
        if mask != NO_MASK {
            triangle.mask = self.mask_planes.len() as u32;
            let [u, v] = [3, 4].map(|k| plane(corners.map(|c| c[k])));
            self.mask_planes.push(MaskPlanes { u, v, mask });
        }
        self.weights.push(plane([1.0; 3]));
        self.triangles.push(triangle);
        self.surfaces.push(surface);
    }
}

/// Gradients of a band's fragments from its first texel on: of a quotient p / w, (p' - (p / w) w') / w.
pub(super) fn gradients(
    triangles: &[PreparedTriangle],
    weights: &[Plane],
    first_texel: usize,
    width: u32,
    band: &Band,
    out: &mut [[f32; 2]],
) {
    for (texel, &start) in band.starts.iter().enumerate() {
        let end = band.starts.get(texel + 1).map_or(band.keys.len(), |&next| next as usize);
        let texel = (first_texel + texel) as u32;
        let (x, y) = (texel % width, texel / width);
        for i in start as usize..end {
            let (depth, index) = ((band.keys[i] >> 32) as f64, band.keys[i] as u32 as usize);
            let depth = depth / f64::from(1u32 << DEPTH_BITS);
            let (triangle, plane) = (&triangles[index], &weights[index]);
            let [x0, y0, ..] = triangle.bounds.map(u32::from);
            // A sliver's far side may have none.
            let weight = plane.at(x - x0, y - y0).max(1) as f64;
            let along = |k: usize| (triangle.depth.step[k] as f64 - depth * plane.step[k] as f64) / weight;
            out[i] = [along(0) as f32, along(1) as f32];
        }
    }
}
