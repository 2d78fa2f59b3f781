//! What the shader works on: triangles in its memory layout, and rectangles of at most 16 x 16 texels.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use crate::stack::edges::edges;
use crate::stack::fixed_point::Plane;
use crate::stack::prepare::{NO_MASK, PreparedTriangle, PreparedTriangles};

/// Largest side of an [`Item`] in texels.
const TILE: u32 = 16;
/// Beyond this magnitude an edge function cannot change its sign within a tile: corners lie within 2^22 of the
/// origin, so it changes by at most `2 * 2^23 * 15 < 2^28`.
const EDGE_LIMIT: i64 = 1 << 29;

/// `Triangle` in fragments.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct GpuTriangle {
    depth: [i64; 3],
    corners: [[i32; 2]; 3],
    depth_low: u32,
    depth_high: u32,
    reference: u32,
    mask: u32,
}

/// `MaskPlanes` in fragments.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct GpuMaskPlanes {
    u: [i64; 3],
    v: [i64; 3],
    width: u32,
    height: u32,
    first_bit: u32,
    padding: u32,
}

/// `Item` in fragments.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Item {
    triangle: u32,
    origin: u32,
    size: u32,
    edges: [i32; 3],
}

fn words(plane: Plane) -> [i64; 3] {
    [plane.base, plane.step[0], plane.step[1]]
}

fn pack(low: u32, high: u32) -> u32 {
    low | high << 16
}

/// Triangles of one chunk, the mask planes they use, indices made relative to the chunk, and in perspective their weights.
pub(crate) fn gpu_triangles(
    prepared: &PreparedTriangles,
    chunk: std::ops::Range<usize>,
) -> (Vec<GpuTriangle>, Vec<GpuMaskPlanes>, Vec<[i64; 3]>) {
    let weights = prepared.weights.get(chunk.clone()).unwrap_or_default();
    let weights = weights.iter().map(|&weight| words(weight)).collect();
    let triangles = &prepared.triangles[chunk];
    // Mask planes stand in the order of their triangles.
    let masked = || triangles.iter().filter(|t| t.mask != NO_MASK).map(|t| t.mask);
    let first_mask = masked().next().unwrap_or(0);
    let planes = masked().map(|index| {
        let planes = &prepared.mask_planes[index as usize];
        let entry = prepared.masks.entries[planes.mask as usize];
        GpuMaskPlanes {
            u: words(planes.u),
            v: words(planes.v),
            width: entry.width,
            height: entry.height,
            first_bit: entry.first_bit,
            padding: 0,
        }
    });
    let planes = planes.collect();
    let triangles = triangles.par_iter().map(|t| GpuTriangle {
        depth: words(t.depth),
        corners: t.corners,
        depth_low: t.depth_low,
        depth_high: t.depth_high,
        reference: pack(u32::from(t.bounds[0]), u32::from(t.bounds[1])),
        mask: if t.mask == NO_MASK { NO_MASK } else { t.mask - first_mask },
    });
    (triangles.collect(), planes, weights)
}

/// Rectangles of the triangles of one chunk within rows `rows` that may hold covered texels.
pub(crate) fn items(triangles: &[PreparedTriangle], rows: std::ops::Range<u32>) -> Vec<Item> {
    triangles
        .par_iter()
        .enumerate()
        .fold(Vec::new, |mut items, (index, triangle)| {
            add_items(triangle, index as u32, &rows, &mut items);
            items
        })
        .reduce(Vec::new, |mut a, mut b| {
            if a.is_empty() {
                return b;
            }
            a.append(&mut b);
            a
        })
}

fn add_items(triangle: &PreparedTriangle, index: u32, rows: &std::ops::Range<u32>, items: &mut Vec<Item>) {
    let [x0, y0, x1, y1] = triangle.bounds.map(u32::from);
    let (y0, y1) = (y0.max(rows.start), y1.min(rows.end));
    if y0 >= y1 {
        return;
    }
    let edges = edges(triangle);
    for y in (y0..y1).step_by(TILE as usize) {
        for x in (x0..x1).step_by(TILE as usize) {
            let (width, height) = (TILE.min(x1 - x), TILE.min(y1 - y));
            let at_origin = edges.map(|e| e.a * i64::from(x) + e.b * i64::from(y) + e.c);
            let may_cover = edges.iter().zip(at_origin).all(|(e, value)| {
                value + e.a.max(0) * i64::from(width - 1) + e.b.max(0) * i64::from(height - 1) >= 0
            });
            if may_cover {
                items.push(Item {
                    triangle: index,
                    origin: pack(x, y),
                    size: pack(width, height),
                    edges: at_origin.map(|e| e.clamp(-EDGE_LIMIT, EDGE_LIMIT) as i32),
                });
            }
        }
    }
}

/// Upper bound on the fragments of `items`.
pub(crate) fn most_fragments(items: &[Item]) -> u64 {
    items.iter().map(|i| u64::from(i.size & 0xffff) * u64::from(i.size >> 16)).sum()
}
