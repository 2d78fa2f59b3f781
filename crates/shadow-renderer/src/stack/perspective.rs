//! Local lights: triangles cut to what the map can show, depths and mask coordinates as quotients of planes.
//!
//! Coverage follows from corners on the texel grid, as under directional lights. A triangle that reaches behind the near
//! plane, or so far off the map that edge functions would not be exact, is cut first and becomes a fan; both triangles at an
//! edge find the same point on it, so that the fill rule leaves no gap.
//!
//! Both backends share all of this: projection, cutting and planes are made here, once, in double precision, and what is left
//! to do for a texel is a division of whole numbers. So their stacks agree bit for bit, as under directional lights. A raster
//! pipeline would cut for itself and has depths that are linear in 1 / Z; it could not agree, and is refused local lights.
//!
//! A depth is rounded once, to 2^-24. Before that it is off by about 2^-48 t r, for a triangle of t texels across whose farthest
//! corner is r times as far as its nearest: below 2^-26 even for t = 8192 and r = 512.

use rayon::prelude::*;
use scenes::Scene;

use crate::clip::{HalfSpace, clip};
use crate::stack::assemble::Band;
use crate::stack::fixed_point::{DEPTH_BITS, MaskPlanes, Masks, Plane};
use crate::stack::prepare::{
    GUARD_TEXELS, NO_MASK, PreparedTriangle, PreparedTriangles, Projected, Surface, Tally, mask_coordinates,
    plane_corners, plane_through, set_up,
};
use crate::stack::veils::{Veil, Veils};
use crate::{LightFrame, RenderError};

/// Triangles set up by one task.
const CHUNK: usize = 1 << 12;

/// A corner in light space, with coordinates of mask and opacity, and alpha.
type Corner = [f64; 6];

/// What becomes of some triangles.
#[derive(Default)]
struct Pieces {
    triangles: Vec<PreparedTriangle>,
    surfaces: Vec<Surface>,
    weights: Vec<Plane>,
    mask_planes: Vec<MaskPlanes>,
    /// Of translucent triangles, by their number.
    veils: Vec<(u32, Veil)>,
    /// The scene's triangle of each; empty without translucent surfaces.
    sources: Vec<u32>,
    tally: Tally,
}

/// [`PreparedTriangles::of_checked`] for a frame with an eye.
pub(super) fn prepare(
    scene: &Scene,
    frame: &LightFrame,
    masks: Masks,
    mut veils: Veils,
) -> Result<PreparedTriangles, RenderError> {
    let shown = shown(frame);
    let chunks: Vec<Result<Pieces, RenderError>> = (0..scene.triangles.len())
        .into_par_iter()
        .step_by(CHUNK)
        .map(|first| {
            let mut pieces = Pieces::default();
            for triangle in first..scene.triangles.len().min(first + CHUNK) {
                pieces.add(scene, frame, (&masks, &veils), &shown, triangle)?;
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
        let before = all.triangles.len() as u32;
        all.triangles.append(&mut pieces.triangles);
        all.surfaces.append(&mut pieces.surfaces);
        all.weights.append(&mut pieces.weights);
        all.mask_planes.append(&mut pieces.mask_planes);
        all.veils.extend(pieces.veils.into_iter().map(|(piece, veil)| (piece + before, veil)));
        all.sources.append(&mut pieces.sources);
        all.tally = all.tally.join(pieces.tally);
    }
    let Pieces { triangles, surfaces, weights, mask_planes, tally, veils: of_pieces, sources } = all;
    veils.take_pieces(triangles.len(), of_pieces, sources);
    let (width, height) = (frame.width, frame.height);
    Ok(PreparedTriangles { triangles, surfaces, mask_planes, masks, veils, weights, width, height, tally })
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
        (masks, veils): (&Masks, &Veils),
        shown: &[HalfSpace; 5],
        triangle: usize,
    ) -> Result<(), RenderError> {
        let mask = masks.of_material[scene.triangle_material[triangle] as usize];
        let veil = veils.of_material(scene.triangle_material[triangle]);
        let flat = mask == NO_MASK && veil.is_none();
        let uv = if flat { [[0.0; 2]; 3] } else { mask_coordinates(scene, triangle)? };
        let alpha = veil.map_or([1.0; 3], |_| veils.alphas(scene, triangle));
        let corners: [Corner; 3] = [0, 1, 2].map(|i| {
            let vertex = &scene.vertices[scene.triangles[triangle][i] as usize];
            let [x, y, z] = frame.light_space(vertex.position.map(f64::from));
            [x, y, z, uv[i][0], uv[i][1], alpha[i]]
        });
        let project = |c: &Corner| Projected::new(frame.on_map([c[0], c[1], c[2]]));
        let whole = corners.iter().all(|c| c[2] >= frame.near && !project(c).is_outside());
        let polygon = if whole { corners.to_vec() } else { clip(corners.to_vec(), shown) };
        if polygon.is_empty() {
            self.tally.uncovering += 1;
        }
        for i in 2..polygon.len() {
            let corners = [polygon[0], polygon[i - 1], polygon[i]];
            let before = self.triangles.len();
            self.add_piece(
                &corners,
                &corners.map(|c| project(&c)),
                (mask, veil),
                [frame.width, frame.height],
            );
            if !veils.is_empty() && self.triangles.len() > before {
                self.sources.push(triangle as u32);
            }
        }
        Ok(())
    }

    fn add_piece(
        &mut self,
        corners: &[Corner; 3],
        vertices: &[Projected; 3],
        (mask, veil): (u32, Option<u32>),
        size: [u32; 2],
    ) {
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
        if let Some(material) = veil {
            let [u, v, alpha] = [3, 4, 5].map(|k| plane(corners.map(|c| c[k])));
            self.veils.push((self.triangles.len() as u32, Veil { u, v, alpha, material }));
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
        let range = start as usize..end;
        for (&key, out) in band.keys[range.clone()].iter().zip(&mut out[range]) {
            let (depth, index) = ((key >> 32) as f64, key as u32 as usize);
            let depth = depth / f64::from(1u32 << DEPTH_BITS);
            let (triangle, plane) = (&triangles[index], &weights[index]);
            let [x0, y0, ..] = triangle.bounds.map(u32::from);
            // A sliver's far side may have none.
            let weight = plane.at(x - x0, y - y0).max(1) as f64;
            let along = |k: usize| (triangle.depth.step[k] as f64 - depth * plane.step[k] as f64) / weight;
            *out = [along(0) as f32, along(1) as f32];
        }
    }
}
