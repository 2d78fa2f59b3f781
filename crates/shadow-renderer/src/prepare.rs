//! From a scene to snapped triangles with exact coverage: the one input of both backends.

use rayon::prelude::*;

use crate::fixed_point::{DEPTH_BITS, MaskPlanes, Masks, Plane};
use crate::{LightFrame, RenderError, Scene};

/// Sub-texel steps per texel to which vertices are snapped.
pub const SUBTEXELS: i32 = 256;
/// Largest distance from the map's origin, in texels, at which edge functions stay exact in the shader.
const GUARD_TEXELS: u32 = 16384;
/// Marks a triangle without alpha mask.
pub(crate) const NO_MASK: u32 = u32::MAX;

/// One triangle on the texel grid.
///
/// Corners run clockwise on the map (positive area with y downwards), whichever side faces the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PreparedTriangle {
    /// Corners in units of 1/256 texel.
    pub corners: [[i32; 2]; 3],
    /// Depth, relative to the first texel of `bounds`.
    pub depth: Plane,
    /// Least depth of a corner in units of 2^-24.
    pub depth_low: u32,
    /// Greatest depth of a corner in units of 2^-24.
    pub depth_high: u32,
    /// Texels whose centre may be covered: x0, y0 inclusive, x1, y1 exclusive, inside the map, not empty.
    pub bounds: [u16; 4],
    /// d depth / d texel x, d texel y.
    pub gradient: [f32; 2],
    /// Index into [`PreparedTriangles::mask_planes`] or [`NO_MASK`].
    pub mask: u32,
    /// Index of the triangle in the scene.
    pub source: u32,
    /// The geometric front side points to the light.
    pub light_facing: bool,
}

/// All triangles of a scene that may cover a texel, in the scene's order.
#[derive(Clone, Debug)]
pub struct PreparedTriangles {
    pub(crate) triangles: Vec<PreparedTriangle>,
    pub(crate) mask_planes: Vec<MaskPlanes>,
    pub(crate) masks: Masks,
    pub(crate) width: u32,
    pub(crate) height: u32,
    degenerate: usize,
    uncovering: usize,
}

impl PreparedTriangles {
    /// Projects, snaps and sets up all triangles of `scene`.
    ///
    /// Coverage comes from corners snapped to 1/[`SUBTEXELS`] texel. Depth, gradient and side come from the corners
    /// before snapping, so that coplanar triangles keep one plane; a sliver whose area snapping more than doubled
    /// or turned over takes them from the snapped corners instead.
    ///
    /// # Errors
    /// [`RenderError::EmptyScene`], [`RenderError::Scene`] (dangling index, value that is not finite, malformed
    /// mask), [`RenderError::MapSize`], [`RenderError::GuardBand`] if a vertex lies over 16384 texels off.
    pub fn new(scene: &Scene, frame: &LightFrame) -> Result<Self, RenderError> {
        crate::light_frame::check_size(frame.width, frame.height)?;
        check_scene(scene)?;
        Self::of_checked(scene, frame)
    }

    /// The same for a scene that passed [`check_scene`] and a frame of supported size.
    pub(crate) fn of_checked(scene: &Scene, frame: &LightFrame) -> Result<Self, RenderError> {
        let masks = Masks::new(scene)?;
        let projected: Vec<[f64; 3]> =
            scene.vertices.par_iter().map(|v| frame.project(v.position.map(f64::from))).collect();
        let outside = |p: &[f64; 3]| {
            !p.iter().all(|c| c.is_finite()) || p[0].abs().max(p[1].abs()) > f64::from(GUARD_TEXELS)
        };
        let strays = |t: &&[u32; 3]| t.iter().any(|&i| outside(&projected[i as usize]));
        if let Some(triangle) = scene.triangles.par_iter().find_first(strays) {
            let vertex = triangle.iter().map(|&i| i as usize).find(|&i| outside(&projected[i])).unwrap_or(0);
            let [x, y, _] = projected[vertex];
            return Err(RenderError::GuardBand { vertex, x, y, limit: GUARD_TEXELS });
        }
        let mut degenerate = 0;
        let mut triangles: Vec<PreparedTriangle> = Vec::new();
        (&scene.triangles, &scene.triangle_material)
            .into_par_iter()
            .enumerate()
            .map(|(index, (triangle, &material))| {
                let corners = triangle.map(|i| projected[i as usize]);
                let mask = masks.of_material[material as usize];
                set_up(corners, index as u32, mask, frame.width, frame.height)
            })
            .collect_into_vec(&mut triangles);
        // Compacting in place keeps the peak of memory low.
        triangles.retain(|t| {
            degenerate += usize::from(t.bounds == DEGENERATE);
            t.bounds != DEGENERATE && t.bounds != UNCOVERING
        });
        let mut mask_planes = Vec::new();
        for triangle in triangles.iter_mut().filter(|t| t.mask != NO_MASK) {
            let corners = scene.triangles[triangle.source as usize].map(|i| i as usize);
            let uv = corners.map(|i| scene.vertices[i].uv);
            if !uv.iter().flatten().all(|c| c.is_finite()) {
                let what =
                    format!("triangle {} has texture coordinates that are not finite", triangle.source);
                return Err(RenderError::Scene { scene: scene.name.clone(), what });
            }
            let planes = set_up_mask(triangle, corners.map(|i| projected[i]), uv);
            triangle.mask = mask_planes.len() as u32;
            mask_planes.push(planes);
        }
        let uncovering = scene.triangles.len() - degenerate - triangles.len();
        let (width, height) = (frame.width, frame.height);
        Ok(Self { triangles, mask_planes, masks, width, height, degenerate, uncovering })
    }

    /// Triangles that may cover a texel centre.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// True if no triangle covers a texel centre.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Triangles dropped because their area is zero after snapping.
    pub fn degenerate(&self) -> usize {
        self.degenerate
    }

    /// Triangles dropped because they lie off the map or between texel centres.
    pub fn uncovering(&self) -> usize {
        self.uncovering
    }

    /// Expected number of fragments from the triangles' areas, each at most its bounds; masks are ignored.
    pub fn estimated_fragments(&self) -> u64 {
        let texels: f64 = self
            .triangles
            .par_iter()
            .map(|t| {
                let area = 0.5 * area_twice(t.corners) as f64 / f64::from(SUBTEXELS * SUBTEXELS);
                let [x0, y0, x1, y1] = t.bounds.map(f64::from);
                area.min((x1 - x0) * (y1 - y0))
            })
            .sum();
        texels as u64
    }
}

/// Fails on dangling indices, lists of different lengths and positions that are not finite.
pub(crate) fn check_scene(scene: &Scene) -> Result<(), RenderError> {
    let fail = |what: String| Err(RenderError::Scene { scene: scene.name.clone(), what });
    if scene.triangles.is_empty() {
        return Err(RenderError::EmptyScene(scene.name.clone()));
    }
    if scene.triangles.len() > u32::MAX as usize {
        return fail(format!("{} triangles, more than 2^32 - 1", scene.triangles.len()));
    }
    let (triangles, materials) = (scene.triangles.len(), scene.triangle_material.len());
    if materials != triangles {
        return fail(format!("{triangles} triangles have {materials} material indices"));
    }
    let vertices = &scene.vertices;
    let broken =
        (&scene.triangles, &scene.triangle_material).into_par_iter().position_first(|(t, &material)| {
            let finite =
                |i: &u32| vertices.get(*i as usize).is_some_and(|v| v.position.iter().all(|c| c.is_finite()));
            material as usize >= scene.materials.len() || !t.iter().all(finite)
        });
    let Some(t) = broken else { return Ok(()) };
    let material = scene.triangle_material[t];
    if material as usize >= scene.materials.len() {
        return fail(format!("triangle {t} has material {material} of {}", scene.materials.len()));
    }
    for vertex in scene.triangles[t] {
        match vertices.get(vertex as usize) {
            None => return fail(format!("triangle {t} has vertex {vertex} of {}", vertices.len())),
            Some(v) if !v.position.iter().all(|c| c.is_finite()) => {
                return fail(format!("vertex {vertex} has position {:?}", v.position));
            }
            Some(_) => {}
        }
    }
    Ok(())
}

/// Twice the signed area in squared sub-texels, positive if clockwise on the map (y downwards).
pub(crate) fn area_twice(c: [[i32; 2]; 3]) -> i64 {
    let d = |i: usize, k: usize| i64::from(c[i][k]) - i64::from(c[0][k]);
    d(1, 0) * d(2, 1) - d(1, 1) * d(2, 0)
}

fn area_twice_f64(c: [[f64; 2]; 3]) -> f64 {
    (c[1][0] - c[0][0]) * (c[2][1] - c[0][1]) - (c[1][1] - c[0][1]) * (c[2][0] - c[0][0])
}

/// Bounds of a triangle to be dropped because its area is zero.
const DEGENERATE: [u16; 4] = [0; 4];
/// Bounds of a triangle to be dropped because they contain no texel centre.
const UNCOVERING: [u16; 4] = [1; 4];

fn set_up(projected: [[f64; 3]; 3], source: u32, mask: u32, width: u32, height: u32) -> PreparedTriangle {
    let mut corners = projected.map(|p| [snap(p[0]), snap(p[1])]);
    let dropped = |bounds| PreparedTriangle {
        corners,
        depth: Plane { base: 0, step: [0; 2] },
        depth_low: 0,
        depth_high: 0,
        bounds,
        gradient: [0.0; 2],
        mask,
        source,
        light_facing: false,
    };
    let area = area_twice(corners);
    if area == 0 {
        return dropped(DEGENERATE);
    }
    let mut bounds = [0; 4];
    for (k, size) in [width, height].into_iter().enumerate() {
        let low = corners.iter().map(|c| c[k]).fold(i32::MAX, i32::min);
        let high = corners.iter().map(|c| c[k]).fold(i32::MIN, i32::max);
        let half = SUBTEXELS / 2;
        let first = (low - half + SUBTEXELS - 1).div_euclid(SUBTEXELS).max(0);
        let end = ((high - half).div_euclid(SUBTEXELS) + 1).min(size as i32);
        if first >= end {
            return dropped(UNCOVERING);
        }
        (bounds[k], bounds[k + 2]) = (first as u16, end as u16);
    }
    let plane_corners = plane_corners(projected, corners);
    let reference = [f64::from(bounds[0]) + 0.5, f64::from(bounds[1]) + 0.5];
    let z = projected.map(|p| p[2]);
    let (value, gradient) = plane_through(plane_corners, z, reference);
    let fixed_depth = |z: f64| (z * f64::from(1u32 << DEPTH_BITS) + 0.5) as u32; // negative becomes 0
    let (low, high) = (z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2]));
    if area < 0 {
        corners.swap(1, 2);
    }
    PreparedTriangle {
        corners,
        depth: Plane::new(value, gradient),
        depth_low: fixed_depth(low).min(1 << DEPTH_BITS),
        depth_high: fixed_depth(high).min(1 << DEPTH_BITS),
        bounds,
        gradient: gradient.map(|g| g as f32),
        mask,
        source,
        // The frame (right, down, forward) is right-handed and scenes wind counter-clockwise seen from the front,
        // so the front normal's forward component has the sign of this area: negative points at the light.
        light_facing: area_twice_f64(plane_corners) < 0.0,
    }
}

/// Corners before snapping, unless snapping changed the area too much for the plane through them to be of use.
fn plane_corners(projected: [[f64; 3]; 3], snapped: [[i32; 2]; 3]) -> [[f64; 2]; 3] {
    let exact = projected.map(|p| [p[0], p[1]]);
    let snapped = snapped.map(|c| c.map(|v| f64::from(v) / f64::from(SUBTEXELS)));
    // The quotient of the areas is at least one half; multiplied out, as divisions are slow.
    let area = area_twice_f64(snapped);
    if area_twice_f64(exact) * area >= 0.5 * area * area { exact } else { snapped }
}

fn set_up_mask(triangle: &PreparedTriangle, projected: [[f64; 3]; 3], uv: [[f32; 2]; 3]) -> MaskPlanes {
    // Undo the swap so that snapped and projected corners correspond.
    let corners = projected.map(|p| [snap(p[0]), snap(p[1])]);
    let plane_corners = plane_corners(projected, corners);
    let reference = [f64::from(triangle.bounds[0]) + 0.5, f64::from(triangle.bounds[1]) + 0.5];
    let plane = |k: usize| {
        // Whole repetitions are taken off first, they would waste bits of the fixed point.
        let whole = f64::from(uv[0][k]).floor();
        let (value, step) = plane_through(plane_corners, uv.map(|c| f64::from(c[k]) - whole), reference);
        Plane::new(value, step)
    };
    MaskPlanes { u: plane(0), v: plane(1), mask: triangle.mask }
}

/// Nearest multiple of a sub-texel, halves rounded up; for magnitudes up to 2^15 texels.
pub(crate) fn snap(texels: f64) -> i32 {
    // Truncation of a positive number rounds down, without a call that the plainest x86-64 lacks.
    const POSITIVE: i32 = 1 << 24;
    (texels * f64::from(SUBTEXELS) + (f64::from(POSITIVE) + 0.5)) as i32 - POSITIVE
}

/// Value at `reference` and gradient of the linear function with the given values at the corners.
fn plane_through(c: [[f64; 2]; 3], value: [f64; 3], reference: [f64; 2]) -> (f64, [f64; 2]) {
    let [dx1, dy1] = [c[1][0] - c[0][0], c[1][1] - c[0][1]];
    let [dx2, dy2] = [c[2][0] - c[0][0], c[2][1] - c[0][1]];
    let (v1, v2) = (value[1] - value[0], value[2] - value[0]);
    let per_area = 1.0 / (dx1 * dy2 - dy1 * dx2);
    let gradient = [(v1 * dy2 - v2 * dy1) * per_area, (dx1 * v2 - dx2 * v1) * per_area];
    let at = value[0] + gradient[0] * (reference[0] - c[0][0]) + gradient[1] * (reference[1] - c[0][1]);
    (at, gradient)
}
