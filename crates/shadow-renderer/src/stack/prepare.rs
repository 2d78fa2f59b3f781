//! From a scene to snapped triangles with exact coverage: the one input of both backends.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use scenes::Scene;

use crate::stack::fixed_point::{DEPTH_BITS, MaskPlanes, Masks, Plane};
use crate::stack::perspective;
use crate::stack::veils::{Casters, Veils};
use crate::{LightFrame, RenderError};

/// Sub-texel steps per texel to which vertices are snapped.
pub(crate) const SUBTEXELS: i32 = 256;
/// Largest distance from the map's origin, in texels, at which edge functions stay exact in the shader.
pub(super) const GUARD_TEXELS: u32 = 16384;
/// Marks a triangle without alpha mask.
pub(crate) const NO_MASK: u32 = u32::MAX;

/// Triangles set up by one task.
const CHUNK: usize = 1 << 12;

/// Coverage and depth of one triangle on the texel grid.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Zeroable)]
pub(crate) struct PreparedTriangle {
    /// Corners in units of 1/256 texel, as [`clockwise`] orders them, whichever side faces the light.
    pub corners: [[i32; 2]; 3],
    /// Depth, relative to the first texel of `bounds`.
    pub depth: Plane,
    /// Least depth of a corner in units of 2^-24.
    pub depth_low: u32,
    /// Greatest depth of a corner in units of 2^-24.
    pub depth_high: u32,
    /// Texels whose centre may be covered: x0, y0 inclusive, x1, y1 exclusive, inside the map.
    pub bounds: [u16; 4],
    /// Index into [`PreparedTriangles::mask_planes`] or [`NO_MASK`].
    pub mask: u32,
}

impl PreparedTriangle {
    /// Stands for a triangle that covers nothing, so that triangles keep the scene's indices.
    const DROPPED: Self = Self {
        corners: [[0; 2]; 3],
        depth: Plane { base: 0, step: [0; 2] },
        depth_low: 0,
        depth_high: 0,
        bounds: [0; 4],
        mask: NO_MASK,
    };
}

/// What the fragments of a triangle share; apart from [`PreparedTriangle`], as the last step needs nothing else and
/// wants it close together.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Zeroable)]
pub(crate) struct Surface {
    /// d depth / d texel x, d texel y.
    pub gradient: [f32; 2],
    /// 1 if the geometric front side points to the light, else 0.
    pub light_facing: u32,
}

/// A vertex on the texel grid.
#[derive(Clone, Copy)]
pub(super) struct Projected {
    /// Texel coordinates and depth.
    pub exact: [f64; 3],
    /// Texel coordinates in units of 1/256 texel.
    snapped: [i32; 2],
}

impl Projected {
    pub(super) fn new(exact: [f64; 3]) -> Self {
        Self { exact, snapped: [snap(exact[0]), snap(exact[1])] }
    }

    /// Whether edge functions of this vertex would not be exact.
    pub(super) fn is_outside(&self) -> bool {
        let [x, y, depth] = self.exact;
        !(x.is_finite()
            && y.is_finite()
            && depth.is_finite()
            && x.abs().max(y.abs()) <= f64::from(GUARD_TEXELS))
    }
}

/// All triangles of a scene, in its order; in perspective their visible pieces.
#[derive(Clone, Debug)]
pub(crate) struct PreparedTriangles {
    pub triangles: Vec<PreparedTriangle>,
    pub surfaces: Vec<Surface>,
    pub mask_planes: Vec<MaskPlanes>,
    pub masks: Masks,
    /// Opacities, where surfaces are translucent.
    pub veils: Veils,
    /// In perspective, one a triangle, by which depth and mask planes are divided; empty otherwise.
    pub weights: Vec<Plane>,
    pub width: u32,
    pub height: u32,
    pub(super) tally: Tally,
}

/// What became of some triangles.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    pub degenerate: usize,
    pub uncovering: usize,
    /// Sum of twice the areas in squared sub-texels, each at most that of the bounds; saturating.
    area_twice: u64,
}

impl Tally {
    pub(super) fn join(self, other: Self) -> Self {
        Self {
            degenerate: self.degenerate + other.degenerate,
            uncovering: self.uncovering + other.uncovering,
            area_twice: self.area_twice.saturating_add(other.area_twice),
        }
    }
}

impl PreparedTriangles {
    /// Projects, snaps and sets up all triangles of `scene`.
    ///
    /// Coverage comes from corners snapped to 1/[`SUBTEXELS`] texel. Depth, gradient and side come from the corners
    /// before snapping, so that coplanar triangles keep one plane; a sliver whose area snapping more than doubled
    /// or turned over takes them from the snapped corners instead.
    ///
    /// # Errors
    /// [`RenderError::Scene`] (no triangles, dangling index, value that is not finite, malformed
    /// mask), [`RenderError::MapSize`], [`RenderError::GuardBand`] if a vertex lies over 16384 texels off.
    pub(crate) fn new(scene: &Scene, frame: &LightFrame) -> Result<Self, RenderError> {
        Self::of_casters(scene, frame, Casters::Opaque)
    }

    /// The same with surfaces as `casters` has them.
    pub(crate) fn of_casters(
        scene: &Scene,
        frame: &LightFrame,
        casters: Casters,
    ) -> Result<Self, RenderError> {
        crate::light_frame::check_size(frame.width, frame.height)?;
        scene.check()?;
        Self::of_checked(scene, frame, casters)
    }

    /// The same for a scene that passed [`Scene::check`] and a frame of supported
    /// size.
    pub(crate) fn of_checked(
        scene: &Scene,
        frame: &LightFrame,
        casters: Casters,
    ) -> Result<Self, RenderError> {
        let masks = Masks::of_casters(scene, casters)?;
        let mut veils = Veils::new(scene, casters)?;
        if frame.eye.is_some() {
            return perspective::prepare(scene, frame, masks, veils);
        }
        let projected = project(scene, frame)?;
        let count = scene.triangles.len();
        let mut triangles: Vec<PreparedTriangle> = crate::stack::memory::zeroed("the triangles", count)?;
        let mut surfaces: Vec<Surface> = crate::stack::memory::zeroed("the triangles", count)?;
        let size = [frame.width, frame.height];
        let input = scene.triangles.par_chunks(CHUNK).zip(scene.triangle_material.par_chunks(CHUNK));
        let output = triangles.par_chunks_mut(CHUNK).zip(surfaces.par_chunks_mut(CHUNK));
        let tally = input
            .zip(output)
            .map(|((corners, materials), (triangles, surfaces))| {
                let mut tally = Tally::default();
                let input = corners.iter().zip(materials);
                for ((corners, &material), (triangle, surface)) in
                    input.zip(triangles.iter_mut().zip(surfaces))
                {
                    let corners = corners.map(|i| projected[i as usize]);
                    let mask = masks.of_material[material as usize];
                    match set_up(&corners, mask, size, &mut tally) {
                        Some(prepared) => (*triangle, *surface) = prepared,
                        None => *triangle = PreparedTriangle::DROPPED,
                    }
                }
                tally
            })
            .reduce(Tally::default, Tally::join);
        let mut mask_planes = Vec::new();
        if !masks.entries.is_empty() {
            mask_planes = set_up_masks(scene, &projected, &mut triangles)?;
        }
        veils.set_up(scene, &projected, &triangles)?;
        let [width, height] = size;
        Ok(Self { triangles, surfaces, mask_planes, masks, veils, weights: Vec::new(), width, height, tally })
    }

    /// Triangles dropped because their area is zero after snapping.
    pub(crate) fn degenerate(&self) -> usize {
        self.tally.degenerate
    }

    /// Triangles dropped because they lie off the map or between texel centres.
    pub(crate) fn uncovering(&self) -> usize {
        self.tally.uncovering
    }

    /// Expected number of fragments from the triangles' areas, each at most its bounds; masks are ignored.
    pub(crate) fn estimated_fragments(&self) -> u64 {
        self.tally.area_twice / AREA_TWICE_OF_TEXEL
    }
}

/// All vertices on the texel grid.
fn project(scene: &Scene, frame: &LightFrame) -> Result<Vec<Projected>, RenderError> {
    let any_outside = AtomicBool::new(false);
    let mut projected = Vec::with_capacity(scene.vertices.len());
    crate::stack::memory::prefer_huge_pages(&projected);
    scene
        .vertices
        .par_iter()
        .map(|v| {
            let vertex = Projected::new(frame.project(v.position.map(f64::from)));
            if vertex.is_outside() {
                any_outside.store(true, Ordering::Relaxed);
            }
            vertex
        })
        .collect_into_vec(&mut projected);
    if any_outside.into_inner() {
        // A vertex without triangles may lie anywhere.
        let strays = |&i: &u32| projected[i as usize].is_outside();
        let triangle = scene.triangles.par_iter().find_first(|t| t.iter().any(strays));
        if let Some(&vertex) = triangle.and_then(|t| t.iter().find(|i| strays(i))) {
            let (vertex, [x, y, _]) = (vertex as usize, projected[vertex as usize].exact);
            return Err(RenderError::GuardBand { vertex, x, y, limit: GUARD_TEXELS });
        }
    }
    Ok(projected)
}

/// Twice the signed area in squared sub-texels, positive if clockwise on the map (y downwards).
pub(crate) fn area_twice(c: [[i32; 2]; 3]) -> i64 {
    let d = |i: usize, k: usize| i64::from(c[i][k]) - i64::from(c[0][k]);
    d(1, 0) * d(2, 1) - d(1, 1) * d(2, 0)
}

fn area_twice_f64(c: [[f64; 2]; 3]) -> f64 {
    (c[1][0] - c[0][0]) * (c[2][1] - c[0][1]) - (c[1][1] - c[0][1]) * (c[2][0] - c[0][0])
}

/// The same corners clockwise on the map (positive area with y downwards), the topmost first and of two topmost ones
/// the left one; `area` is theirs.
///
/// Then the first side is a right or a top one, the last a left one, and the middle one a left, right or bottom one.
#[inline]
pub(crate) fn clockwise([a, b, c]: [[i32; 2]; 3], area: i64) -> [[i32; 2]; 3] {
    let [b, c] = if area > 0 { [b, c] } else { [c, b] };
    let above = |p: [i32; 2], q: [i32; 2]| [p[1], p[0]] < [q[1], q[0]];
    let [a, b, c] = if above(b, a) && !above(c, b) { [b, c, a] } else { [a, b, c] };
    if above(c, a) { [c, a, b] } else { [a, b, c] }
}

/// Twice the area of a texel in squared sub-texels.
const AREA_TWICE_OF_TEXEL: u64 = 2 * (SUBTEXELS * SUBTEXELS) as u64;

/// `None` for a triangle that covers no texel centre by its area or bounds.
#[inline]
pub(super) fn set_up(
    vertices: &[Projected; 3],
    mask: u32,
    size: [u32; 2],
    tally: &mut Tally,
) -> Option<(PreparedTriangle, Surface)> {
    let corners = vertices.map(|v| v.snapped);
    let area = area_twice(corners);
    if area == 0 {
        tally.degenerate += 1;
        return None;
    }
    let mut bounds = [0; 4];
    for (k, size) in size.into_iter().enumerate() {
        let low = corners[0][k].min(corners[1][k]).min(corners[2][k]);
        let high = corners[0][k].max(corners[1][k]).max(corners[2][k]);
        let half = SUBTEXELS / 2;
        let first = (low - half + SUBTEXELS - 1).div_euclid(SUBTEXELS).max(0);
        let end = ((high - half).div_euclid(SUBTEXELS) + 1).min(size as i32);
        if first >= end {
            tally.uncovering += 1;
            return None;
        }
        (bounds[k], bounds[k + 2]) = (first as u16, end as u16);
    }
    let box_texels = u64::from(bounds[2] - bounds[0]) * u64::from(bounds[3] - bounds[1]);
    let area_of_bounds = box_texels * AREA_TWICE_OF_TEXEL;
    tally.area_twice = tally.area_twice.saturating_add(area.unsigned_abs().min(area_of_bounds));
    let plane_corners = plane_corners(vertices);
    let reference = [f64::from(bounds[0]) + 0.5, f64::from(bounds[1]) + 0.5];
    let z = vertices.map(|v| v.exact[2]);
    let (value, gradient) = plane_through(plane_corners, z, reference);
    let fixed_depth = |z: f64| (z * f64::from(1u32 << DEPTH_BITS) + 0.5) as u32; // negative becomes 0
    let (low, high) = (z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2]));
    let triangle = PreparedTriangle {
        corners: clockwise(corners, area),
        depth: Plane::new(value, gradient),
        depth_low: fixed_depth(low).min(1 << DEPTH_BITS),
        depth_high: fixed_depth(high).min(1 << DEPTH_BITS),
        bounds,
        mask,
    };
    // The frame (right, down, forward) is right-handed and scenes wind counter-clockwise seen from the front,
    // so the front normal's forward component has the sign of this area: negative points at the light.
    let light_facing = u32::from(area_twice_f64(plane_corners) < 0.0);
    Some((triangle, Surface { gradient: gradient.map(|g| g as f32), light_facing }))
}

/// Corners before snapping, unless snapping changed the area too much for the plane through them to be of use.
#[inline]
pub(super) fn plane_corners(vertices: &[Projected; 3]) -> [[f64; 2]; 3] {
    let exact = vertices.map(|v| [v.exact[0], v.exact[1]]);
    let snapped = vertices.map(|v| v.snapped.map(|c| f64::from(c) / f64::from(SUBTEXELS)));
    // The quotient of the areas is at least one half; multiplied out, as divisions are slow.
    let area = area_twice_f64(snapped);
    if area_twice_f64(exact) * area >= 0.5 * area * area { exact } else { snapped }
}

/// Planes of all masked triangles in their order; `mask` becomes the index of the planes.
fn set_up_masks(
    scene: &Scene,
    projected: &[Projected],
    triangles: &mut [PreparedTriangle],
) -> Result<Vec<MaskPlanes>, RenderError> {
    let mut mask_planes = Vec::new();
    for (source, triangle) in triangles.iter_mut().enumerate().filter(|(_, t)| t.mask != NO_MASK) {
        let corners = scene.triangles[source].map(|i| i as usize);
        let uv = mask_coordinates(scene, source)?;
        let planes = set_up_mask(triangle, &corners.map(|i| projected[i]), uv);
        triangle.mask = mask_planes.len() as u32;
        mask_planes.push(planes);
    }
    Ok(mask_planes)
}

/// Texture coordinates of a masked triangle. Whole repetitions are taken off, they would waste bits of the fixed point.
pub(super) fn mask_coordinates(scene: &Scene, triangle: usize) -> Result<[[f64; 2]; 3], RenderError> {
    let uv = scene.triangles[triangle].map(|i| scene.vertices[i as usize].uv.map(f64::from));
    if !uv.iter().flatten().all(|c| c.is_finite()) {
        let what = format!("triangle {triangle} has texture coordinates that are not finite");
        return Err(scene.inconsistent(what).into());
    }
    let whole = uv[0].map(f64::floor);
    Ok(uv.map(|c| [0, 1].map(|k| c[k] - whole[k])))
}

fn set_up_mask(triangle: &PreparedTriangle, vertices: &[Projected; 3], uv: [[f64; 2]; 3]) -> MaskPlanes {
    let plane_corners = plane_corners(vertices);
    let reference = [f64::from(triangle.bounds[0]) + 0.5, f64::from(triangle.bounds[1]) + 0.5];
    let plane = |k: usize| {
        let (value, step) = plane_through(plane_corners, uv.map(|c| c[k]), reference);
        Plane::new(value, step)
    };
    MaskPlanes { u: plane(0), v: plane(1), mask: triangle.mask }
}

/// Nearest multiple of a sub-texel, halves rounded up; for magnitudes up to 2^15 texels.
pub(crate) fn snap(texels: f64) -> i32 {
    // Truncation of a positive number rounds down, without a call that the plainest x86-64 lacks.
    const POSITIVE: i32 = 1 << 24;
    // Wrapping serves vertices far off, of which nothing but the absence of a panic is asked.
    ((texels * f64::from(SUBTEXELS) + (f64::from(POSITIVE) + 0.5)) as i32).wrapping_sub(POSITIVE)
}

/// Value at `reference` and gradient of the linear function with the given values at the corners.
pub(super) fn plane_through(c: [[f64; 2]; 3], value: [f64; 3], reference: [f64; 2]) -> (f64, [f64; 2]) {
    let [dx1, dy1] = [c[1][0] - c[0][0], c[1][1] - c[0][1]];
    let [dx2, dy2] = [c[2][0] - c[0][0], c[2][1] - c[0][1]];
    let (v1, v2) = (value[1] - value[0], value[2] - value[0]);
    let per_area = 1.0 / (dx1 * dy2 - dy1 * dx2);
    let gradient = [(v1 * dy2 - v2 * dy1) * per_area, (dx1 * v2 - dx2 * v1) * per_area];
    let at = value[0] + gradient[0] * (reference[0] - c[0][0]) + gradient[1] * (reference[1] - c[0][1]);
    (at, gradient)
}
